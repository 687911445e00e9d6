// SPDX-License-Identifier: Apache-2.0
// The registers of cot_motion that hold for the whole array: docs/motion.md.
// Generated from sw/evcot/hardware/motion/contract.py by `python -m evcot.hardware.generate`: edit there.
//
// Values outside a register's range are not refused here.
//
// Latency:    2 clocks from a write to its register.
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

    // The two halves of the address, decoded, which all registers share.
    reg         written;  // any of them
    reg  [7:0]  row, column;
    reg  [23:0] data;
    wire [63:0] writes;

    genvar i;
    generate
        for (i = 0; i < 64; i = i + 1) begin : g_address
            assign writes[i] = row[i/8] && column[i%8];
        end
    endgenerate

    always @(posedge clk) begin
        written <= cfg_valid;
        row     <= cfg_valid ? 8'd1 << cfg_addr[5:3] : 8'd0;
        column  <= 8'd1 << cfg_addr[2:0];
        data    <= cfg_data[23:0];
        if (written) begin
            // 0 to 20: a motion step of each slot every 2^step_log2 ticks
            if (writes[`EVCOT_MREG_STEP_LOG2]) regs[`MOTION_STEP_LOG2] <= data[4:0];
            // 1 to 65535: way of a side for an event beyond and one within it, in 2^-12 px
            if (writes[`EVCOT_MREG_SIDE_STEP]) regs[`MOTION_SIDE_STEP] <= data[15:0];
            // 1 to 8: 2^-side_share of a slot's events lie beyond each side
            if (writes[`EVCOT_MREG_SIDE_SHARE]) regs[`MOTION_SIDE_SHARE] <= data[3:0];
            // 0 to 8: a side without an event beyond it moves inwards by 2^-side_shrink of the box; 0: never
            if (writes[`EVCOT_MREG_SIDE_SHRINK]) regs[`MOTION_SIDE_SHRINK] <= data[3:0];
            // 1 to 4095: longest side, px
            if (writes[`EVCOT_MREG_SIDE_MAX]) regs[`MOTION_SIDE_MAX] <= data[11:0];
            // 1 to 12: gain of a velocity's correction is 2^-gain_log2 in the end
            if (writes[`EVCOT_MREG_GAIN_LOG2]) regs[`MOTION_GAIN_LOG2] <= data[3:0];
            // 0 to 6: 2^gain_slow corrections until a gain is halved
            if (writes[`EVCOT_MREG_GAIN_SLOW]) regs[`MOTION_GAIN_SLOW] <= data[2:0];
            // 0 to 12: it is doubled while corrections agree in direction, up to 2^-gain_fast; 0: it is not
            if (writes[`EVCOT_MREG_GAIN_FAST]) regs[`MOTION_GAIN_FAST] <= data[3:0];
            // 0 to 63: corrections during which a velocity follows the slower of two sides
            if (writes[`EVCOT_MREG_SETTLE]) regs[`MOTION_SETTLE] <= data[5:0];
            // 0 to 32767: limit of a velocity on each axis, in 2^-12 px per step; 0: nothing moves between events
            if (writes[`EVCOT_MREG_SPEED_MAX]) regs[`MOTION_SPEED_MAX] <= data[14:0];
            // 0 to 15: a silent slot loses 2^-friction of its velocity a step; 0: nothing
            if (writes[`EVCOT_MREG_FRICTION]) regs[`MOTION_FRICTION] <= data[3:0];
            // 0 to 3: a silent slot moves by 2^-coast_slow of its velocity
            if (writes[`EVCOT_MREG_COAST_SLOW]) regs[`MOTION_COAST_SLOW] <= data[1:0];
            // 1 to 1023: fewest events of a correction
            if (writes[`EVCOT_MREG_NEV_LOW]) regs[`MOTION_NEV_LOW] <= data[9:0];
            // 1 to 1023: most events of a correction
            if (writes[`EVCOT_MREG_NEV_HIGH]) regs[`MOTION_NEV_HIGH] <= data[9:0];
            // 1 to 255: half the side of a new candidate's box
            if (writes[`EVCOT_MREG_SEED_PX]) regs[`MOTION_SEED_PX] <= data[7:0];
            // 0 to 255: least distance of a window from its box
            if (writes[`EVCOT_MREG_RING_PX]) regs[`MOTION_RING_PX] <= data[7:0];
            // 0 to 255: largest distance of a window from its box
            if (writes[`EVCOT_MREG_RING_MAX]) regs[`MOTION_RING_MAX] <= data[7:0];
            // 0 to 8: distance across the motion is 2^-ring_across of the box's side there
            if (writes[`EVCOT_MREG_RING_ACROSS]) regs[`MOTION_RING_ACROSS] <= data[3:0];
            // 0 to 8: distance along the motion is 2^-ring_along of the side across it
            if (writes[`EVCOT_MREG_RING_ALONG]) regs[`MOTION_RING_ALONG] <= data[3:0];
            // 0 to 8: distance, where there is no one direction, is 2^-ring_any of the side
            if (writes[`EVCOT_MREG_RING_ANY]) regs[`MOTION_RING_ANY] <= data[3:0];
            // 1 to 15: a box this many times as long as it is wide reaches along its motion as across it
            if (writes[`EVCOT_MREG_ELONGATION]) regs[`MOTION_ELONGATION] <= data[3:0];
            // 1 to 16777215: ticks within which a candidate must have its first correction
            if (writes[`EVCOT_MREG_DETECT_TICKS]) regs[`MOTION_DETECT_TICKS] <= data[23:0];
            // 0 to 8: a life ends after 2^life_log2 times the usual time between corrections without one
            if (writes[`EVCOT_MREG_LIFE_LOG2]) regs[`MOTION_LIFE_LOG2] <= data[3:0];
            // 1 to 16777215: but not before this time
            if (writes[`EVCOT_MREG_LIFE_TICKS]) regs[`MOTION_LIFE_TICKS] <= data[23:0];
            // 1 to 16777215: nor after this time
            if (writes[`EVCOT_MREG_COAST_TICKS]) regs[`MOTION_COAST_TICKS] <= data[23:0];
            // 0 to 16777215: ticks after its end in which a track goes on in what becomes visible there; 0: never
            if (writes[`EVCOT_MREG_RETURN_TICKS]) regs[`MOTION_RETURN_TICKS] <= data[23:0];
            // 1 to 65535: events that a candidate needs to become visible
            if (writes[`EVCOT_MREG_BIRTH_SUPPORT]) regs[`MOTION_BIRTH_SUPPORT] <= data[15:0];
            // 0 to 255: sides that it needs
            if (writes[`EVCOT_MREG_BIRTH_PX]) regs[`MOTION_BIRTH_PX] <= data[7:0];
            // 0 to 16777215: time that it needs
            if (writes[`EVCOT_MREG_BIRTH_TICKS]) regs[`MOTION_BIRTH_TICKS] <= data[23:0];
            // 0 to 8: since the 4th correction its middle has moved 1 px and 2^-birth_travel of a half side
            if (writes[`EVCOT_MREG_BIRTH_TRAVEL]) regs[`MOTION_BIRTH_TRAVEL] <= data[3:0];
            // 0 to 255: corrections after which a box is looked through for a gap; 0: never
            if (writes[`EVCOT_MREG_GAP_CORRECTIONS]) regs[`MOTION_GAP_CORRECTIONS] <= data[7:0];
            // 1 to 15: a bin with at most 2^-gap_share of the events is empty
            if (writes[`EVCOT_MREG_GAP_SHARE]) regs[`MOTION_GAP_SHARE] <= data[3:0];
            // 1 to 255: narrowest gap
            if (writes[`EVCOT_MREG_GAP_PX]) regs[`MOTION_GAP_PX] <= data[7:0];
            // 1 to 1023: steps for which two slots must move together before they merge
            if (writes[`EVCOT_MREG_JOIN_STEPS]) regs[`MOTION_JOIN_STEPS] <= data[9:0];
            // 0 to 15: and 2^-join_life of the younger's life
            if (writes[`EVCOT_MREG_JOIN_LIFE]) regs[`MOTION_JOIN_LIFE] <= data[3:0];
            // 0 to 8: together: velocities differ by at most 2^-join_speed of the larger
            if (writes[`EVCOT_MREG_JOIN_SPEED]) regs[`MOTION_JOIN_SPEED] <= data[3:0];
            // 0 to 8: one object: a gap along the motion of at most 2^-join_reach of the width, and join_px
            if (writes[`EVCOT_MREG_JOIN_REACH]) regs[`MOTION_JOIN_REACH] <= data[3:0];
            // 0 to 255: one object: a gap of at most so many px
            if (writes[`EVCOT_MREG_JOIN_PX]) regs[`MOTION_JOIN_PX] <= data[7:0];
            // 0 to 1: of two that merge stays 0: the one with more support; 1: the one that was seeded first
            if (writes[`EVCOT_MREG_KEEP_OLDER]) regs[`MOTION_KEEP_OLDER] <= data[0:0];
            // 1 to 1023: steps after which a slot without a correction is reported
            if (writes[`EVCOT_MREG_REPORT_STEPS]) regs[`MOTION_REPORT_STEPS] <= data[9:0];
        end
        if (rst) begin
            row <= 8'd0;
            regs[`MOTION_STEP_LOG2] <= 5'd12;
            regs[`MOTION_SIDE_STEP] <= 16'd1024;
            regs[`MOTION_SIDE_SHARE] <= 4'd4;
            regs[`MOTION_SIDE_SHRINK] <= 4'd4;
            regs[`MOTION_SIDE_MAX] <= 12'd160;
            regs[`MOTION_GAIN_LOG2] <= 4'd4;
            regs[`MOTION_GAIN_SLOW] <= 3'd0;
            regs[`MOTION_GAIN_FAST] <= 4'd2;
            regs[`MOTION_SETTLE] <= 6'd8;
            regs[`MOTION_SPEED_MAX] <= 15'd32767;
            regs[`MOTION_FRICTION] <= 4'd5;
            regs[`MOTION_COAST_SLOW] <= 2'd2;
            regs[`MOTION_NEV_LOW] <= 10'd8;
            regs[`MOTION_NEV_HIGH] <= 10'd325;
            regs[`MOTION_SEED_PX] <= 8'd4;
            regs[`MOTION_RING_PX] <= 8'd2;
            regs[`MOTION_RING_MAX] <= 8'd21;
            regs[`MOTION_RING_ACROSS] <= 4'd1;
            regs[`MOTION_RING_ALONG] <= 4'd1;
            regs[`MOTION_RING_ANY] <= 4'd2;
            regs[`MOTION_ELONGATION] <= 4'd3;
            regs[`MOTION_DETECT_TICKS] <= 24'd7521;
            regs[`MOTION_LIFE_LOG2] <= 4'd2;
            regs[`MOTION_LIFE_TICKS] <= 24'd40000;
            regs[`MOTION_COAST_TICKS] <= 24'd93951;
            regs[`MOTION_RETURN_TICKS] <= 24'd500000;
            regs[`MOTION_BIRTH_SUPPORT] <= 16'd260;
            regs[`MOTION_BIRTH_PX] <= 8'd2;
            regs[`MOTION_BIRTH_TICKS] <= 24'd12000;
            regs[`MOTION_BIRTH_TRAVEL] <= 4'd2;
            regs[`MOTION_GAP_CORRECTIONS] <= 8'd15;
            regs[`MOTION_GAP_SHARE] <= 4'd9;
            regs[`MOTION_GAP_PX] <= 8'd3;
            regs[`MOTION_JOIN_STEPS] <= 10'd2;
            regs[`MOTION_JOIN_LIFE] <= 4'd3;
            regs[`MOTION_JOIN_SPEED] <= 4'd1;
            regs[`MOTION_JOIN_REACH] <= 4'd0;
            regs[`MOTION_JOIN_PX] <= 8'd3;
            regs[`MOTION_KEEP_OLDER] <= 1'd0;
            regs[`MOTION_REPORT_STEPS] <= 10'd1;
        end
    end

    wire unused = &{1'b0, cfg_data[31:24], writes};

endmodule

`default_nettype wire
