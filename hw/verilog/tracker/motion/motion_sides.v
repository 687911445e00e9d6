// SPDX-License-Identifier: Apache-2.0
// The sides of the slot that is worked on, what they were or have moved, and its velocity: one circuit through which both axes go in turn.
//
// An axis is in front for one clock, behind for the next, and so on; `lane` is low while x is in front. A command is given while
// `lane` is high, for one clock, and holds for x, then for y. `ref` of a side is its place at the last correction, carried along by
// steps, or after `reflect` how far the side is from there; after another one it is the place again.
//
// Latency:    from a command: 3 clocks to the sides of x in front, 2 to ref, 1 to the velocity; from seed 5 to the sides and the velocity;
//             one more for y. f_* and o_* show what is in front one clock later, side and sum three. After load, with which `lane` goes high, x
//             is behind.
// Throughput: a command every second clock; shrink and shorten follow the sides, rub the velocity, as they were 4 clocks before, order
//             and unite the differences of 2 clocks before.
// Stall:      none, without a command everything stays.
// Reset:      none but of lane: nothing is used before it was loaded.
// Combinational paths: none.
`default_nettype none

module motion_sides #(
    parameter X_W    = 9,   // bits of an address
    parameter Y_W    = 9,
    parameter SIDE_W = 25,  // bits of a side, 2^-12 px, signed
    parameter PX_W   = SIDE_W - 12  // derived: leave it alone
) (
    input  wire                clk,
    input  wire                rst,

    // commands
    input  wire                load,      // takes r_*, m_*, at any time; m_v must stay for the next clock
    input  wire                load_refs, // with it, and never alone: ref as well
    input  wire                seed,      // a square about x, y, at rest
    input  wire                shrink,    // a part inwards, but for marked sides
    input  wire                cut_high,  // the high side of axis `on_y`, or the low one, is `cut_px` from the low one
    input  wire                cut_low,
    input  wire                order,     // its high side is not below the low one
    input  wire                on_y,
    input  wire                unite,     // after reflect: the sides cover ref as well
    input  wire                move,      // by the velocity, if within reach
    input  wire                shorten,   // to side_max, about the middle, where longer
    input  wire                reflect,
    input  wire                settle,    // ref is the side
    input  wire                turn,      // the velocity is v_next, of x, in the next clock of y
    input  wire                rub,       // it dies away; a move with it goes a part of the way

    // operands: x first
    input  wire [X_W-1:0]      x,
    input  wire [Y_W-1:0]      y,
    input  wire [2*SIDE_W-1:0] r_sides,   // lo and hi: with `load` of x, in the next clock of y
    input  wire [2*SIDE_W-1:0] r_refs,
    input  wire [31:0]         m_v,       // y, x
    input  wire [15:0]         v_next,
    input  wire [3:0]          marks,     // hi and lo of y, hi and lo of x
    input  wire [PX_W-1:0]     cut_px,
    input  wire [7:0]          seed_px,
    input  wire [3:0]          side_shrink,
    input  wire [11:0]         side_max,
    input  wire [3:0]          friction,
    input  wire [1:0]          coast_slow,

    // the axis behind, x while `lane` is high
    output reg                 lane,
    output reg signed [SIDE_W:0] ref_lo,  // as a place its lower bits count
    output reg signed [SIDE_W:0] ref_hi,
    output reg signed [15:0]   v,

    // that in front
    output reg  [SIDE_W:0]     sum,

    // that in front, a clock later
    output reg                 f_y,       // it is y
    output reg  [2*SIDE_W-1:0] f_sides,
    output reg  [2*SIDE_W-1:0] f_refs,

    // both
    output reg  [4*SIDE_W-1:0] o_sides,
    output reg  [31:0]         o_v,
    output reg  [14:0]         speed_x,   // without sign
    output reg  [14:0]         speed_y,
    output reg  [SIDE_W-1:0]   side_x,    // hi - lo, at least 0
    output reg  [SIDE_W-1:0]   side_y,
    output reg  [SIDE_W:0]     sum_x,
    output reg  [SIDE_W:0]     sum_y,
    output reg                 crossed_x, // hi is below lo
    output reg                 crossed_y,
    output reg                 shortened  // a clock behind `shorten` for x, in the next one for y: the axis was too long
);

    // ---- commands, as the axis behind, then that in front has them -------------------------------------------------------

    reg  seed_1, seed_2, seed_b;  // two clocks late: its wire is long
    reg  shrinks, cuts_high, cuts_low, orders, unites, moves, shortens, turns, rubs;  // x had it, now y does
    reg  reflects, settles, change_a;  // change_a: the axis in front takes the offset, or the place, for which ref is 0 there
    reg  is_y;              // the axis behind is y: not `lane`, which is for what lies outside
    wire shrink_b = shrink || shrinks;
    wire high_b   = on_y ? cuts_high : cut_high;
    wire low_b    = on_y ? cuts_low : cut_low;
    wire order_b  = on_y ? orders : order;
    wire unite_b  = unite || unites;
    wire move_b   = move || moves;
    wire long_b   = shorten || shortens;
    wire turn_b   = turn || turns;
    wire rub_b    = rub || rubs;

    always @(posedge clk) begin
        {seed_1, seed_2, seed_b} <= {seed, seed_1, seed_1 || seed_2};
        {shrinks, cuts_high, cuts_low, orders} <= {shrink, cut_high, cut_low, order};
        {unites, moves, shortens, turns, rubs} <= {unite, move, shorten, turn, rub};
        {reflects, settles} <= {reflect, settle};
        change_a <= settle || settles || reflect || reflects;
    end

    // ---- behind: what is added is chosen; in front: it is added; behind: it is taken -------------------------------------

    reg signed [SIDE_W-1:0] lo_a, hi_a, lo_b, hi_b, new_lo, new_hi;
    reg signed [SIDE_W:0]   ref_lo_a, ref_hi_a;
    wire [SIDE_W:0]         next_ref_lo, next_ref_hi;
    reg signed [15:0]       v_a, v_less;
    wire signed [15:0]      v_part, v_slow;    // v_slow of the axis behind
    reg signed [SIDE_W:0]   apart;             // of the axis in front, as sum
    wire       [SIDE_W-1:0] part;              // of the axis behind, if it is not inverted
    reg                     too_long, inverted;
    reg        [SIDE_W-1:0] add_lo, add_hi;    // complements where negative
    reg                     less_lo, less_hi;
    reg        [SIDE_W-1:0] place;             // of the axis in front, for a seed
    reg                     loads, takes;       // y is loaded, with its ref
    reg                     from_place, from_middle, hi_from_lo, checks, do_lo, do_hi, checks_b, take_lo, take_hi;

    wire              square_b = seed_b || long_b;  // both sides are as far from one place
    wire [SIDE_W-1:0] half     = only(seed_b, {{(SIDE_W - 20) {1'b0}}, seed_px, 12'd0}) | only(long_b, {{(SIDE_W - 23) {1'b0}}, side_max, 11'd0});
    wire shrinks_b = shrink_b && !inverted;
    wire signed [15:0] next_v   = load ? m_v[15:0] : loads ? m_v[31:16] : from_place ? 16'sd0 : v_a;
    wire signed [15:0] next_v_a = turn_b ? v_next : rub_b ? v_less : v;
    wire signed [15:0] slow    = rub_b ? v_slow : v;
    wire [SIDE_W-1:0] way      = {{(SIDE_W - 16) {slow[15]}}, slow};
    wire [SIDE_W-1:0] at_x     = {{(SIDE_W - 12 - X_W) {1'b0}}, x, 12'd0};
    wire [SIDE_W-1:0] at_y     = {{(SIDE_W - 12 - Y_W) {1'b0}}, y, 12'd0};
    wire [1:0]        mark     = is_y ? marks[3:2] : marks[1:0];
    wire [SIDE_W-1:0] side     = apart[SIDE_W] ? {SIDE_W{1'b0}} : apart[SIDE_W-1:0];
    // From the length to the longest one, in whole pixels, of which a part of one counts as one: negative where it is too long.
    wire [PX_W+2:0]          spare    = {{(PX_W - 10) {1'b0}}, side_max, 1'b0} - {apart[SIDE_W], apart[SIDE_W:12], |apart[11:0]};
    wire [SIDE_W-1:0]        base_lo  = from_place ? place : lo_a;  // or the middle
    wire [SIDE_W-1:0]        base_hi  = from_place ? place : hi_from_lo ? lo_a : hi_a;
    wire [SIDE_W-1:0]        sum_lo, sum_hi;

    array_sum #(
        .W(SIDE_W)
    ) u_lo (
        .a     (add_lo),
        .choice(from_middle),
        .one   ({sum[SIDE_W:1], less_lo}),
        .other ({base_lo, less_lo}),
        .y     (sum_lo)
    );

    array_sum #(
        .W(SIDE_W)
    ) u_hi (
        .a     (add_hi),
        .choice(from_middle),
        .one   ({sum[SIDE_W:1], less_hi}),
        .other ({base_hi, less_hi}),
        .y     (sum_hi)
    );

    // How far the side is from ref, or ref.
    motion_sum #(
        .W(SIDE_W + 1)
    ) u_ref_lo (
        .adds (change_a),
        .a    ({lo_a[SIDE_W-1], lo_a}),
        .minus(change_a),
        .b    (ref_lo_a),
        .y    (next_ref_lo)
    );

    motion_sum #(
        .W(SIDE_W + 1)
    ) u_ref_hi (
        .adds (change_a),
        .a    ({hi_a[SIDE_W-1], hi_a}),
        .minus(change_a),
        .b    (ref_hi_a),
        .y    (next_ref_hi)
    );

    // One command at a time.
    function [SIDE_W-1:0] only;
        input              when;
        input [SIDE_W-1:0] value;
        only = {SIDE_W{when}} & value;
    endfunction

    // From -2^REACH to below 2^(REACH + 1) pixels.
    wire reachable = (new_lo[SIDE_W-1:SIDE_W-4] == 4'hf || new_lo[SIDE_W-1:SIDE_W-3] == 3'd0)
               && (new_hi[SIDE_W-1:SIDE_W-4] == 4'hf || new_hi[SIDE_W-1:SIDE_W-3] == 3'd0);
    wire taken     = !checks_b || reachable;

    always @(posedge clk) begin
        // behind
        from_place  <= seed_b;
        place       <= is_y ? at_y : at_x;
        from_middle <= long_b;
        hi_from_lo  <= high_b || order_b;
        checks      <= move_b;
        do_lo       <= seed_b || (shrink_b && !mark[0]) || low_b || (unite_b && !ref_lo[SIDE_W]) || move_b || (long_b && too_long);
        do_hi       <= seed_b || (shrink_b && !mark[1]) || high_b || (unite_b && ref_hi[SIDE_W]) || move_b || (long_b && too_long)
                    || (order_b && inverted);
        less_lo     <= seed_b || long_b || unite_b;
        less_hi     <= shrinks_b || unite_b;
        add_lo      <= only(square_b, ~half) | only(move_b, way) | only(low_b, {cut_px, 12'd0}) | only(unite_b, ~ref_lo[SIDE_W-1:0])
                     | only(shrinks_b, part);
        add_hi      <= half | only(move_b, way) | only(high_b, {cut_px, 12'd0}) | only(unite_b, ~ref_hi[SIDE_W-1:0])
                     | only(shrinks_b, ~part);

        // in front
        {lo_b, hi_b} <= {lo_a, hi_a};
        new_lo   <= sum_lo;
        new_hi   <= sum_hi;
        take_lo  <= do_lo;
        take_hi  <= do_hi;
        checks_b <= checks;

        // behind
        lo_a <= take_lo && taken ? new_lo : lo_b;
        hi_a <= take_hi && taken ? new_hi : hi_b;

        // in front, and behind
        if (!load || is_y) begin
            ref_lo <= next_ref_lo;
            ref_hi <= next_ref_hi;
            {ref_lo_a, ref_hi_a} <= settle || settles ? {(2 * SIDE_W + 2) {1'b0}} : {ref_lo, ref_hi};
        end
        v      <= next_v;
        v_less <= v_a - v_part;
        v_a    <= next_v_a;

        lane  <= is_y || load;
        is_y  <= !is_y && !load;
        loads <= load;
        takes <= load_refs;
        if (load || loads) {lo_b, hi_b} <= r_sides;
        if (load_refs || takes) {ref_lo, ref_hi} <= {r_refs[2*SIDE_W-1], r_refs[SIDE_W+:SIDE_W], r_refs[SIDE_W-1], r_refs[0+:SIDE_W]};
        if (rst) {lane, is_y} <= 2'b01;
    end

    // ---- what is a part of them: a shift to the right is a product with a power of two -------------------------------------

    localparam LOW = 17;  // of the lower part of a length

    wire [SIDE_W:0]    next_apart = {hi_b[SIDE_W-1], hi_b} - {lo_b[SIDE_W-1], lo_b};
    wire [32:0]        v_parts;    // 2^16 times v_part
    wire [20:0]        v_slows;    // 8 times v_slow
    wire [LOW+17:0]    low_parts;  // 2^15 times the part of a length: of its lower bits,
    wire [SIDE_W-LOW+17:0] high_parts;  // and of those above them, less by 2^LOW

    assign v_part = v_parts[31:16];
    assign v_slow = v_slows[18:3];
    assign part   = {high_parts[SIDE_W-3:0], 2'b00} | {{(SIDE_W - LOW) {1'b0}}, low_parts[15+:LOW]};

    multiplier #(
        .A_W(16),
        .B_W(17)
    ) u_v_part (
        .clk(clk),
        .a  (next_v),
        .b  (friction == 4'd0 ? 17'd0 : 17'h10000 >> friction),
        .p  (v_parts)
    );

    multiplier #(
        .A_W(16),
        .B_W(5)
    ) u_v_slow (
        .clk(clk),
        .a  (next_v_a),
        .b  (5'd8 >> coast_slow),
        .p  (v_slows)
    );

    multiplier #(
        .A_W(LOW + 1),
        .B_W(17)
    ) u_low_part (
        .clk(clk),
        .a  ({1'b0, next_apart[LOW-1:0]}),
        .b  (17'h8000 >> side_shrink),
        .p  (low_parts)
    );

    multiplier #(
        .A_W(SIDE_W - LOW + 1),
        .B_W(17)
    ) u_high_part (
        .clk(clk),
        .a  (next_apart[SIDE_W:LOW]),
        .b  (17'h8000 >> side_shrink),
        .p  (high_parts)
    );

    wire [14:0] speed;

    motion_sum #(
        .W(15)
    ) u_speed (
        .adds (1'b0),
        .a    (15'd0),
        .minus(v_a[15]),
        .b    (v_a[14:0]),
        .y    (speed)
    );

    // ---- what follows from them ------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        apart    <= next_apart;
        sum      <= {hi_b[SIDE_W-1], hi_b} + {lo_b[SIDE_W-1], lo_b};
        inverted <= apart[SIDE_W];
        too_long <= spare[PX_W+2];
        shortened <= long_b && too_long;
        f_y     <= !is_y;
        f_sides <= {lo_a, hi_a};
        f_refs  <= {ref_lo_a[SIDE_W-1:0], ref_hi_a[SIDE_W-1:0]};
        if (!is_y) begin
            o_sides[2*SIDE_W-1:0] <= {lo_a, hi_a};
            o_v[31:16]            <= v_a;
            speed_y               <= speed;
            {side_y, sum_y, crossed_y} <= {side, sum, apart[SIDE_W]};
        end else begin
            o_sides[4*SIDE_W-1:2*SIDE_W] <= {lo_a, hi_a};
            o_v[15:0]                    <= v_a;
            speed_x                      <= speed;
            {side_x, sum_x, crossed_x}   <= {side, sum, apart[SIDE_W]};
        end
    end

    wire unused = &{1'b0, spare, v_parts, v_slows, low_parts, high_parts};

endmodule

`default_nettype wire
