// SPDX-License-Identifier: Apache-2.0
// Definitions shared by RTL and software: states, record kinds, modes, register addresses, parameter ranges.
// Generated from sw/evcot/hardware/contract.py by `python -m evcot.hardware.generate`: edit there.
`ifndef EVCOT_DEFS_VH
`define EVCOT_DEFS_VH

// Hardware shape: inclusive parameter ranges.
`define EVCOT_N_SLOTS_MIN 1
`define EVCOT_N_SLOTS_MAX 64 // tracker slots
`define EVCOT_X_W_MIN 1
`define EVCOT_X_W_MAX 16 // bits of an x address
`define EVCOT_Y_W_MIN 1
`define EVCOT_Y_W_MAX 16 // bits of a y address
`define EVCOT_FRAC_MIN 0
`define EVCOT_FRAC_MAX 8 // fractional bits of a centre and of an average; 0 truncates like the published shifts
`define EVCOT_TICK_W_MIN 1
`define EVCOT_TICK_W_MAX 32 // bits of the tick input
`define EVCOT_RADIX_W_MIN 1
`define EVCOT_RADIX_W_MAX 12 // bits of a radius register
`define EVCOT_NEV_W_MIN 1
`define EVCOT_NEV_W_MAX 16 // bits of N_ev
`define EVCOT_TC_W_MIN 1
`define EVCOT_TC_W_MAX 32 // bits of a timer
`define EVCOT_SUP_W_MIN 1
`define EVCOT_SUP_W_MAX 32 // bits of a support count, saturating
`define EVCOT_ID_W_MIN 1
`define EVCOT_ID_W_MAX 32 // bits of a track id
`define EVCOT_SEQ_W_MIN 8
`define EVCOT_SEQ_W_MAX 48 // bits of an event's sequence number
`define EVCOT_TIME_W_MIN 8
`define EVCOT_TIME_W_MAX 48 // bits of the tick count

// From this hist_avg on neither average nor centre moves.
`define EVCOT_HIST_AVG_STILL 10

// Shape of a filter chain: inclusive parameter ranges.
`define EVCOT_WIDTH_MIN 1
`define EVCOT_WIDTH_MAX 65536 // pixels of the sensor across
`define EVCOT_HEIGHT_MIN 1
`define EVCOT_HEIGHT_MAX 65536 // pixels of the sensor down
`define EVCOT_STAMP_W_MIN 4
`define EVCOT_STAMP_W_MAX 32 // bits of a time stamp in a filter's memory
`define EVCOT_RECENT_DEPTH_MIN 1
`define EVCOT_RECENT_DEPTH_MAX 256 // events in the FIFO of recent events
`define EVCOT_CELL_PX_MIN 0
`define EVCOT_CELL_PX_MAX 4 // side of a cell in pixels: 1, 2 or 4; 0: a time stamp per pixel and filter
`define EVCOT_CELL_STAMP_W_MIN 0
`define EVCOT_CELL_STAMP_W_MAX 32 // bits of a time stamp of refractory and activity in a cell; 0: as many as 9 bits hold

// States of the tracker FSM.
`define EVCOT_ST_W 3
`define EVCOT_ST_INIT_CELL 3'd0
`define EVCOT_ST_IDLE 3'd1
`define EVCOT_ST_EV_DISCRI 3'd2
`define EVCOT_ST_EV_PASS_TH 3'd3
`define EVCOT_ST_EV_NO_PROC 3'd4
`define EVCOT_ST_EV_PROC 3'd5

// Kinds of a record.
`define EVCOT_KIND_W 2
`define EVCOT_KIND_BORN 2'd0
`define EVCOT_KIND_MOVED 2'd1
`define EVCOT_KIND_MERGED 2'd2
`define EVCOT_KIND_LOST 2'd3

// How a slot starts a life: register `mode`.
`define EVCOT_MODE_W 2
`define EVCOT_MODE_OFF 2'd0
`define EVCOT_MODE_FIXED 2'd1
`define EVCOT_MODE_SEEDED 2'd2

// Word addresses of the registers of a slot.
`define EVCOT_REG_W 5
`define EVCOT_REG_MODE 5'd0
`define EVCOT_REG_INIT_CM_X 5'd1
`define EVCOT_REG_INIT_CM_Y 5'd2
`define EVCOT_REG_INIT_RADIX 5'd3
`define EVCOT_REG_RADIX_TH 5'd4
`define EVCOT_REG_RADIX_STEP 5'd5
`define EVCOT_REG_RADIX_MIN 5'd6
`define EVCOT_REG_RADIX_MAX 5'd7
`define EVCOT_REG_HIST_AVG 5'd8
`define EVCOT_REG_MAX_TICKS 5'd9
`define EVCOT_REG_CLUST_NEV 5'd10
`define EVCOT_REG_NEV_MIN 5'd11
`define EVCOT_REG_NEV_MAX 5'd12
`define EVCOT_REG_NEV_TH 5'd13
`define EVCOT_REG_DETECT_TICKS 5'd14

// The filters of a chain, in their order: bits of `enable`.
`define EVCOT_FILTER_W 3
`define EVCOT_FILTER_REGION 3'd0
`define EVCOT_FILTER_POLARITY 3'd1
`define EVCOT_FILTER_MASK 3'd2
`define EVCOT_FILTER_REFRACTORY 3'd3
`define EVCOT_FILTER_ACTIVITY 3'd4
`define EVCOT_FILTER_RECENT 3'd5
`define EVCOT_FILTER_DECAY 3'd6
`define EVCOT_FILTER_ROWCOL 3'd7

// Word addresses of the registers of a filter chain.
`define EVCOT_FREG_W 5
`define EVCOT_FREG_ENABLE 5'd0
`define EVCOT_FREG_REGION_X0 5'd1
`define EVCOT_FREG_REGION_X1 5'd2
`define EVCOT_FREG_REGION_Y0 5'd3
`define EVCOT_FREG_REGION_Y1 5'd4
`define EVCOT_FREG_POLARITY 5'd5
`define EVCOT_FREG_REFRACTORY_TICKS 5'd6
`define EVCOT_FREG_ACTIVITY_TICKS 5'd7
`define EVCOT_FREG_ACTIVITY_SUPPORT 5'd8
`define EVCOT_FREG_RECENT_TICKS 5'd9
`define EVCOT_FREG_RECENT_RADIUS 5'd10
`define EVCOT_FREG_RECENT_SUPPORT 5'd11
`define EVCOT_FREG_DECAY_RATE 5'd12
`define EVCOT_FREG_DECAY_EPSILON 5'd13
`define EVCOT_FREG_DECAY_SUPPORT 5'd14
`define EVCOT_FREG_MASK 5'd15
`define EVCOT_FREG_ROWCOL_TICKS 5'd16
`define EVCOT_FREG_ROWCOL_RADIUS 5'd17
`define EVCOT_FREG_ROWCOL_SUPPORT 5'd18
`define EVCOT_FREG_STAMP_SHIFT 5'd19
`define EVCOT_FREG_NOISE_LOG2 5'd20
`define EVCOT_FREG_NOISE_2 5'd21
`define EVCOT_FREG_NOISE_3 5'd22
`define EVCOT_FREG_NOISE_4 5'd23
`define EVCOT_FREG_NOISE_5 5'd24
`define EVCOT_FREG_NOISE_6 5'd25

// Addresses on the port of cot_motion: the mode of a slot, then the words of both banks.
`define EVCOT_MREG_W 6
`define EVCOT_MREG_MODE 6'd0
`define EVCOT_MREG_STEP_LOG2 6'd1
`define EVCOT_MREG_SIDE_STEP 6'd2
`define EVCOT_MREG_SIDE_SHARE 6'd3
`define EVCOT_MREG_SIDE_SHRINK 6'd4
`define EVCOT_MREG_SIDE_MAX 6'd5
`define EVCOT_MREG_GAIN_LOG2 6'd6
`define EVCOT_MREG_GAIN_SLOW 6'd7
`define EVCOT_MREG_GAIN_FAST 6'd8
`define EVCOT_MREG_SETTLE 6'd9
`define EVCOT_MREG_SPEED_MAX 6'd10
`define EVCOT_MREG_FRICTION 6'd11
`define EVCOT_MREG_COAST_SLOW 6'd12
`define EVCOT_MREG_NEV_LOW 6'd13
`define EVCOT_MREG_NEV_HIGH 6'd14
`define EVCOT_MREG_SEED_PX 6'd15
`define EVCOT_MREG_RING_PX 6'd16
`define EVCOT_MREG_RING_MAX 6'd17
`define EVCOT_MREG_RING_ACROSS 6'd18
`define EVCOT_MREG_RING_ALONG 6'd19
`define EVCOT_MREG_RING_ANY 6'd20
`define EVCOT_MREG_ELONGATION 6'd21
`define EVCOT_MREG_DETECT_TICKS 6'd33
`define EVCOT_MREG_LIFE_LOG2 6'd34
`define EVCOT_MREG_LIFE_TICKS 6'd35
`define EVCOT_MREG_COAST_TICKS 6'd36
`define EVCOT_MREG_RETURN_TICKS 6'd37
`define EVCOT_MREG_BIRTH_SUPPORT 6'd38
`define EVCOT_MREG_BIRTH_PX 6'd39
`define EVCOT_MREG_BIRTH_TICKS 6'd40
`define EVCOT_MREG_BIRTH_TRAVEL 6'd41
`define EVCOT_MREG_GAP_CORRECTIONS 6'd42
`define EVCOT_MREG_GAP_SHARE 6'd43
`define EVCOT_MREG_GAP_PX 6'd44
`define EVCOT_MREG_JOIN_STEPS 6'd45
`define EVCOT_MREG_JOIN_LIFE 6'd46
`define EVCOT_MREG_JOIN_SPEED 6'd47
`define EVCOT_MREG_JOIN_REACH 6'd48
`define EVCOT_MREG_JOIN_PX 6'd49
`define EVCOT_MREG_KEEP_OLDER 6'd50
`define EVCOT_MREG_REPORT_STEPS 6'd51

// Word addresses of the registers of the classifier in their bank.
`define EVCOT_CREG_W 5
`define EVCOT_CREG_ENABLE 5'd1
`define EVCOT_CREG_WINDOW_LOG2 5'd2
`define EVCOT_CREG_SCALE_START 5'd3
`define EVCOT_CREG_SHIFT_1 5'd4
`define EVCOT_CREG_SHIFT_2 5'd5
`define EVCOT_CREG_CLASSES 5'd6
`define EVCOT_CREG_MARGIN_MIN 5'd7

`endif
