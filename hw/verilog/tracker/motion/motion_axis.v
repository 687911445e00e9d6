// SPDX-License-Identifier: Apache-2.0
// One axis of all slots, as far as events change it: both sides and their marks (docs/motion.md, rule E3); and how far from the middle of
// its owner's box, and in which of its bins, an event lies.
//
// An event passes four stages here: the first reads what stays, the second the sides, the third moves them, the
// fourth finds the bin and writes the sides back. If one of the two events behind is of the same slot, they are forwarded to it.
// Whether an event is beyond a side is known last, so both places that the side may go to are kept, and chosen from in the next clock.
//
// In place of an event, what takes effect moves the sides by s_move_*, or nothing does, and the sides are only read.
//
// Latency:    from the slot's number: 2 clocks to rel, 3 to m_lo, m_hi and m_marks, 4 to the bin.
// Throughput: an event per clock.
// Stall:      none.
// Reset:      none, nothing is used before it was written.
// Combinational paths: none.
`default_nettype none

module motion_axis #(
    parameter SLOT_W = 3,
    parameter AT_W   = 9,    // bits of an address
    parameter SIDE_W = 25,   // bits of a side, 2^-12 px, signed
    parameter PX_W   = 13,   // bits of a bound in pixels
    parameter REL_W  = 10    // bits of a recentred address
) (
    input  wire                     clk,

    // first stage
    input  wire [SLOT_W-1:0]        slot,

    // second stage
    input  wire [AT_W-1:0]          place,
    input  wire [18:0]              out,        // way of a side that the event is beyond
    input  wire [16:0]              back,       // and of one that it is not
    input  wire                     forward,    // the slot is that of the third stage
    input  wire                     recent,     // or that of the fourth, which writes
    input  wire [SLOT_W-1:0]        slot_2,
    input  wire                     moves,      // no event: both sides move by s_move_*,
    input  wire                     rests,      // or stay
    input  wire                     fresh,      // both sides are 0, without marks: a new candidate's, which are not in effect

    // third stage
    input  wire                     update,     // the sides move
    input  wire                     effect,     // something takes effect: marks are added, the middle of the box is replaced
    input  wire                     clear,      // behind the event, no side is marked
    input  wire                     set_bins,   // the bins' size is replaced
    input  wire                     begins,     // a candidate does: the sides are 0 in the fourth stage
    input  wire [SLOT_W-1:0]        slot_3,
    output reg  [REL_W-1:0]         rel,        // place from that middle, half pixels

    // fourth stage: the slot as it is behind the event
    output wire [SIDE_W-1:0]        m_lo,
    output wire [SIDE_W-1:0]        m_hi,
    output wire [1:0]               m_marks,    // hi, lo: an event was beyond it since the last correction

    // what takes effect, all the time that it is in a stage; hidden sides are replaced in the first one
    input  wire                     hide_now,
    input  wire signed [SIDE_W-1:0] s_move_lo,
    input  wire signed [SIDE_W-1:0] s_move_hi,
    input  wire [1:0]               s_marks,
    input  wire [1:0]               s_hidden,
    input  wire [REL_W-1:0]         s_middle,   // half pixels
    input  wire [4:0]               s_log2,     // a bin has 2^log2 pixels

    // two clocks after the third stage
    output reg                      in_bin,     // the event has a bin
    output reg  [3:0]               bin
);

    localparam LOG2_W = PX_W < 20 ? 4 : 5;  // bits of log2 of a bin's pixels, at most PX_W - 4

    reg [SIDE_W-1:0] los    [0:(1<<SLOT_W)-1];
    reg [SIDE_W-1:0] his    [0:(1<<SLOT_W)-1];
    reg [1:0]        markses[0:(1<<SLOT_W)-1];
    reg [1:0]        hides  [0:(1<<SLOT_W)-1];
    reg [LOG2_W-1:0] log2s  [0:(1<<SLOT_W)-1];
    reg [REL_W-1:0]  middles[0:(1<<SLOT_W)-1];

    reg [1:0]      hide;
    reg [AT_W-1:0] at;
    reg [LOG2_W-1:0] log2_3, log2_4;
    reg [SLOT_W-1:0] slot_4;
    reg            update_4, clear_4, begins_4;
    reg signed [SIDE_W-1:0] lo_far_4, hi_far_4;    // where the last event that moved sides took them, if it was beyond,
    reg signed [SIDE_W-1:0] lo_near_4, hi_near_4;  // and if not
    reg            lo_goes_4, hi_goes_4;           // which of the two
    reg [1:0]      marks_4, beyond_4;              // marks before it, and its own,
    reg [1:0]      beyond;                         // if it was of the slot in the third stage
    reg            lo_goes, hi_goes;               // it was of the slot in the third stage, and went far
    reg signed [SIDE_W-1:0] lo_same, hi_same;      // if it was, lo_near_4 and hi_near_4, else 0
    reg signed [SIDE_W-1:0] lo_else, hi_else;      // if not, the sides of that slot, else 0
    reg [1:0]      marks_then;
    reg            hide_lo, hide_hi, hide_both;
    reg [18:0]       far;                          // way of a side that the event is beyond,
    reg [SIDE_W-1:0] near_lo, near_hi;             // and of one that it is not, or that takes effect
    reg            less_far_lo, less_near_lo, less_far_hi, less_near_hi;  // they go down
    reg [PX_W:0]   from;

    wire              stays = rests || (!moves && &hide);
    wire [PX_W+REL_W-1:0] wide_place = {{(PX_W + REL_W - AT_W - 1) {1'b0}}, place, 1'b0};  // its lower part is what counts

    // As they are before the event.
    wire [SIDE_W-1:0] lo        = lo_goes ? lo_far_4 : lo_same | lo_else;
    wire [SIDE_W-1:0] hi        = hi_goes ? hi_far_4 : hi_same | hi_else;
    wire [1:0]        marks     = marks_then | beyond;

    // The sign of a difference is a comparison. What takes effect moves sides as if the event were within them. A hidden side goes
    // where the other one goes; where both are hidden, none does.
    wire [SIDE_W-1:0] here     = {{(SIDE_W - AT_W - 12) {1'b0}}, at, 12'd0};
    wire [SIDE_W:0]   over_lo  = {1'b0, here} - {lo[SIDE_W-1], lo};
    wire [PX_W:0]     under_hi = {hi[SIDE_W-1], hi[SIDE_W-1:12]} - {{(PX_W + 1 - AT_W) {1'b0}}, at};  // pixels decide
    wire              below    = over_lo[SIDE_W];
    wire              above    = under_hi[PX_W];
    wire [SIDE_W-1:0] lo_far, lo_near, hi_far, hi_near;

    // What the event in the fourth stage has left.
    wire [SIDE_W-1:0] lo_new    = begins_4 ? {SIDE_W{1'b0}} : lo_goes_4 ? lo_far_4 : lo_near_4;
    wire [SIDE_W-1:0] hi_new    = begins_4 ? {SIDE_W{1'b0}} : hi_goes_4 ? hi_far_4 : hi_near_4;
    wire [1:0]        marks_new = clear_4 ? 2'b00 : m_marks;
    wire              lo_is_far = !effect && (hide_lo ? above : below);
    wire              hi_is_far = !effect && (hide_hi ? below : above);

    assign m_lo    = lo_new;
    assign m_hi    = hi_new;
    assign m_marks = marks_4 | beyond_4;

    motion_sum #(
        .W(SIDE_W)
    ) u_lo_far (
        .adds (1'b1),
        .a    (lo),
        .minus(less_far_lo),
        .b    ({{(SIDE_W - 19) {1'b0}}, far}),
        .y    (lo_far)
    );

    motion_sum #(
        .W(SIDE_W)
    ) u_lo_near (
        .adds (1'b1),
        .a    (lo),
        .minus(less_near_lo),
        .b    (near_lo),
        .y    (lo_near)
    );

    motion_sum #(
        .W(SIDE_W)
    ) u_hi_far (
        .adds (1'b1),
        .a    (hi),
        .minus(less_far_hi),
        .b    ({{(SIDE_W - 19) {1'b0}}, far}),
        .y    (hi_far)
    );

    motion_sum #(
        .W(SIDE_W)
    ) u_hi_near (
        .adds (1'b1),
        .a    (hi),
        .minus(less_near_hi),
        .b    (near_hi),
        .y    (hi_near)
    );

    // The pixels from that of the low side, which is rounded to nearest: half a pixel is the carry.
    wire [PX_W+1:0] place_from = {{(PX_W + 1 - AT_W) {1'b0}}, at, 1'b0} - {lo[SIDE_W-1], lo[SIDE_W-1:11]};
    wire [PX_W:0]   in_bins    = from >> log2_4;

    always @(posedge clk) begin
        hide <= hides[slot];

        rel       <= wide_place[REL_W-1:0] - middles[slot_2];
        at        <= place;
        log2_3    <= log2s[slot_2];
        hide_lo   <= hide[0];
        hide_hi   <= hide[1];
        hide_both <= &hide || moves || rests;
        far          <= stays ? 19'd0 : out;
        near_lo      <= stays ? {SIDE_W{1'b0}} : moves ? s_move_lo : {{(SIDE_W - 17) {1'b0}}, back};
        near_hi      <= stays ? {SIDE_W{1'b0}} : moves ? s_move_hi : {{(SIDE_W - 17) {1'b0}}, back};
        less_far_lo  <= !stays && !hide[0];
        less_far_hi  <= !stays && hide[1];
        less_near_lo <= !stays && !moves && hide[0];
        less_near_hi <= !stays && !moves && !hide[1];
        if (!forward || update) begin
            lo_far_4   <= lo_far;
            hi_far_4   <= hi_far;
            lo_near_4  <= lo_near;
            hi_near_4  <= hi_near;
            lo_goes_4  <= lo_is_far;
            hi_goes_4  <= hi_is_far;
            marks_4    <= marks;
            beyond_4   <= effect ? s_marks : hide_both ? 2'b00 : {above, below};
            lo_goes    <= forward && lo_is_far;
            hi_goes    <= forward && hi_is_far;
            lo_same    <= forward ? lo_near : {SIDE_W{1'b0}};
            hi_same    <= forward ? hi_near : {SIDE_W{1'b0}};
            lo_else    <= forward || fresh ? {SIDE_W{1'b0}} : recent ? lo_new : los[slot_2];
            hi_else    <= forward || fresh ? {SIDE_W{1'b0}} : recent ? hi_new : his[slot_2];
            marks_then <= (clear && forward) || fresh ? 2'b00 : forward ? marks : recent ? marks_new : markses[slot_2];
            beyond     <= forward && !hide_both && !clear ? {above, below} : 2'b00;
        end

        slot_4   <= slot_3;
        update_4 <= update;
        clear_4  <= clear;
        begins_4 <= begins;
        if (update_4) begin
            los[slot_4]     <= lo_new;
            his[slot_4]     <= hi_new;
            markses[slot_4] <= marks_new;
        end
        if (hide_now) hides[slot] <= s_hidden;
        if (effect) middles[slot_3] <= s_middle;
        if (set_bins) log2s[slot_3] <= s_log2[LOG2_W-1:0];

        from   <= place_from[PX_W+1:1];
        log2_4 <= log2_3;

        in_bin <= !from[PX_W] && in_bins[PX_W:4] == {(PX_W - 3) {1'b0}};
        bin    <= in_bins[3:0];
    end

    wire unused = &{1'b0, place_from[0], wide_place, over_lo, under_hi, s_log2};

endmodule

`default_nettype wire
