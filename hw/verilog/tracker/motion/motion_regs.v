// SPDX-License-Identifier: Apache-2.0
// The registers of an array with motion that hold for the whole array: docs/motion.md.
// Generated from sw/evcot/hardware/motion/contract.py by `python -m evcot.hardware.generate`: edit there.
//
// Values outside a register's range are not refused here.
//
// Latency:    1 clock from a write to its register.
// Throughput: a write per clock.
// Stall:      none.
// Reset:      every register gets its default.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

module motion_regs (
    input  wire        clk,
    input  wire        rst,

    input  wire        cfg_valid,
    input  wire [`EVCOT_MREG_W-1:0] cfg_addr,
    input  wire [31:0] cfg_data,

    // 0 to 20: a motion step every 2^step_log2 ticks
    output reg  [4:0]  step_log2,

    // 1 to 65535: way of a side for an event beyond and one within it, in 2^-12 px
    output reg  [15:0] side_step,

    // 1 to 8: 2^-side_share of a slot's events lie beyond each side
    output reg  [3:0]  side_share,

    // 0 to 8: a side without an event beyond it moves inwards by 2^-side_shrink of the box; 0: never
    output reg  [3:0]  side_shrink,

    // 1 to 4095: longest side, px
    output reg  [11:0] side_max,

    // 1 to 12: gain of a velocity's correction is 2^-gain_log2 in the end
    output reg  [3:0]  gain_log2,

    // 0 to 6: 2^gain_slow corrections until a gain is halved
    output reg  [2:0]  gain_slow,

    // 0 to 63: corrections during which a velocity follows the slower of two sides
    output reg  [5:0]  settle,

    // 0 to 32767: limit of a velocity on each axis, in 2^-12 px per step; 0: nothing moves between events
    output reg  [14:0] speed_max,

    // 0 to 15: a silent slot loses 2^-friction of its velocity a step; 0: nothing
    output reg  [3:0]  friction,

    // 1 to 1023: fewest events of a correction
    output reg  [9:0]  nev_low,

    // 1 to 1023: most events of a correction
    output reg  [9:0]  nev_high,

    // 1 to 255: half the side of a new candidate's box
    output reg  [7:0]  seed_px,

    // 0 to 255: least distance of a window from its box
    output reg  [7:0]  ring_px,

    // 0 to 255: largest distance of a window from its box
    output reg  [7:0]  ring_max,

    // 0 to 8: distance across the motion is 2^-ring_across of the box's side there
    output reg  [3:0]  ring_across,

    // 0 to 8: distance along the motion is 2^-ring_along of the side across it
    output reg  [3:0]  ring_along,

    // 0 to 8: distance, where there is no one direction, is 2^-ring_any of the side
    output reg  [3:0]  ring_any,

    // 1 to 15: a box this many times as long as it is wide reaches along its motion as across it
    output reg  [3:0]  elongation,

    // 1 to 16777215: ticks within which a candidate must have its first correction
    output reg  [23:0] detect_ticks,

    // 0 to 8: a life ends after 2^life_log2 times the usual time between corrections without one
    output reg  [3:0]  life_log2,

    // 1 to 16777215: but not before this time
    output reg  [23:0] life_ticks,

    // 1 to 16777215: nor after this time
    output reg  [23:0] coast_ticks,

    // 1 to 65535: events that a candidate needs to become visible
    output reg  [15:0] birth_support,

    // 0 to 255: sides that it needs
    output reg  [7:0]  birth_px,

    // 0 to 16777215: time that it needs
    output reg  [23:0] birth_ticks,

    // 0 to 8: since the 4th correction its middle has moved 1 px and 2^-birth_travel of a half side
    output reg  [3:0]  birth_travel,

    // 0 to 255: corrections after which a box is looked through for a gap; 0: never
    output reg  [7:0]  gap_corrections,

    // 1 to 15: a bin with at most 2^-gap_share of the events is empty
    output reg  [3:0]  gap_share,

    // 1 to 255: narrowest gap
    output reg  [7:0]  gap_px,

    // 1 to 1023: steps for which two slots must move together before they merge
    output reg  [9:0]  join_steps,

    // 0 to 15: and 2^-join_life of the younger's life
    output reg  [3:0]  join_life,

    // 0 to 8: together: velocities differ by at most 2^-join_speed of the larger
    output reg  [3:0]  join_speed,

    // 0 to 8: one object: a gap along the motion of at most 2^-join_reach of the width
    output reg  [3:0]  join_reach,

    // 0 to 255: one object: a gap of so many px otherwise
    output reg  [7:0]  join_px,

    // 0 to 1: of two that merge stays 0: the one with more support; 1: the one that was seeded first
    output reg         keep_older,

    // 1 to 1023: steps after which a slot without a correction is reported
    output reg  [9:0]  report_steps
);

    always @(posedge clk) begin
        if (cfg_valid)
            case (cfg_addr)
                `EVCOT_MREG_STEP_LOG2: step_log2 <= cfg_data[4:0];
                `EVCOT_MREG_SIDE_STEP: side_step <= cfg_data[15:0];
                `EVCOT_MREG_SIDE_SHARE: side_share <= cfg_data[3:0];
                `EVCOT_MREG_SIDE_SHRINK: side_shrink <= cfg_data[3:0];
                `EVCOT_MREG_SIDE_MAX: side_max <= cfg_data[11:0];
                `EVCOT_MREG_GAIN_LOG2: gain_log2 <= cfg_data[3:0];
                `EVCOT_MREG_GAIN_SLOW: gain_slow <= cfg_data[2:0];
                `EVCOT_MREG_SETTLE: settle <= cfg_data[5:0];
                `EVCOT_MREG_SPEED_MAX: speed_max <= cfg_data[14:0];
                `EVCOT_MREG_FRICTION: friction <= cfg_data[3:0];
                `EVCOT_MREG_NEV_LOW: nev_low <= cfg_data[9:0];
                `EVCOT_MREG_NEV_HIGH: nev_high <= cfg_data[9:0];
                `EVCOT_MREG_SEED_PX: seed_px <= cfg_data[7:0];
                `EVCOT_MREG_RING_PX: ring_px <= cfg_data[7:0];
                `EVCOT_MREG_RING_MAX: ring_max <= cfg_data[7:0];
                `EVCOT_MREG_RING_ACROSS: ring_across <= cfg_data[3:0];
                `EVCOT_MREG_RING_ALONG: ring_along <= cfg_data[3:0];
                `EVCOT_MREG_RING_ANY: ring_any <= cfg_data[3:0];
                `EVCOT_MREG_ELONGATION: elongation <= cfg_data[3:0];
                `EVCOT_MREG_DETECT_TICKS: detect_ticks <= cfg_data[23:0];
                `EVCOT_MREG_LIFE_LOG2: life_log2 <= cfg_data[3:0];
                `EVCOT_MREG_LIFE_TICKS: life_ticks <= cfg_data[23:0];
                `EVCOT_MREG_COAST_TICKS: coast_ticks <= cfg_data[23:0];
                `EVCOT_MREG_BIRTH_SUPPORT: birth_support <= cfg_data[15:0];
                `EVCOT_MREG_BIRTH_PX: birth_px <= cfg_data[7:0];
                `EVCOT_MREG_BIRTH_TICKS: birth_ticks <= cfg_data[23:0];
                `EVCOT_MREG_BIRTH_TRAVEL: birth_travel <= cfg_data[3:0];
                `EVCOT_MREG_GAP_CORRECTIONS: gap_corrections <= cfg_data[7:0];
                `EVCOT_MREG_GAP_SHARE: gap_share <= cfg_data[3:0];
                `EVCOT_MREG_GAP_PX: gap_px <= cfg_data[7:0];
                `EVCOT_MREG_JOIN_STEPS: join_steps <= cfg_data[9:0];
                `EVCOT_MREG_JOIN_LIFE: join_life <= cfg_data[3:0];
                `EVCOT_MREG_JOIN_SPEED: join_speed <= cfg_data[3:0];
                `EVCOT_MREG_JOIN_REACH: join_reach <= cfg_data[3:0];
                `EVCOT_MREG_JOIN_PX: join_px <= cfg_data[7:0];
                `EVCOT_MREG_KEEP_OLDER: keep_older <= cfg_data[0:0];
                `EVCOT_MREG_REPORT_STEPS: report_steps <= cfg_data[9:0];
                default: ;
            endcase
        if (rst) begin
            step_log2 <= 5'd10;
            side_step <= 16'd1024;
            side_share <= 4'd4;
            side_shrink <= 4'd5;
            side_max <= 12'd160;
            gain_log2 <= 4'd4;
            gain_slow <= 3'd2;
            settle <= 6'd8;
            speed_max <= 15'd32767;
            friction <= 4'd7;
            nev_low <= 10'd8;
            nev_high <= 10'd256;
            seed_px <= 8'd4;
            ring_px <= 8'd2;
            ring_max <= 8'd24;
            ring_across <= 4'd1;
            ring_along <= 4'd1;
            ring_any <= 4'd1;
            elongation <= 4'd2;
            detect_ticks <= 24'd10000;
            life_log2 <= 4'd3;
            life_ticks <= 24'd20000;
            coast_ticks <= 24'd100000;
            birth_support <= 16'd200;
            birth_px <= 8'd4;
            birth_ticks <= 24'd10000;
            birth_travel <= 4'd1;
            gap_corrections <= 8'd16;
            gap_share <= 4'd7;
            gap_px <= 8'd2;
            join_steps <= 10'd10;
            join_life <= 4'd3;
            join_speed <= 4'd1;
            join_reach <= 4'd0;
            join_px <= 8'd2;
            keep_older <= 1'd0;
            report_steps <= 10'd4;
        end
    end

    wire unused = &{1'b0, cfg_data[31:24]};

endmodule

`default_nettype wire
