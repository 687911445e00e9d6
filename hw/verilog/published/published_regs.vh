// SPDX-License-Identifier: Apache-2.0
// The registers of a published tracker: addresses and values after reset.
// Generated from sw/evcot/hardware/published/registers.toml by `python -m evcot.hardware.generate`: edit there.
`ifndef EVCOT_PUBLISHED_REGS_VH
`define EVCOT_PUBLISHED_REGS_VH

`define PUBLISHED_REG_SELECT 8'd127
`define PUBLISHED_SELECT_FIRST 8'd1 // tracker 0; the next numbers the others
`define PUBLISHED_SELECT_NONE 8'd0
`define PUBLISHED_REG_INIT_CM_LOW 8'd78 // low coordinate of the initial centre
`define PUBLISHED_RESET_INIT_CM_LOW {8'd5, 8'd102, 8'd79, 8'd59} // tracker 0 lowest
`define PUBLISHED_REG_INIT_CM_HIGH 8'd79 // high coordinate of the initial centre
`define PUBLISHED_RESET_INIT_CM_HIGH 8'd80
`define PUBLISHED_REG_RADIX_TH 8'd80 // width of the ring around g
`define PUBLISHED_RESET_RADIX_TH 3'd3
`define PUBLISHED_REG_INIT_RADIX 8'd81 // initial g
`define PUBLISHED_RESET_INIT_RADIX 8'd64
`define PUBLISHED_REG_MAX_TIME 8'd82 // clocks from a centre update to the end of the life
`define PUBLISHED_RESET_MAX_TIME 32'd20000000
`define PUBLISHED_REG_NEV_TH 8'd86 // initial N_ev
`define PUBLISHED_RESET_NEV_TH 8'd15
`define PUBLISHED_REG_HIST_AVG 8'd87 // k in the averages' alpha = 2^-k; a write is clamped
`define PUBLISHED_RESET_HIST_AVG 4'd1
`define PUBLISHED_REG_ENABLE 8'd88 // 0xFF on, 0x00 off, other values are ignored
`define PUBLISHED_RESET_ENABLE 1'd0
`define PUBLISHED_REG_RADIX_STEP 8'd89 // how far g grows or shrinks
`define PUBLISHED_RESET_RADIX_STEP 3'd3
`define PUBLISHED_REG_RADIX_MAX 8'd90 // bound of g when it grows
`define PUBLISHED_RESET_RADIX_MAX 8'd17
`define PUBLISHED_REG_RADIX_MIN 8'd91 // bound of g when it shrinks
`define PUBLISHED_RESET_RADIX_MIN 8'd1

`endif
