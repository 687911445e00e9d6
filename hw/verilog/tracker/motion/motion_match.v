// SPDX-License-Identifier: Apache-2.0
// Which slots' boxes and windows share a pixel with an interval on each axis, and whose is an event: docs/motion.md, rule O1.
//
// For an event the intervals are its address; a motion step asks for boxes. The owner is the lowest visible slot whose box holds the
// event, else the lowest visible one by its window, else the lowest candidate by its window, else the lowest free slot that may begin.
//
// Latency:    1 clock from the intervals to the slots, two more to the owner.
// Throughput: an event per clock.
// Stall:      none.
// Reset:      none: a slot that is neither visible nor a candidate owns nothing.
// Combinational paths: none.
`default_nettype none

module motion_match #(
    parameter N      = 8,   // slots
    parameter PX_W   = 13,  // bits of a bound in pixels, signed
    parameter SLOT_W = 3    // bits of a slot number
) (
    input  wire              clk,

    input  wire signed [PX_W-1:0] lo_x,
    input  wire signed [PX_W-1:0] hi_x,
    input  wire signed [PX_W-1:0] lo_y,
    input  wire signed [PX_W-1:0] hi_y,

    // a clock later
    output reg  [N-1:0]      box_x,       // whose box shares the interval on this axis
    output reg  [N-1:0]      box_y,
    output reg  [N-1:0]      window_x,
    output reg  [N-1:0]      window_y,
    input  wire [N-1:0]      visible,
    input  wire [N-1:0]      candidate,
    input  wire [N-1:0]      fresh,       // free, and without a track that may return: a candidate begins in one of these
    input  wire [N-1:0]      empty,       // free: or in one of these, if none is fresh

    // two clocks later
    input  wire              is_op,       // the owner is this one
    input  wire [SLOT_W-1:0] op_slot,

    // three clocks later
    output reg               owned,       // else it is nobody's
    output reg               begins,      // in this slot a candidate does
    output reg               shared,      // among several visible ones
    output reg  [SLOT_W-1:0] owner,

    // box and window of a slot, each: low and high on x, low and high on y
    input  wire              place,
    input  wire [SLOT_W-1:0] place_slot,
    input  wire [4*PX_W-1:0] box,
    input  wire [4*PX_W-1:0] window
);

    genvar i;
    generate
        for (i = 0; i < N; i = i + 1) begin : g_slot
            reg signed [PX_W-1:0] box_lo_x, box_hi_x, box_lo_y, box_hi_y;
            reg signed [PX_W-1:0] win_lo_x, win_hi_x, win_lo_y, win_hi_y;

            // Negative where the interval does not reach the bound: one carry chain each.
            wire [PX_W:0] to_box_x = {hi_x[PX_W-1], hi_x} - {box_lo_x[PX_W-1], box_lo_x};
            wire [PX_W:0] in_box_x = {box_hi_x[PX_W-1], box_hi_x} - {lo_x[PX_W-1], lo_x};
            wire [PX_W:0] to_box_y = {hi_y[PX_W-1], hi_y} - {box_lo_y[PX_W-1], box_lo_y};
            wire [PX_W:0] in_box_y = {box_hi_y[PX_W-1], box_hi_y} - {lo_y[PX_W-1], lo_y};
            wire [PX_W:0] to_win_x = {hi_x[PX_W-1], hi_x} - {win_lo_x[PX_W-1], win_lo_x};
            wire [PX_W:0] in_win_x = {win_hi_x[PX_W-1], win_hi_x} - {lo_x[PX_W-1], lo_x};
            wire [PX_W:0] to_win_y = {hi_y[PX_W-1], hi_y} - {win_lo_y[PX_W-1], win_lo_y};
            wire [PX_W:0] in_win_y = {win_hi_y[PX_W-1], win_hi_y} - {lo_y[PX_W-1], lo_y};
            wire unused = &{1'b0, to_box_x, in_box_x, to_box_y, in_box_y, to_win_x, in_win_x, to_win_y, in_win_y};

            always @(posedge clk) begin
                if (place && place_slot == i[SLOT_W-1:0]) begin
                    {box_lo_x, box_hi_x, box_lo_y, box_hi_y} <= box;
                    {win_lo_x, win_hi_x, win_lo_y, win_hi_y} <= window;
                end
                box_x[i]    <= !to_box_x[PX_W] && !in_box_x[PX_W];
                box_y[i]    <= !to_box_y[PX_W] && !in_box_y[PX_W];
                window_x[i] <= !to_win_x[PX_W] && !in_win_x[PX_W];
                window_y[i] <= !to_win_y[PX_W] && !in_win_y[PX_W];
            end
        end
    endgenerate

    // Of the kind that decides.
    reg  [N-1:0]      among;
    reg               seen, near;
    wire [N-1:0]      by_box       = visible & box_x & box_y;
    wire [N-1:0]      by_window    = visible & window_x & window_y;
    wire [N-1:0]      by_candidate = candidate & window_x & window_y;
    wire              any_among;
    wire [SLOT_W-1:0] lowest;

    always @(posedge clk) begin
        seen   <= |by_window;  // a box lies within its window
        near   <= |by_candidate;
        among  <= |by_box ? by_box : |by_window ? by_window : |by_candidate ? by_candidate : |fresh ? fresh : empty;
        owned  <= any_among;
        begins <= !seen && !near;
        shared <= seen && |(among & (among - {{(N - 1) {1'b0}}, 1'b1}));
        owner  <= is_op ? op_slot : lowest;
    end

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_lowest (
        .asked (1'b1),
        .among (among),
        .any   (any_among),
        .lowest(lowest)
    );

endmodule

`default_nettype wire
