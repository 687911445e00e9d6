// SPDX-License-Identifier: Apache-2.0
// Whose is an event? Compares it with the boxes and windows of all slots: docs/motion.md, "The owner of an event".
//
// The lowest visible slot whose box holds the event, else the lowest visible one by its window, else the lowest candidate by its window,
// else the lowest free slot that may begin. The comparison takes an interval on each axis, from lo to hi, and finds which slots
// share a pixel with it: for an event both are its address; motion_engine.v asks for boxes and windows.
//
// Latency:    1 clock from the interval to the slots that share it, two more to the owner.
// Throughput: an event per clock.
// Stall:      while hold is high, everything stays.
// Reset:      none: a slot that is neither visible nor a candidate holds nothing.
// Combinational paths: none.
`default_nettype none

module motion_match #(
    parameter N      = 8,   // slots
    parameter PX_W   = 13,  // bits of a bound in pixels, signed
    parameter SLOT_W = 3    // bits of a slot number
) (
    input  wire              clk,

    input  wire              hold,
    input  wire signed [PX_W-1:0] lo_x,
    input  wire signed [PX_W-1:0] hi_x,
    input  wire signed [PX_W-1:0] lo_y,
    input  wire signed [PX_W-1:0] hi_y,
    input  wire [N-1:0]      visible,
    input  wire [N-1:0]      candidate,
    input  wire [N-1:0]      may_begin,   // free, and seeded

    // a bound of a slot on both axes: low and high of the box, low and high of the window
    input  wire [3:0]        place,
    input  wire [SLOT_W-1:0] place_slot,
    input  wire [PX_W-1:0]   bound_x,
    input  wire [PX_W-1:0]   bound_y,

    output reg  [N-1:0]      box_x,       // whose box shares the interval on this axis
    output reg  [N-1:0]      box_y,
    output reg  [N-1:0]      window_x,
    output reg  [N-1:0]      window_y,

    output reg               owned,       // else it is nobody's
    output reg               begins,      // in this slot a candidate does
    output reg               shared,      // among several visible ones
    output reg  [SLOT_W-1:0] owner
);

    genvar i;
    generate
        for (i = 0; i < N; i = i + 1) begin : g_slot
            reg signed [PX_W-1:0] box_lo_x, box_hi_x, box_lo_y, box_hi_y;
            reg signed [PX_W-1:0] win_lo_x, win_hi_x, win_lo_y, win_hi_y;

            // Negative where the interval does not reach the bound: one carry chain each.
            wire [PX_W:0] to_box_x   = {hi_x[PX_W-1], hi_x} - {box_lo_x[PX_W-1], box_lo_x};
            wire [PX_W:0] in_box_x   = {box_hi_x[PX_W-1], box_hi_x} - {lo_x[PX_W-1], lo_x};
            wire [PX_W:0] to_box_y   = {hi_y[PX_W-1], hi_y} - {box_lo_y[PX_W-1], box_lo_y};
            wire [PX_W:0] in_box_y   = {box_hi_y[PX_W-1], box_hi_y} - {lo_y[PX_W-1], lo_y};
            wire [PX_W:0] to_win_x   = {hi_x[PX_W-1], hi_x} - {win_lo_x[PX_W-1], win_lo_x};
            wire [PX_W:0] in_win_x   = {win_hi_x[PX_W-1], win_hi_x} - {lo_x[PX_W-1], lo_x};
            wire [PX_W:0] to_win_y   = {hi_y[PX_W-1], hi_y} - {win_lo_y[PX_W-1], win_lo_y};
            wire [PX_W:0] in_win_y   = {win_hi_y[PX_W-1], win_hi_y} - {lo_y[PX_W-1], lo_y};
            wire unused = &{1'b0, to_box_x, in_box_x, to_box_y, in_box_y, to_win_x, in_win_x, to_win_y, in_win_y};

            always @(posedge clk) begin
                if (place_slot == i[SLOT_W-1:0]) begin
                    if (place[0]) {box_lo_x, box_lo_y} <= {bound_x, bound_y};
                    if (place[1]) {box_hi_x, box_hi_y} <= {bound_x, bound_y};
                    if (place[2]) {win_lo_x, win_lo_y} <= {bound_x, bound_y};
                    if (place[3]) {win_hi_x, win_hi_y} <= {bound_x, bound_y};
                end
                if (!hold) begin
                    box_x[i]    <= !to_box_x[PX_W] && !in_box_x[PX_W];
                    box_y[i]    <= !to_box_y[PX_W] && !in_box_y[PX_W];
                    window_x[i] <= !to_win_x[PX_W] && !in_win_x[PX_W];
                    window_y[i] <= !to_win_y[PX_W] && !in_win_y[PX_W];
                end
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

    always @(posedge clk)
        if (!hold) begin
            seen   <= |by_window;  // a box lies within its window
            near   <= |by_candidate;
            among  <= |by_box ? by_box : |by_window ? by_window : |by_candidate ? by_candidate : may_begin;
            owned  <= any_among;
            begins <= !seen && !near;
            shared <= seen && |(among & (among - {{(N - 1) {1'b0}}, 1'b1}));
            owner  <= lowest;
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
