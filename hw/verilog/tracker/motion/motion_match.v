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

    input  wire              asked,       // low: the answers do not count, and a simulator need not find them
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

    (* mem2reg *) reg signed [PX_W-1:0] box_lo_x [0:N-1];
    (* mem2reg *) reg signed [PX_W-1:0] box_hi_x [0:N-1];
    (* mem2reg *) reg signed [PX_W-1:0] box_lo_y [0:N-1];
    (* mem2reg *) reg signed [PX_W-1:0] box_hi_y [0:N-1];
    (* mem2reg *) reg signed [PX_W-1:0] win_lo_x [0:N-1];
    (* mem2reg *) reg signed [PX_W-1:0] win_hi_x [0:N-1];
    (* mem2reg *) reg signed [PX_W-1:0] win_lo_y [0:N-1];
    (* mem2reg *) reg signed [PX_W-1:0] win_hi_y [0:N-1];

    always @(posedge clk)
        if (place) begin
            {box_lo_x[place_slot], box_hi_x[place_slot], box_lo_y[place_slot], box_hi_y[place_slot]} <= box;
            {win_lo_x[place_slot], win_hi_x[place_slot], win_lo_y[place_slot], win_hi_y[place_slot]} <= window;
        end

    // Negative where the interval does not reach a bound: one carry chain each.
    function touch;
        input signed [PX_W-1:0] low, high, first, last;
        reg   signed [PX_W:0]   reaches, begins_before;
        begin
            reaches       = {high[PX_W-1], high} - {first[PX_W-1], first};
            begins_before = {last[PX_W-1], last} - {low[PX_W-1], low};
            touch         = !reaches[PX_W] && !begins_before[PX_W];
        end
    endfunction

    reg [N-1:0] on_box_x, on_box_y, on_window_x, on_window_y;

    always @* begin : compare
        integer i;
        i = 0;
        {on_box_x, on_box_y, on_window_x, on_window_y} = {(4 * N) {1'bx}};
        if (asked)
            for (i = 0; i < N; i = i + 1) begin
                on_box_x[i]    = touch(lo_x, hi_x, box_lo_x[i], box_hi_x[i]);
                on_box_y[i]    = touch(lo_y, hi_y, box_lo_y[i], box_hi_y[i]);
                on_window_x[i] = touch(lo_x, hi_x, win_lo_x[i], win_hi_x[i]);
                on_window_y[i] = touch(lo_y, hi_y, win_lo_y[i], win_hi_y[i]);
            end
    end

    always @(posedge clk) begin
        box_x    <= on_box_x;
        box_y    <= on_box_y;
        window_x <= on_window_x;
        window_y <= on_window_y;
    end

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
