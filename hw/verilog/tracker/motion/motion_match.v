// SPDX-License-Identifier: Apache-2.0
// Whose is an event? Compares it with the boxes and windows of all slots: docs/motion.md, "The owner of an event".
//
// `hit` is the comparison, in registers; the owner follows from it combinationally: the lowest visible slot whose box holds the event,
// else the lowest visible one by its window, else the lowest candidate by its window, else the lowest free slot that may begin.
//
// Latency:    1 clock from asked to the owner.
// Throughput: an event per clock.
// Stall:      while asked is low, the result stays.
// Reset:      none: a slot that is neither visible nor a candidate holds nothing.
// Combinational paths: none; the outputs follow from registers.
`default_nettype none

module motion_match #(
    parameter N      = 8,   // slots
    parameter X_W    = 9,   // bits of an x address
    parameter Y_W    = 9,   // bits of a y address
    parameter PX_W   = 13,  // bits of a bound in pixels, signed
    parameter SLOT_W = 3    // bits of a slot number
) (
    input  wire              clk,

    input  wire              asked,
    input  wire [X_W-1:0]    x,
    input  wire [Y_W-1:0]    y,
    input  wire [N-1:0]      visible,
    input  wire [N-1:0]      candidate,
    input  wire [N-1:0]      may_begin,   // free, and seeded

    // box and window of a slot: lo and hi on x, lo and hi on y
    input  wire              place,
    input  wire [SLOT_W-1:0] place_slot,
    input  wire [4*PX_W-1:0] box,
    input  wire [4*PX_W-1:0] window,

    output wire              owned,       // else it is nobody's
    output wire              begins,      // in this slot a candidate does
    output wire              shared,      // among several visible ones
    output wire [SLOT_W-1:0] owner
);

    reg [N-1:0] by_box, by_window, by_candidate, free;

    wire signed [PX_W-1:0] at_x = {{(PX_W - X_W) {1'b0}}, x};
    wire signed [PX_W-1:0] at_y = {{(PX_W - Y_W) {1'b0}}, y};

    genvar i;
    generate
        for (i = 0; i < N; i = i + 1) begin : g_slot
            reg signed [PX_W-1:0] box_lo_x, box_hi_x, box_lo_y, box_hi_y;
            reg signed [PX_W-1:0] lo_x, hi_x, lo_y, hi_y;
            wire in_box    = box_lo_x <= at_x && at_x <= box_hi_x && box_lo_y <= at_y && at_y <= box_hi_y;
            wire in_window = lo_x <= at_x && at_x <= hi_x && lo_y <= at_y && at_y <= hi_y;

            always @(posedge clk) begin
                if (place && place_slot == i[SLOT_W-1:0]) begin
                    {box_lo_x, box_hi_x, box_lo_y, box_hi_y} <= box;
                    {lo_x, hi_x, lo_y, hi_y} <= window;
                end
                if (asked) begin
                    by_box[i]       <= visible[i] && in_box;
                    by_window[i]    <= visible[i] && in_window;
                    by_candidate[i] <= candidate[i] && in_window;
                    free[i]         <= may_begin[i];
                end
            end
        end
    endgenerate

    wire [N-1:0] deciding = |by_box ? by_box : by_window;
    wire         seen     = |by_window;  // a box lies within its window
    wire         near     = |by_candidate;
    wire [N-1:0] among    = seen ? deciding : near ? by_candidate : free;

    assign shared = seen && |(deciding & (deciding - {{(N - 1) {1'b0}}, 1'b1}));
    assign begins = !seen && !near;

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_lowest (
        .asked (1'b1),
        .among (among),
        .any   (owned),
        .lowest(owner)
    );

endmodule

`default_nettype wire
