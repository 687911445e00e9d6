// SPDX-License-Identifier: Apache-2.0
// One axis of the slot that is worked on: its sides, what they were or have moved, and its velocity.
//
// A command that moves sides is prepared in its clock, and takes effect in the next one. `ref` of a side is its place at the last
// correction, carried along by steps, or after `reflect` its offset from there; after another one it is the place again.
//
// Latency:    lo and hi 1 clock after load, unite, order, 2 after seed, shrink, cut, move, shorten; side and sum one more, part and too_long two.
//             ref and v 1 clock.
// Throughput: a command every second clock.
// Stall:      none, without a command everything stays.
// Reset:      none, nothing is used before it was loaded.
// Combinational paths: none.
`default_nettype none

module motion_sides #(
    parameter AT_W   = 9,   // bits of an address
    parameter SIDE_W = 25,  // bits of a side, 2^-12 px, signed
    parameter PX_W   = SIDE_W - 12  // derived: leave it alone
) (
    input  wire                     clk,

    // commands
    input  wire                     load,     // takes r_*, m_*
    input  wire                     unite,    // sides cover r_* as well; velocity as m_v
    input  wire                     seed,     // a square about `place`, at rest
    input  wire                     shrink,   // a part inwards, but for marked sides
    input  wire                     cut_high, // the high side, or the low one, is `cut_px` from the low one
    input  wire                     cut_low,
    input  wire                     order,    // the high side is not below the low one
    input  wire                     move,     // by the velocity, if within reach
    input  wire                     shorten,  // to side_max, about the middle
    input  wire                     reflect,
    input  wire                     settle,   // ref is the side
    input  wire                     turn,     // the velocity is v_next
    input  wire                     rub,      // it dies away

    // operands
    input  wire [AT_W-1:0]          place,
    input  wire signed [SIDE_W-1:0] r_lo,
    input  wire signed [SIDE_W-1:0] r_hi,
    input  wire [SIDE_W-1:0]        m_ref_lo,
    input  wire [SIDE_W-1:0]        m_ref_hi,
    input  wire [15:0]              m_v,
    input  wire [15:0]              v_next,
    input  wire [1:0]               marks,    // hi, lo
    input  wire [PX_W-1:0]          cut_px,
    input  wire [7:0]               seed_px,
    input  wire [3:0]               side_shrink,
    input  wire [11:0]              side_max,
    input  wire [3:0]               friction,

    output reg signed [SIDE_W-1:0]  lo,
    output reg signed [SIDE_W-1:0]  hi,
    output reg  [SIDE_W:0]          ref_lo,   // as a place its lower bits count
    output reg  [SIDE_W:0]          ref_hi,
    output reg signed [15:0]        v,
    output wire [14:0]              speed,
    output wire [SIDE_W-1:0]        side,     // hi - lo, at least 0
    output reg signed [SIDE_W:0]    sum,
    output reg                      too_long,
    output reg                      too_small, // less than least_px
    input  wire [7:0]               least_px
);

    reg                     do_add, do_hi, do_lo, checks, from_place, from_middle, hi_from_lo;
    reg signed [SIDE_W-1:0] add_lo, add_hi;
    reg signed [SIDE_W:0]   apart;
    reg [SIDE_W-1:0]        part;
    reg signed [15:0]       v_part;

    wire [SIDE_W-1:0] seed_way = {{(SIDE_W - 20) {1'b0}}, seed_px, 12'd0};
    wire [SIDE_W-1:0] half     = {{(SIDE_W - 23) {1'b0}}, side_max, 11'd0};
    wire [SIDE_W-1:0] way      = {{(SIDE_W - 16) {v[15]}}, v};
    wire [SIDE_W-1:0] at       = {{(SIDE_W - 12 - AT_W) {1'b0}}, place, 12'd0};
    wire signed [SIDE_W-1:0] base_lo = from_place ? at : from_middle ? sum[SIDE_W:1] : lo;
    wire signed [SIDE_W-1:0] base_hi = from_place ? at : from_middle ? sum[SIDE_W:1] : hi_from_lo ? lo : hi;
    wire signed [SIDE_W-1:0] new_lo  = base_lo + add_lo;
    wire signed [SIDE_W-1:0] new_hi  = base_hi + add_hi;
    wire signed [PX_W:0]     apart_px = apart[SIDE_W:12];
    wire signed [PX_W:0]     most     = {{(PX_W - 11) {1'b0}}, side_max};
    wire signed [PX_W:0]     least    = {{(PX_W - 7) {1'b0}}, least_px};

    // From -2^REACH to below 2^(REACH + 1) pixels.
    wire reachable = (new_lo[SIDE_W-1:SIDE_W-4] == 4'hf || new_lo[SIDE_W-1:SIDE_W-3] == 3'd0)
               && (new_hi[SIDE_W-1:SIDE_W-4] == 4'hf || new_hi[SIDE_W-1:SIDE_W-3] == 3'd0);

    assign side  = apart[SIDE_W] ? {SIDE_W{1'b0}} : apart[SIDE_W-1:0];
    assign speed = v[15] ? -v[14:0] : v[14:0];

    always @(posedge clk) begin
        do_add      <= seed || shrink || cut_high || cut_low || move || shorten;
        do_lo       <= !cut_high;
        do_hi       <= !cut_low;
        checks      <= move;
        from_place  <= seed;
        from_middle <= shorten;
        hi_from_lo  <= cut_high;
        add_lo      <= seed ? -seed_way : shorten ? -half : move ? way : cut_low ? {cut_px, 12'd0} : marks[0] ? {SIDE_W{1'b0}} : part;
        add_hi      <= seed ? seed_way : shorten ? half : move ? way : cut_high ? {cut_px, 12'd0} : marks[1] ? {SIDE_W{1'b0}} : -part;

        if (do_add && (!checks || reachable)) begin
            if (do_lo) lo <= new_lo;
            if (do_hi) hi <= new_hi;
        end
        if (load) {lo, hi} <= {r_lo, r_hi};
        if (unite) begin
            if (r_lo < lo) lo <= r_lo;
            if (r_hi > hi) hi <= r_hi;
        end
        if (order && apart[SIDE_W]) hi <= lo;

        if (load) begin
            ref_lo <= {m_ref_lo[SIDE_W-1], m_ref_lo};
            ref_hi <= {m_ref_hi[SIDE_W-1], m_ref_hi};
        end
        if (reflect || settle) begin
            ref_lo <= {lo[SIDE_W-1], lo} - (settle ? {(SIDE_W + 1) {1'b0}} : ref_lo);
            ref_hi <= {hi[SIDE_W-1], hi} - (settle ? {(SIDE_W + 1) {1'b0}} : ref_hi);
        end

        if (load || unite) v <= m_v;
        if (turn) v <= v_next;
        if (rub) v <= v - v_part;
        if (seed) v <= 16'd0;

        v_part   <= v >>> friction;
        apart    <= {hi[SIDE_W-1], hi} - {lo[SIDE_W-1], lo};
        sum      <= {hi[SIDE_W-1], hi} + {lo[SIDE_W-1], lo};
        part     <= side >> side_shrink;
        too_long  <= apart_px > most || (apart_px == most && |apart[11:0]);
        too_small <= apart_px < least;
    end

endmodule

`default_nettype wire
