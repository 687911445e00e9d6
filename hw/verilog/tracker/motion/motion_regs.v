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
`include "motion_fields.vh"

module motion_regs (
    input  wire        clk,
    input  wire        rst,

    input  wire        cfg_valid,
    input  wire [`EVCOT_MREG_W-1:0] cfg_addr,
    input  wire [31:0] cfg_data,
    output reg  [`MOTION_REGS_W-1:0] regs  // where each lies: motion_fields.vh
);

    always @(posedge clk) begin
        if (cfg_valid)
            case (cfg_addr)
                // 0 to 20: a motion step every 2^step_log2 ticks
                `EVCOT_MREG_STEP_LOG2: regs[`MOTION_STEP_LOG2] <= cfg_data[4:0];
                // 1 to 65535: way of a side for an event beyond and one within it, in 2^-12 px
                `EVCOT_MREG_SIDE_STEP: regs[`MOTION_SIDE_STEP] <= cfg_data[15:0];
                // 1 to 8: 2^-side_share of a slot's events lie beyond each side
                `EVCOT_MREG_SIDE_SHARE: regs[`MOTION_SIDE_SHARE] <= cfg_data[3:0];
                // 0 to 8: a side without an event beyond it moves inwards by 2^-side_shrink of the box; 0: never
                `EVCOT_MREG_SIDE_SHRINK: regs[`MOTION_SIDE_SHRINK] <= cfg_data[3:0];
                // 1 to 4095: longest side, px
                `EVCOT_MREG_SIDE_MAX: regs[`MOTION_SIDE_MAX] <= cfg_data[11:0];
                // 1 to 12: gain of a velocity's correction is 2^-gain_log2 in the end
                `EVCOT_MREG_GAIN_LOG2: regs[`MOTION_GAIN_LOG2] <= cfg_data[3:0];
                // 0 to 6: 2^gain_slow corrections until a gain is halved
                `EVCOT_MREG_GAIN_SLOW: regs[`MOTION_GAIN_SLOW] <= cfg_data[2:0];
                // 0 to 63: corrections during which a velocity follows the slower of two sides
                `EVCOT_MREG_SETTLE: regs[`MOTION_SETTLE] <= cfg_data[5:0];
                // 0 to 32767: limit of a velocity on each axis, in 2^-12 px per step; 0: nothing moves between events
                `EVCOT_MREG_SPEED_MAX: regs[`MOTION_SPEED_MAX] <= cfg_data[14:0];
                // 0 to 15: a silent slot loses 2^-friction of its velocity a step; 0: nothing
                `EVCOT_MREG_FRICTION: regs[`MOTION_FRICTION] <= cfg_data[3:0];
                // 1 to 1023: fewest events of a correction
                `EVCOT_MREG_NEV_LOW: regs[`MOTION_NEV_LOW] <= cfg_data[9:0];
                // 1 to 1023: most events of a correction
                `EVCOT_MREG_NEV_HIGH: regs[`MOTION_NEV_HIGH] <= cfg_data[9:0];
                // 1 to 255: half the side of a new candidate's box
                `EVCOT_MREG_SEED_PX: regs[`MOTION_SEED_PX] <= cfg_data[7:0];
                // 0 to 255: least distance of a window from its box
                `EVCOT_MREG_RING_PX: regs[`MOTION_RING_PX] <= cfg_data[7:0];
                // 0 to 255: largest distance of a window from its box
                `EVCOT_MREG_RING_MAX: regs[`MOTION_RING_MAX] <= cfg_data[7:0];
                // 0 to 8: distance across the motion is 2^-ring_across of the box's side there
                `EVCOT_MREG_RING_ACROSS: regs[`MOTION_RING_ACROSS] <= cfg_data[3:0];
                // 0 to 8: distance along the motion is 2^-ring_along of the side across it
                `EVCOT_MREG_RING_ALONG: regs[`MOTION_RING_ALONG] <= cfg_data[3:0];
                // 0 to 8: distance, where there is no one direction, is 2^-ring_any of the side
                `EVCOT_MREG_RING_ANY: regs[`MOTION_RING_ANY] <= cfg_data[3:0];
                // 1 to 15: a box this many times as long as it is wide reaches along its motion as across it
                `EVCOT_MREG_ELONGATION: regs[`MOTION_ELONGATION] <= cfg_data[3:0];
                // 1 to 16777215: ticks within which a candidate must have its first correction
                `EVCOT_MREG_DETECT_TICKS: regs[`MOTION_DETECT_TICKS] <= cfg_data[23:0];
                // 0 to 8: a life ends after 2^life_log2 times the usual time between corrections without one
                `EVCOT_MREG_LIFE_LOG2: regs[`MOTION_LIFE_LOG2] <= cfg_data[3:0];
                // 1 to 16777215: but not before this time
                `EVCOT_MREG_LIFE_TICKS: regs[`MOTION_LIFE_TICKS] <= cfg_data[23:0];
                // 1 to 16777215: nor after this time
                `EVCOT_MREG_COAST_TICKS: regs[`MOTION_COAST_TICKS] <= cfg_data[23:0];
                // 1 to 65535: events that a candidate needs to become visible
                `EVCOT_MREG_BIRTH_SUPPORT: regs[`MOTION_BIRTH_SUPPORT] <= cfg_data[15:0];
                // 0 to 255: sides that it needs
                `EVCOT_MREG_BIRTH_PX: regs[`MOTION_BIRTH_PX] <= cfg_data[7:0];
                // 0 to 16777215: time that it needs
                `EVCOT_MREG_BIRTH_TICKS: regs[`MOTION_BIRTH_TICKS] <= cfg_data[23:0];
                // 0 to 8: since the 4th correction its middle has moved 1 px and 2^-birth_travel of a half side
                `EVCOT_MREG_BIRTH_TRAVEL: regs[`MOTION_BIRTH_TRAVEL] <= cfg_data[3:0];
                // 0 to 255: corrections after which a box is looked through for a gap; 0: never
                `EVCOT_MREG_GAP_CORRECTIONS: regs[`MOTION_GAP_CORRECTIONS] <= cfg_data[7:0];
                // 1 to 15: a bin with at most 2^-gap_share of the events is empty
                `EVCOT_MREG_GAP_SHARE: regs[`MOTION_GAP_SHARE] <= cfg_data[3:0];
                // 1 to 255: narrowest gap
                `EVCOT_MREG_GAP_PX: regs[`MOTION_GAP_PX] <= cfg_data[7:0];
                // 1 to 1023: steps for which two slots must move together before they merge
                `EVCOT_MREG_JOIN_STEPS: regs[`MOTION_JOIN_STEPS] <= cfg_data[9:0];
                // 0 to 15: and 2^-join_life of the younger's life
                `EVCOT_MREG_JOIN_LIFE: regs[`MOTION_JOIN_LIFE] <= cfg_data[3:0];
                // 0 to 8: together: velocities differ by at most 2^-join_speed of the larger
                `EVCOT_MREG_JOIN_SPEED: regs[`MOTION_JOIN_SPEED] <= cfg_data[3:0];
                // 0 to 8: one object: a gap along the motion of at most 2^-join_reach of the width
                `EVCOT_MREG_JOIN_REACH: regs[`MOTION_JOIN_REACH] <= cfg_data[3:0];
                // 0 to 255: one object: a gap of so many px otherwise
                `EVCOT_MREG_JOIN_PX: regs[`MOTION_JOIN_PX] <= cfg_data[7:0];
                // 0 to 1: of two that merge stays 0: the one with more support; 1: the one that was seeded first
                `EVCOT_MREG_KEEP_OLDER: regs[`MOTION_KEEP_OLDER] <= cfg_data[0:0];
                // 1 to 1023: steps after which a slot without a correction is reported
                `EVCOT_MREG_REPORT_STEPS: regs[`MOTION_REPORT_STEPS] <= cfg_data[9:0];
                default: ;
            endcase
        if (rst) begin
            regs[`MOTION_STEP_LOG2] <= 5'd10;
            regs[`MOTION_SIDE_STEP] <= 16'd1024;
            regs[`MOTION_SIDE_SHARE] <= 4'd4;
            regs[`MOTION_SIDE_SHRINK] <= 4'd5;
            regs[`MOTION_SIDE_MAX] <= 12'd160;
            regs[`MOTION_GAIN_LOG2] <= 4'd4;
            regs[`MOTION_GAIN_SLOW] <= 3'd2;
            regs[`MOTION_SETTLE] <= 6'd8;
            regs[`MOTION_SPEED_MAX] <= 15'd32767;
            regs[`MOTION_FRICTION] <= 4'd7;
            regs[`MOTION_NEV_LOW] <= 10'd8;
            regs[`MOTION_NEV_HIGH] <= 10'd256;
            regs[`MOTION_SEED_PX] <= 8'd4;
            regs[`MOTION_RING_PX] <= 8'd2;
            regs[`MOTION_RING_MAX] <= 8'd24;
            regs[`MOTION_RING_ACROSS] <= 4'd1;
            regs[`MOTION_RING_ALONG] <= 4'd1;
            regs[`MOTION_RING_ANY] <= 4'd1;
            regs[`MOTION_ELONGATION] <= 4'd2;
            regs[`MOTION_DETECT_TICKS] <= 24'd10000;
            regs[`MOTION_LIFE_LOG2] <= 4'd3;
            regs[`MOTION_LIFE_TICKS] <= 24'd20000;
            regs[`MOTION_COAST_TICKS] <= 24'd100000;
            regs[`MOTION_BIRTH_SUPPORT] <= 16'd200;
            regs[`MOTION_BIRTH_PX] <= 8'd4;
            regs[`MOTION_BIRTH_TICKS] <= 24'd10000;
            regs[`MOTION_BIRTH_TRAVEL] <= 4'd1;
            regs[`MOTION_GAP_CORRECTIONS] <= 8'd16;
            regs[`MOTION_GAP_SHARE] <= 4'd7;
            regs[`MOTION_GAP_PX] <= 8'd2;
            regs[`MOTION_JOIN_STEPS] <= 10'd10;
            regs[`MOTION_JOIN_LIFE] <= 4'd3;
            regs[`MOTION_JOIN_SPEED] <= 4'd1;
            regs[`MOTION_JOIN_REACH] <= 4'd0;
            regs[`MOTION_JOIN_PX] <= 8'd2;
            regs[`MOTION_KEEP_OLDER] <= 1'd0;
            regs[`MOTION_REPORT_STEPS] <= 10'd4;
        end
    end

    wire unused = &{1'b0, cfg_data[31:24]};

endmodule

`default_nettype wire
