// SPDX-License-Identifier: Apache-2.0
// One axis of all slots, as far as events change it: both sides, their offsets and marks, and where the event's bin and pixel are.
//
// An event passes four stages: its slot's words are read, compared with its place, its ways found, and the words written back. The engine reads and writes single
// words while no event is in these stages.
//
// Latency:    3 clocks from the event's slot to the writing of its words.
// Throughput: an event per clock, but of one slot every fourth clock.
// Stall:      none.
// Reset:      none, nothing is used before it was written.
// Combinational paths: none.
`default_nettype none
`include "motion_codes.vh"

module motion_axis_memory #(
    parameter SLOT_W = 3,
    parameter AT_W   = 9,    // bits of an address
    parameter SIDE_W = 25,   // bits of a side, 2^-12 px, signed
    parameter OFF_W  = 30,   // bits of an offset, likewise
    parameter PX_W   = 13,   // bits of a bound in pixels
    parameter REL_W  = 10,   // bits of a recentred address
    parameter W      = 48    // bits of the engine's words
) (
    input  wire              clk,

    // first stage: the slot that is read
    input  wire [SLOT_W-1:0] slot,

    // second stage: the engine's word, if wanted, which is there in the third; else 0
    input  wire [2:0]        index,
    input  wire              wanted,
    output reg  [W-1:0]      word,

    // second stage
    input  wire [AT_W-1:0]   place,
    input  wire [16:0]       out,
    input  wire [16:0]       back,

    // third stage
    output reg  [REL_W-1:0]  rel,        // place within the window

    // fourth stage
    input  wire              update,     // the event moves the sides
    input  wire [SLOT_W-1:0] update_slot,

    // a clock later
    output reg               in_bin,     // the event has a bin
    output reg  [3:0]        bin,

    // the engine writes
    input  wire              busy,
    input  wire              write,
    input  wire [SLOT_W-1:0] write_slot,
    input  wire [3:0]        target,
    input  wire [W-1:0]      data
);

    reg [SIDE_W-1:0] los    [0:(1<<SLOT_W)-1];
    reg [SIDE_W-1:0] his    [0:(1<<SLOT_W)-1];
    reg [OFF_W-1:0]  off_los[0:(1<<SLOT_W)-1];
    reg [OFF_W-1:0]  off_his[0:(1<<SLOT_W)-1];
    reg [1:0]        marks  [0:(1<<SLOT_W)-1];
    reg [1:0]        hides  [0:(1<<SLOT_W)-1];
    reg [4:0]        scales [0:(1<<SLOT_W)-1];
    reg [REL_W-1:0]  windows[0:(1<<SLOT_W)-1];

    reg signed [SIDE_W-1:0] lo, hi;
    reg signed [OFF_W-1:0]  off_lo, off_hi;
    reg [1:0]               mark, hide, mark_1, mark_2;
    reg [4:0]               scale, old_scale;
    reg [REL_W-1:0]         window;
    reg                     is_before;  // the event lies before the first bin
    reg [PX_W:0]            from, in_bins;

    always @(posedge clk) begin
        word <= {W{1'b0}};
        if (wanted) case ({1'b0, index})
            `EVCOT_MOTION_HOT_LO: word <= {{(W - SIDE_W) {lo[SIDE_W-1]}}, lo};
            `EVCOT_MOTION_HOT_HI: word <= {{(W - SIDE_W) {hi[SIDE_W-1]}}, hi};
            `EVCOT_MOTION_HOT_OFF_LO: word <= {{(W - OFF_W) {off_lo[OFF_W-1]}}, off_lo};
            `EVCOT_MOTION_HOT_OFF_HI: word <= {{(W - OFF_W) {off_hi[OFF_W-1]}}, off_hi};
            `EVCOT_MOTION_HOT_BEYOND: word <= {{(W - 2) {1'b0}}, ~mark};
            `EVCOT_MOTION_HOT_BINS: word <= {{(W - 5) {1'b0}}, scale};
            default: ;
        endcase
    end

    // The pixels from that of the low side: a - b - c is a + ~b + 1 - c, whose lowest bit here is the carry.
    wire [PX_W+1:0] place_from = {{(PX_W + 1 - AT_W) {1'b0}}, place, 1'b1} + ~{lo[SIDE_W-1], lo[SIDE_W-1:11]};
    wire [PX_W+REL_W-1:0] wide_place = {{(PX_W + REL_W - AT_W) {1'b0}}, place};  // its lower part is what counts

    wire [1:0]               beyond;
    wire signed [SIDE_W-1:0] lo_next, hi_next;
    wire signed [OFF_W-1:0]  off_lo_next, off_hi_next;

    motion_axis #(
        .AT_W  (AT_W),
        .SIDE_W(SIDE_W),
        .OFF_W (OFF_W)
    ) u_axis (
        .clk        (clk),
        .place      (place),
        .lo         (lo),
        .hi         (hi),
        .off_lo     (off_lo),
        .off_hi     (off_hi),
        .hidden     (hide),
        .out        (out),
        .back       (back),
        .beyond     (beyond),
        .lo_next    (lo_next),
        .hi_next    (hi_next),
        .off_lo_next(off_lo_next),
        .off_hi_next(off_hi_next)
    );

    // Bins of 2^n pixels, four to eight for the whole side.
    function [4:0] bin_log2;
        input [PX_W-1:0] length;
        integer k;
        begin
            bin_log2 = 5'd0;
            for (k = 4; k <= PX_W; k = k + 1) if (length[k-1]) bin_log2 = k[4:0] - 5'd3;
        end
    endfunction

    wire writes_lo     = write && target == `EVCOT_MOTION_HOT_LO;
    wire writes_hi     = write && target == `EVCOT_MOTION_HOT_HI;
    wire writes_off_lo = write && target == `EVCOT_MOTION_HOT_OFF_LO;
    wire writes_off_hi = write && target == `EVCOT_MOTION_HOT_OFF_HI;
    wire writes_marks  = write && target == `EVCOT_MOTION_HOT_BEYOND;
    wire [SLOT_W-1:0] to = !busy ? update_slot : write_slot;

    always @(posedge clk) begin
        lo     <= los[slot];
        hi     <= his[slot];
        off_lo <= off_los[slot];
        off_hi <= off_his[slot];
        mark   <= marks[slot];
        hide   <= hides[slot];
        scale  <= scales[slot];
        window <= windows[slot];

        from      <= place_from[PX_W+1:1];
        old_scale <= scale;
        mark_1    <= mark;
        mark_2    <= mark_1;
        rel       <= wide_place[REL_W-1:0] - window;

        in_bins   <= from >> old_scale;
        is_before <= from[PX_W];

        in_bin <= !is_before && in_bins[PX_W:4] == {(PX_W - 3) {1'b0}};
        bin    <= in_bins[3:0];

        if (update || writes_lo) los[to] <= !busy ? lo_next : data[SIDE_W-1:0];
        if (update || writes_hi) his[to] <= !busy ? hi_next : data[SIDE_W-1:0];
        if (update || writes_off_lo) off_los[to] <= !busy ? off_lo_next : data[OFF_W-1:0];
        if (update || writes_off_hi) off_his[to] <= !busy ? off_hi_next : data[OFF_W-1:0];
        if (update || writes_marks) marks[to] <= !busy ? mark_2 | beyond : data[1:0];
        if (write && target == `EVCOT_MOTION_HOT_HIDDEN) hides[write_slot] <= data[1:0];
        if (write && target == `EVCOT_MOTION_HOT_BINS) scales[write_slot] <= bin_log2(data[PX_W-1:0]);
        if (write && target == `EVCOT_MOTION_HOT_WLO) windows[write_slot] <= data[REL_W-1:0];
    end

    wire unused = &{1'b0, place_from[0], wide_place, data};

endmodule

`default_nettype wire
