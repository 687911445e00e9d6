// SPDX-License-Identifier: Apache-2.0
// The registers of an array with motion, and with them all values that motion_engine.v can take as an operand.
//
// Latency:    2 clocks from index to the values.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      gives the registers their defaults.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"
`include "motion_codes.vh"

module motion_values #(
    parameter SLOT_W = 3,   // bits of a slot number
    parameter X_W    = 9,   // bits of an x address
    parameter Y_W    = 9,   // bits of a y address
    parameter REACH  = 9,   // a box stays from -2^REACH to below 2^(REACH + 1) pixels
    parameter SUP_W  = 16,  // bits of a support count
    parameter ID_W   = 32,  // bits of a track id
    parameter TIME_W = 48,  // bits of a time
    parameter W      = 48   // bits of a value
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              cfg_valid,
    input  wire [`EVCOT_MREG_W-1:0] cfg_addr,
    input  wire [31:0]       cfg_data,

    // registers that are used elsewhere
    output wire [4:0]        step_log2,
    output wire [3:0]        gap_share,
    output wire              counts,      // events are counted in bins
    output reg  [15:0]       back,        // ways of a side
    output reg  [15:0]       out,

    // values beside the registers
    input  wire [TIME_W-1:0] now,
    input  wire [X_W-1:0]    x,
    input  wire [Y_W-1:0]    y,
    input  wire [SLOT_W-1:0] other,
    input  wire [ID_W-1:0]   births,
    input  wire [3:0]        gap_bin,
    input  wire [4:0]        leading,
    input  wire [6:0]        inverse,

    input  wire              wanted,      // else the values are 0
    input  wire [5:0]        index,
    output wire [W-1:0]      value_x,
    output wire [W-1:0]      value_y      // that of x, but for an event's place
);

    wire [15:0] side_step, birth_support;
    wire [11:0] side_max;
    wire [3:0]  side_share, side_shrink, gain_log2, friction, ring_across, ring_along, ring_any, elongation, life_log2, birth_travel;
    wire [3:0]  join_life, join_speed, join_reach;
    wire [2:0]  gain_slow;
    wire [5:0]  settle;
    wire [14:0] speed_max;
    wire [9:0]  nev_low, nev_high, join_steps, report_steps;
    wire [7:0]  seed_px, ring_px, ring_max, birth_px, gap_corrections, gap_px, join_px;
    wire [23:0] detect_ticks, life_ticks, coast_ticks, birth_ticks;
    wire        keep_older;

    motion_regs u_regs (
        .clk            (clk),
        .rst            (rst),
        .cfg_valid      (cfg_valid),
        .cfg_addr       (cfg_addr),
        .cfg_data       (cfg_data),
        .step_log2      (step_log2),
        .side_step      (side_step),
        .side_share     (side_share),
        .side_shrink    (side_shrink),
        .side_max       (side_max),
        .gain_log2      (gain_log2),
        .gain_slow      (gain_slow),
        .settle         (settle),
        .speed_max      (speed_max),
        .friction       (friction),
        .nev_low        (nev_low),
        .nev_high       (nev_high),
        .seed_px        (seed_px),
        .ring_px        (ring_px),
        .ring_max       (ring_max),
        .ring_across    (ring_across),
        .ring_along     (ring_along),
        .ring_any       (ring_any),
        .elongation     (elongation),
        .detect_ticks   (detect_ticks),
        .life_log2      (life_log2),
        .life_ticks     (life_ticks),
        .coast_ticks    (coast_ticks),
        .birth_support  (birth_support),
        .birth_px       (birth_px),
        .birth_ticks    (birth_ticks),
        .birth_travel   (birth_travel),
        .gap_corrections(gap_corrections),
        .gap_share      (gap_share),
        .gap_px         (gap_px),
        .join_steps     (join_steps),
        .join_life      (join_life),
        .join_speed     (join_speed),
        .join_reach     (join_reach),
        .join_px        (join_px),
        .keep_older     (keep_older),
        .report_steps   (report_steps)
    );

    assign counts = gap_corrections != 8'd0;

    // ---- one of eight of each group, then that of the group that is meant; all others are 0 ------------------------------

    localparam PLACE_W = (X_W > Y_W) ? X_W : Y_W;

    reg [14:0]        short_0, short_1;
    reg [23:0]        short_2, short_3, short_4;
    reg [W-1:0]       wide, mark;
    reg [PLACE_W-1:0] place_x, place_y;
    reg [23:0]        low_a, low_b;
    reg [W-1:0]       high;
    reg [PLACE_W-1:0] at_x, at_y;
    reg [6:0]         group;

    wire [W-1:0] value = high | {{(W - 24) {1'b0}}, low_a | low_b};
    wire [W-1:0] place_in_x = {{(W - PLACE_W - 12) {1'b0}}, at_x, 12'd0};
    wire [W-1:0] place_in_y = {{(W - PLACE_W - 12) {1'b0}}, at_y, 12'd0};
    assign value_x = value | place_in_x;
    assign value_y = value | place_in_y;

    always @(posedge clk) begin
        back <= side_step >> side_share;
        out  <= side_step - back;

        group <= wanted ? 7'd1 << index[5:3] : 7'd0;
        case ({3'd0, index[2:0]})
            `EVCOT_MOTION_VALUE_STEP_LOG2: short_0 <= {10'd0, step_log2};
            `EVCOT_MOTION_VALUE_SIDE_SHRINK: short_0 <= {11'd0, side_shrink};
            `EVCOT_MOTION_VALUE_SIDE_MAX: short_0 <= {3'd0, side_max};
            `EVCOT_MOTION_VALUE_GAIN_LOG2: short_0 <= {11'd0, gain_log2};
            default: short_0 <= {12'd0, gain_slow};
        endcase
        case ({3'd1, index[2:0]})
            `EVCOT_MOTION_VALUE_SETTLE: short_1 <= {9'd0, settle};
            `EVCOT_MOTION_VALUE_SPEED_MAX: short_1 <= speed_max;
            `EVCOT_MOTION_VALUE_FRICTION: short_1 <= {11'd0, friction};
            `EVCOT_MOTION_VALUE_NEV_LOW: short_1 <= {5'd0, nev_low};
            `EVCOT_MOTION_VALUE_NEV_HIGH: short_1 <= {5'd0, nev_high};
            `EVCOT_MOTION_VALUE_SEED_PX: short_1 <= {7'd0, seed_px};
            `EVCOT_MOTION_VALUE_RING_PX: short_1 <= {7'd0, ring_px};
            default: short_1 <= {7'd0, ring_max};
        endcase
        case ({3'd2, index[2:0]})
            `EVCOT_MOTION_VALUE_RING_ACROSS: short_2 <= {20'd0, ring_across};
            `EVCOT_MOTION_VALUE_RING_ALONG: short_2 <= {20'd0, ring_along};
            `EVCOT_MOTION_VALUE_RING_ANY: short_2 <= {20'd0, ring_any};
            `EVCOT_MOTION_VALUE_ELONGATION: short_2 <= {20'd0, elongation};
            `EVCOT_MOTION_VALUE_DETECT_TICKS: short_2 <= detect_ticks;
            `EVCOT_MOTION_VALUE_LIFE_LOG2: short_2 <= {20'd0, life_log2};
            `EVCOT_MOTION_VALUE_LIFE_TICKS: short_2 <= life_ticks;
            default: short_2 <= coast_ticks;
        endcase
        case ({3'd3, index[2:0]})
            `EVCOT_MOTION_VALUE_BIRTH_SUPPORT: short_3 <= {8'd0, birth_support};
            `EVCOT_MOTION_VALUE_BIRTH_PX: short_3 <= {16'd0, birth_px};
            `EVCOT_MOTION_VALUE_BIRTH_TICKS: short_3 <= birth_ticks;
            `EVCOT_MOTION_VALUE_BIRTH_TRAVEL: short_3 <= {20'd0, birth_travel};
            `EVCOT_MOTION_VALUE_GAP_CORRECTIONS: short_3 <= {16'd0, gap_corrections};
            `EVCOT_MOTION_VALUE_GAP_PX: short_3 <= {16'd0, gap_px};
            default: short_3 <= {14'd0, join_steps};
        endcase
        case ({3'd4, index[2:0]})
            `EVCOT_MOTION_VALUE_JOIN_LIFE: short_4 <= {20'd0, join_life};
            `EVCOT_MOTION_VALUE_JOIN_SPEED: short_4 <= {20'd0, join_speed};
            `EVCOT_MOTION_VALUE_JOIN_REACH: short_4 <= {20'd0, join_reach};
            `EVCOT_MOTION_VALUE_JOIN_PX: short_4 <= {16'd0, join_px};
            `EVCOT_MOTION_VALUE_KEEP_OLDER: short_4 <= {23'd0, keep_older};
            default: short_4 <= {14'd0, report_steps};
        endcase
        place_x <= {PLACE_W{1'b0}};
        place_y <= {PLACE_W{1'b0}};
        case ({3'd5, index[2:0]})
            `EVCOT_MOTION_VALUE_NOW: wide <= {{(W - TIME_W) {1'b0}}, now};
            `EVCOT_MOTION_VALUE_EVENT: begin
                wide    <= {W{1'b0}};
                place_x <= {{(PLACE_W - X_W) {1'b0}}, x};
                place_y <= {{(PLACE_W - Y_W) {1'b0}}, y};
            end
            `EVCOT_MOTION_VALUE_OTHER: wide <= {{(W - SLOT_W) {1'b0}}, other};
            `EVCOT_MOTION_VALUE_BIRTHS: wide <= {{(W - ID_W) {1'b0}}, births};
            `EVCOT_MOTION_VALUE_LEADING: wide <= {{(W - 5) {1'b0}}, leading};
            `EVCOT_MOTION_VALUE_INVERSE: wide <= {{(W - 7) {1'b0}}, inverse};
            default: wide <= {{(W - 4) {1'b0}}, gap_bin};
        endcase
        case ({3'd6, index[2:0]})
            `EVCOT_MOTION_VALUE_HALF: mark <= {{(W - 12) {1'b0}}, 12'h800};
            `EVCOT_MOTION_VALUE_TWO: mark <= {{(W - 14) {1'b0}}, 14'h2000};
            `EVCOT_MOTION_VALUE_REACH_LO: mark <= {W{1'b1}} << (REACH + 12);
            `EVCOT_MOTION_VALUE_REACH_HI: mark <= {{(W - 1) {1'b0}}, 1'b1} << (REACH + 13);
            `EVCOT_MOTION_VALUE_TICKS_MAX: mark <= {{(W - 24) {1'b0}}, 24'hffffff};
            `EVCOT_MOTION_VALUE_TOGETHER_MAX: mark <= {{(W - 16) {1'b0}}, 16'hffff};
            default: mark <= {{(W - SUP_W) {1'b0}}, {SUP_W{1'b1}}};
        endcase

        low_a <= ({9'd0, short_0} & {24{group[0]}}) | ({9'd0, short_1} & {24{group[1]}});
        low_b <= (short_2 & {24{group[2]}}) | (short_3 & {24{group[3]}});
        high  <= (wide & {W{group[5]}}) | (mark & {W{group[6]}}) | {{(W - 24) {1'b0}}, short_4 & {24{group[4]}}};
        at_x  <= place_x & {PLACE_W{group[5]}};
        at_y  <= place_y & {PLACE_W{group[5]}};
    end

endmodule

`default_nettype wire
