// SPDX-License-Identifier: Apache-2.0
// Legal values of the registers of a slot, of the filters, of motion and of the classifier, for a module with the parameters that give
// their widths, and CLASSIFY.
// Generated from sw/evcot/hardware/contract.py and registers.toml by `python -m evcot.hardware.generate`: edit there.

localparam LOW_W = (CLASSIFY != 0) ? 5 : 1;  // bits of every lowest legal value

// Words that exist: the registers, and the word that commits. (Not as a case: Yosys
// would make a ROM of it that is read with the address, before its register.)
function slot_has(input [`EVCOT_REG_W-1:0] word);
    slot_has = word == `EVCOT_BANK_COMMIT
        || word == `EVCOT_REG_MODE
        || word == `EVCOT_REG_INIT_CM_X
        || word == `EVCOT_REG_INIT_CM_Y
        || word == `EVCOT_REG_INIT_RADIX
        || word == `EVCOT_REG_RADIX_TH
        || word == `EVCOT_REG_RADIX_STEP
        || word == `EVCOT_REG_RADIX_MIN
        || word == `EVCOT_REG_RADIX_MAX
        || word == `EVCOT_REG_HIST_AVG
        || word == `EVCOT_REG_MAX_TICKS
        || word == `EVCOT_REG_CLUST_NEV
        || word == `EVCOT_REG_NEV_MIN
        || word == `EVCOT_REG_NEV_MAX
        || word == `EVCOT_REG_NEV_TH
        || word == `EVCOT_REG_DETECT_TICKS;
endfunction

function [31:0] slot_low(input [`EVCOT_REG_W-1:0] word);
    case (word)
        `EVCOT_REG_MAX_TICKS: slot_low = 32'd1;
        `EVCOT_REG_CLUST_NEV: slot_low = 32'd1;
        `EVCOT_REG_NEV_MIN: slot_low = 32'd1;
        `EVCOT_REG_NEV_MAX: slot_low = 32'd1;
        `EVCOT_REG_DETECT_TICKS: slot_low = 32'd1;
        default: slot_low = 32'd0;
    endcase
endfunction

function [31:0] slot_high(input [`EVCOT_REG_W-1:0] word);
    case (word)
        `EVCOT_REG_MODE: slot_high = 32'd2;
        `EVCOT_REG_INIT_CM_X: slot_high = 32'hffffffff >> (32 - X_W);
        `EVCOT_REG_INIT_CM_Y: slot_high = 32'hffffffff >> (32 - Y_W);
        `EVCOT_REG_INIT_RADIX: slot_high = 32'hffffffff >> (32 - RADIX_W);
        `EVCOT_REG_RADIX_TH: slot_high = 32'hffffffff >> (32 - RADIX_W);
        `EVCOT_REG_RADIX_STEP: slot_high = 32'hffffffff >> (32 - RADIX_W);
        `EVCOT_REG_RADIX_MIN: slot_high = 32'hffffffff >> (32 - RADIX_W);
        `EVCOT_REG_RADIX_MAX: slot_high = 32'hffffffff >> (32 - RADIX_W);
        `EVCOT_REG_HIST_AVG: slot_high = 32'd8;
        `EVCOT_REG_MAX_TICKS: slot_high = 32'hffffffff >> (32 - TC_W);
        `EVCOT_REG_CLUST_NEV: slot_high = 32'hffffffff >> (32 - NEV_W);
        `EVCOT_REG_NEV_MIN: slot_high = 32'hffffffff >> (32 - NEV_W);
        `EVCOT_REG_NEV_MAX: slot_high = 32'hffffffff >> (32 - NEV_W);
        `EVCOT_REG_NEV_TH: slot_high = 32'hffffffff >> (32 - TC_W);
        `EVCOT_REG_DETECT_TICKS: slot_high = 32'hffffffff >> (32 - TC_W);
        default: slot_high = 32'hffffffff;
    endcase
endfunction

// An illegal value is refused, not clamped.
function slot_refuses(input [`EVCOT_REG_W-1:0] word);
    slot_refuses = word == `EVCOT_REG_MODE;
endfunction

// Words that exist: the registers, and the word that commits. (Not as a case: Yosys
// would make a ROM of it that is read with the address, before its register.)
function filter_has(input [`EVCOT_FREG_W-1:0] word);
    filter_has = word == `EVCOT_BANK_COMMIT
        || word == `EVCOT_FREG_ENABLE
        || word == `EVCOT_FREG_REGION_X0
        || word == `EVCOT_FREG_REGION_X1
        || word == `EVCOT_FREG_REGION_Y0
        || word == `EVCOT_FREG_REGION_Y1
        || word == `EVCOT_FREG_POLARITY
        || word == `EVCOT_FREG_REFRACTORY_TICKS
        || word == `EVCOT_FREG_ACTIVITY_TICKS
        || word == `EVCOT_FREG_ACTIVITY_SUPPORT
        || word == `EVCOT_FREG_RECENT_TICKS
        || word == `EVCOT_FREG_RECENT_RADIUS
        || word == `EVCOT_FREG_RECENT_SUPPORT
        || word == `EVCOT_FREG_DECAY_RATE
        || word == `EVCOT_FREG_DECAY_EPSILON
        || word == `EVCOT_FREG_DECAY_SUPPORT
        || word == `EVCOT_FREG_MASK
        || word == `EVCOT_FREG_ROWCOL_TICKS
        || word == `EVCOT_FREG_ROWCOL_RADIUS
        || word == `EVCOT_FREG_ROWCOL_SUPPORT
        || word == `EVCOT_FREG_STAMP_SHIFT
        || word == `EVCOT_FREG_NOISE_LOG2
        || word == `EVCOT_FREG_NOISE_2
        || word == `EVCOT_FREG_NOISE_3
        || word == `EVCOT_FREG_NOISE_4
        || word == `EVCOT_FREG_NOISE_5
        || word == `EVCOT_FREG_NOISE_6;
endfunction

function [31:0] filter_low(input [`EVCOT_FREG_W-1:0] word);
    case (word)
        `EVCOT_FREG_REFRACTORY_TICKS: filter_low = 32'd1;
        `EVCOT_FREG_RECENT_RADIUS: filter_low = 32'd1;
        `EVCOT_FREG_RECENT_SUPPORT: filter_low = 32'd1;
        `EVCOT_FREG_DECAY_RATE: filter_low = 32'd1;
        `EVCOT_FREG_DECAY_SUPPORT: filter_low = 32'd1;
        `EVCOT_FREG_ROWCOL_RADIUS: filter_low = 32'd1;
        `EVCOT_FREG_ROWCOL_SUPPORT: filter_low = 32'd1;
        default: filter_low = 32'd0;
    endcase
endfunction

function [31:0] filter_high(input [`EVCOT_FREG_W-1:0] word);
    case (word)
        `EVCOT_FREG_ENABLE: filter_high = 32'd255;
        `EVCOT_FREG_REGION_X0: filter_high = 32'd65535;
        `EVCOT_FREG_REGION_X1: filter_high = 32'd65535;
        `EVCOT_FREG_REGION_Y0: filter_high = 32'd65535;
        `EVCOT_FREG_REGION_Y1: filter_high = 32'd65535;
        `EVCOT_FREG_POLARITY: filter_high = 32'd1;
        `EVCOT_FREG_REFRACTORY_TICKS: filter_high = 32'hffffffff >> (33 - STAMP_W);
        `EVCOT_FREG_ACTIVITY_TICKS: filter_high = 32'hffffffff >> (33 - STAMP_W);
        `EVCOT_FREG_ACTIVITY_SUPPORT: filter_high = 32'd8;
        `EVCOT_FREG_RECENT_TICKS: filter_high = 32'hffffffff >> (33 - STAMP_W);
        `EVCOT_FREG_RECENT_RADIUS: filter_high = 32'd15;
        `EVCOT_FREG_RECENT_SUPPORT: filter_high = 32'd256;
        `EVCOT_FREG_DECAY_RATE: filter_high = 32'd16777216;
        `EVCOT_FREG_DECAY_EPSILON: filter_high = 32'd255;
        `EVCOT_FREG_DECAY_SUPPORT: filter_high = 32'd2048;
        `EVCOT_FREG_MASK: filter_high = 32'd4294967295;
        `EVCOT_FREG_ROWCOL_TICKS: filter_high = 32'hffffffff >> (33 - STAMP_W);
        `EVCOT_FREG_ROWCOL_RADIUS: filter_high = 32'd15;
        `EVCOT_FREG_ROWCOL_SUPPORT: filter_high = 32'd6;
        `EVCOT_FREG_STAMP_SHIFT: filter_high = 32'd15;
        `EVCOT_FREG_NOISE_LOG2: filter_high = 32'd20;
        `EVCOT_FREG_NOISE_2: filter_high = 32'd65535;
        `EVCOT_FREG_NOISE_3: filter_high = 32'd65535;
        `EVCOT_FREG_NOISE_4: filter_high = 32'd65535;
        `EVCOT_FREG_NOISE_5: filter_high = 32'd65535;
        `EVCOT_FREG_NOISE_6: filter_high = 32'd65535;
        default: filter_high = 32'hffffffff;
    endcase
endfunction

// An illegal value is refused, not clamped.
function filter_refuses(input [`EVCOT_FREG_W-1:0] word);
    filter_refuses = word == `EVCOT_FREG_ENABLE || word == `EVCOT_FREG_POLARITY;
endfunction

// Words that exist: the registers, and the word that commits, of both banks. (Not as a case: Yosys
// would make a ROM of it that is read with the address, before its register.)
function motion_has(input [`EVCOT_MREG_W-1:0] word);
    motion_has = word == {1'b0, `EVCOT_BANK_COMMIT} || word == {1'b1, `EVCOT_BANK_COMMIT}
        || word == `EVCOT_MREG_STEP_LOG2
        || word == `EVCOT_MREG_SIDE_STEP
        || word == `EVCOT_MREG_SIDE_SHARE
        || word == `EVCOT_MREG_SIDE_SHRINK
        || word == `EVCOT_MREG_SIDE_MAX
        || word == `EVCOT_MREG_GAIN_LOG2
        || word == `EVCOT_MREG_GAIN_SLOW
        || word == `EVCOT_MREG_GAIN_FAST
        || word == `EVCOT_MREG_SETTLE
        || word == `EVCOT_MREG_SPEED_MAX
        || word == `EVCOT_MREG_FRICTION
        || word == `EVCOT_MREG_COAST_SLOW
        || word == `EVCOT_MREG_NEV_LOW
        || word == `EVCOT_MREG_NEV_HIGH
        || word == `EVCOT_MREG_SEED_PX
        || word == `EVCOT_MREG_RING_PX
        || word == `EVCOT_MREG_RING_MAX
        || word == `EVCOT_MREG_RING_ACROSS
        || word == `EVCOT_MREG_RING_ALONG
        || word == `EVCOT_MREG_RING_ANY
        || word == `EVCOT_MREG_ELONGATION
        || word == `EVCOT_MREG_DETECT_TICKS
        || word == `EVCOT_MREG_LIFE_LOG2
        || word == `EVCOT_MREG_LIFE_TICKS
        || word == `EVCOT_MREG_COAST_TICKS
        || word == `EVCOT_MREG_RETURN_TICKS
        || word == `EVCOT_MREG_BIRTH_SUPPORT
        || word == `EVCOT_MREG_BIRTH_PX
        || word == `EVCOT_MREG_BIRTH_TICKS
        || word == `EVCOT_MREG_BIRTH_TRAVEL
        || word == `EVCOT_MREG_GAP_CORRECTIONS
        || word == `EVCOT_MREG_GAP_SHARE
        || word == `EVCOT_MREG_GAP_PX
        || word == `EVCOT_MREG_JOIN_STEPS
        || word == `EVCOT_MREG_JOIN_LIFE
        || word == `EVCOT_MREG_JOIN_SPEED
        || word == `EVCOT_MREG_JOIN_REACH
        || word == `EVCOT_MREG_JOIN_PX
        || word == `EVCOT_MREG_KEEP_OLDER
        || word == `EVCOT_MREG_REPORT_STEPS;
endfunction

function [31:0] motion_low(input [`EVCOT_MREG_W-1:0] word);
    case (word)
        `EVCOT_MREG_SIDE_STEP: motion_low = 32'd1;
        `EVCOT_MREG_SIDE_SHARE: motion_low = 32'd1;
        `EVCOT_MREG_SIDE_MAX: motion_low = 32'd1;
        `EVCOT_MREG_GAIN_LOG2: motion_low = 32'd1;
        `EVCOT_MREG_NEV_LOW: motion_low = 32'd1;
        `EVCOT_MREG_NEV_HIGH: motion_low = 32'd1;
        `EVCOT_MREG_SEED_PX: motion_low = 32'd1;
        `EVCOT_MREG_ELONGATION: motion_low = 32'd1;
        `EVCOT_MREG_DETECT_TICKS: motion_low = 32'd1;
        `EVCOT_MREG_LIFE_TICKS: motion_low = 32'd1;
        `EVCOT_MREG_COAST_TICKS: motion_low = 32'd1;
        `EVCOT_MREG_BIRTH_SUPPORT: motion_low = 32'd1;
        `EVCOT_MREG_GAP_SHARE: motion_low = 32'd1;
        `EVCOT_MREG_GAP_PX: motion_low = 32'd1;
        `EVCOT_MREG_JOIN_STEPS: motion_low = 32'd1;
        `EVCOT_MREG_REPORT_STEPS: motion_low = 32'd1;
        default: motion_low = 32'd0;
    endcase
endfunction

function [31:0] motion_high(input [`EVCOT_MREG_W-1:0] word);
    case (word)
        `EVCOT_MREG_STEP_LOG2: motion_high = 32'd20;
        `EVCOT_MREG_SIDE_STEP: motion_high = 32'd65535;
        `EVCOT_MREG_SIDE_SHARE: motion_high = 32'd8;
        `EVCOT_MREG_SIDE_SHRINK: motion_high = 32'd8;
        `EVCOT_MREG_SIDE_MAX: motion_high = 32'd4095;
        `EVCOT_MREG_GAIN_LOG2: motion_high = 32'd12;
        `EVCOT_MREG_GAIN_SLOW: motion_high = 32'd6;
        `EVCOT_MREG_GAIN_FAST: motion_high = 32'd12;
        `EVCOT_MREG_SETTLE: motion_high = 32'd63;
        `EVCOT_MREG_SPEED_MAX: motion_high = 32'd32767;
        `EVCOT_MREG_FRICTION: motion_high = 32'd15;
        `EVCOT_MREG_COAST_SLOW: motion_high = 32'd3;
        `EVCOT_MREG_NEV_LOW: motion_high = 32'd1023;
        `EVCOT_MREG_NEV_HIGH: motion_high = 32'd1023;
        `EVCOT_MREG_SEED_PX: motion_high = 32'd255;
        `EVCOT_MREG_RING_PX: motion_high = 32'd255;
        `EVCOT_MREG_RING_MAX: motion_high = 32'd255;
        `EVCOT_MREG_RING_ACROSS: motion_high = 32'd8;
        `EVCOT_MREG_RING_ALONG: motion_high = 32'd8;
        `EVCOT_MREG_RING_ANY: motion_high = 32'd8;
        `EVCOT_MREG_ELONGATION: motion_high = 32'd15;
        `EVCOT_MREG_DETECT_TICKS: motion_high = 32'd16777215;
        `EVCOT_MREG_LIFE_LOG2: motion_high = 32'd8;
        `EVCOT_MREG_LIFE_TICKS: motion_high = 32'd16777215;
        `EVCOT_MREG_COAST_TICKS: motion_high = 32'd16777215;
        `EVCOT_MREG_RETURN_TICKS: motion_high = 32'd16777215;
        `EVCOT_MREG_BIRTH_SUPPORT: motion_high = 32'd65535;
        `EVCOT_MREG_BIRTH_PX: motion_high = 32'd255;
        `EVCOT_MREG_BIRTH_TICKS: motion_high = 32'd16777215;
        `EVCOT_MREG_BIRTH_TRAVEL: motion_high = 32'd8;
        `EVCOT_MREG_GAP_CORRECTIONS: motion_high = 32'd255;
        `EVCOT_MREG_GAP_SHARE: motion_high = 32'd15;
        `EVCOT_MREG_GAP_PX: motion_high = 32'd255;
        `EVCOT_MREG_JOIN_STEPS: motion_high = 32'd1023;
        `EVCOT_MREG_JOIN_LIFE: motion_high = 32'd15;
        `EVCOT_MREG_JOIN_SPEED: motion_high = 32'd8;
        `EVCOT_MREG_JOIN_REACH: motion_high = 32'd8;
        `EVCOT_MREG_JOIN_PX: motion_high = 32'd255;
        `EVCOT_MREG_KEEP_OLDER: motion_high = 32'd1;
        `EVCOT_MREG_REPORT_STEPS: motion_high = 32'd1023;
        default: motion_high = 32'hffffffff;
    endcase
endfunction

// An illegal value is refused, not clamped.
function motion_refuses(input [`EVCOT_MREG_W-1:0] word);
    motion_refuses = word == `EVCOT_MREG_KEEP_OLDER;
endfunction

// Words that exist: the registers, and the word that commits. (Not as a case: Yosys
// would make a ROM of it that is read with the address, before its register.)
function classifier_has(input [`EVCOT_CREG_W-1:0] word);
    classifier_has = word == `EVCOT_BANK_COMMIT
        || word == `EVCOT_CREG_ENABLE
        || word == `EVCOT_CREG_WINDOW_LOG2
        || word == `EVCOT_CREG_SCALE_START
        || word == `EVCOT_CREG_SHIFT_1
        || word == `EVCOT_CREG_SHIFT_2
        || word == `EVCOT_CREG_CLASSES
        || word == `EVCOT_CREG_MARGIN_MIN;
endfunction

function [31:0] classifier_low(input [`EVCOT_CREG_W-1:0] word);
    case (word)
        `EVCOT_CREG_WINDOW_LOG2: classifier_low = 32'd8;
        `EVCOT_CREG_SCALE_START: classifier_low = 32'd16;
        `EVCOT_CREG_CLASSES: classifier_low = 32'd2;
        default: classifier_low = 32'd0;
    endcase
endfunction

function [31:0] classifier_high(input [`EVCOT_CREG_W-1:0] word);
    case (word)
        `EVCOT_CREG_ENABLE: classifier_high = 32'd1;
        `EVCOT_CREG_WINDOW_LOG2: classifier_high = 32'd12;
        `EVCOT_CREG_SCALE_START: classifier_high = 32'd4095;
        `EVCOT_CREG_SHIFT_1: classifier_high = 32'd15;
        `EVCOT_CREG_SHIFT_2: classifier_high = 32'd15;
        `EVCOT_CREG_CLASSES: classifier_high = 32'd10;
        `EVCOT_CREG_MARGIN_MIN: classifier_high = 32'd255;
        default: classifier_high = 32'hffffffff;
    endcase
endfunction

// An illegal value is refused, not clamped.
function classifier_refuses(input [`EVCOT_CREG_W-1:0] word);
    classifier_refuses = word == `EVCOT_CREG_ENABLE;
endfunction

// Values after reset.
function [31:0] filter_start(input [`EVCOT_FREG_W-1:0] word);
    case (word)
        `EVCOT_FREG_ENABLE: filter_start = 32'd24;
        `EVCOT_FREG_REGION_X1: filter_start = 32'd65535;
        `EVCOT_FREG_REGION_Y1: filter_start = 32'd65535;
        `EVCOT_FREG_POLARITY: filter_start = 32'd1;
        `EVCOT_FREG_REFRACTORY_TICKS: filter_start = (32'd1000 > 32'hffffffff >> (33 - STAMP_W)) ? 32'd1 : 32'd1000;
        `EVCOT_FREG_ACTIVITY_TICKS: filter_start = (32'd40000 > 32'hffffffff >> (33 - STAMP_W)) ? 32'd0 : 32'd40000;
        `EVCOT_FREG_RECENT_TICKS: filter_start = (32'd0 > 32'hffffffff >> (33 - STAMP_W)) ? 32'd0 : 32'd0;
        `EVCOT_FREG_RECENT_RADIUS: filter_start = 32'd4;
        `EVCOT_FREG_RECENT_SUPPORT: filter_start = 32'd1;
        `EVCOT_FREG_DECAY_RATE: filter_start = 32'd1;
        `EVCOT_FREG_DECAY_EPSILON: filter_start = 32'd26;
        `EVCOT_FREG_DECAY_SUPPORT: filter_start = 32'd256;
        `EVCOT_FREG_ROWCOL_TICKS: filter_start = (32'd0 > 32'hffffffff >> (33 - STAMP_W)) ? 32'd0 : 32'd0;
        `EVCOT_FREG_ROWCOL_RADIUS: filter_start = 32'd1;
        `EVCOT_FREG_ROWCOL_SUPPORT: filter_start = 32'd1;
        `EVCOT_FREG_STAMP_SHIFT: filter_start = 32'd7;
        `EVCOT_FREG_NOISE_LOG2: filter_start = 32'd14;
        `EVCOT_FREG_NOISE_2: filter_start = 32'd84;
        `EVCOT_FREG_NOISE_3: filter_start = 32'd239;
        `EVCOT_FREG_NOISE_4: filter_start = 32'd454;
        `EVCOT_FREG_NOISE_5: filter_start = 32'd716;
        `EVCOT_FREG_NOISE_6: filter_start = 32'd1013;
        default: filter_start = 32'd0;
    endcase
endfunction

function [31:0] motion_start(input [`EVCOT_MREG_W-1:0] word);
    case (word)
        `EVCOT_MREG_STEP_LOG2: motion_start = 32'd12;
        `EVCOT_MREG_SIDE_STEP: motion_start = 32'd1024;
        `EVCOT_MREG_SIDE_SHARE: motion_start = 32'd4;
        `EVCOT_MREG_SIDE_SHRINK: motion_start = 32'd4;
        `EVCOT_MREG_SIDE_MAX: motion_start = 32'd160;
        `EVCOT_MREG_GAIN_LOG2: motion_start = 32'd4;
        `EVCOT_MREG_GAIN_FAST: motion_start = 32'd2;
        `EVCOT_MREG_SETTLE: motion_start = 32'd8;
        `EVCOT_MREG_SPEED_MAX: motion_start = 32'd32767;
        `EVCOT_MREG_FRICTION: motion_start = 32'd5;
        `EVCOT_MREG_COAST_SLOW: motion_start = 32'd2;
        `EVCOT_MREG_NEV_LOW: motion_start = 32'd8;
        `EVCOT_MREG_NEV_HIGH: motion_start = 32'd325;
        `EVCOT_MREG_SEED_PX: motion_start = 32'd4;
        `EVCOT_MREG_RING_PX: motion_start = 32'd2;
        `EVCOT_MREG_RING_MAX: motion_start = 32'd21;
        `EVCOT_MREG_RING_ACROSS: motion_start = 32'd1;
        `EVCOT_MREG_RING_ALONG: motion_start = 32'd1;
        `EVCOT_MREG_RING_ANY: motion_start = 32'd2;
        `EVCOT_MREG_ELONGATION: motion_start = 32'd3;
        `EVCOT_MREG_DETECT_TICKS: motion_start = 32'd7521;
        `EVCOT_MREG_LIFE_LOG2: motion_start = 32'd2;
        `EVCOT_MREG_LIFE_TICKS: motion_start = 32'd40000;
        `EVCOT_MREG_COAST_TICKS: motion_start = 32'd93951;
        `EVCOT_MREG_RETURN_TICKS: motion_start = 32'd500000;
        `EVCOT_MREG_BIRTH_SUPPORT: motion_start = 32'd260;
        `EVCOT_MREG_BIRTH_PX: motion_start = 32'd2;
        `EVCOT_MREG_BIRTH_TICKS: motion_start = 32'd12000;
        `EVCOT_MREG_BIRTH_TRAVEL: motion_start = 32'd2;
        `EVCOT_MREG_GAP_CORRECTIONS: motion_start = 32'd15;
        `EVCOT_MREG_GAP_SHARE: motion_start = 32'd9;
        `EVCOT_MREG_GAP_PX: motion_start = 32'd3;
        `EVCOT_MREG_JOIN_STEPS: motion_start = 32'd2;
        `EVCOT_MREG_JOIN_LIFE: motion_start = 32'd3;
        `EVCOT_MREG_JOIN_SPEED: motion_start = 32'd1;
        `EVCOT_MREG_JOIN_PX: motion_start = 32'd3;
        `EVCOT_MREG_REPORT_STEPS: motion_start = 32'd1;
        default: motion_start = 32'd0;
    endcase
endfunction

function [31:0] classifier_start(input [`EVCOT_CREG_W-1:0] word);
    case (word)
        `EVCOT_CREG_WINDOW_LOG2: classifier_start = 32'd10;
        `EVCOT_CREG_SCALE_START: classifier_start = 32'd984;
        `EVCOT_CREG_SHIFT_1: classifier_start = 32'd8;
        `EVCOT_CREG_SHIFT_2: classifier_start = 32'd8;
        `EVCOT_CREG_CLASSES: classifier_start = 32'd10;
        default: classifier_start = 32'd0;
    endcase
endfunction

// What a commit compares: pairs of registers, one after the other, of which the first must not be more than the second.
localparam [2:0] MOTION_COMPARED = 3'd5;  // number of the last
localparam [2:0] TRACKS_COMPARED = 3'd1;  // number of the last

function [`EVCOT_MREG_W-1:0] motion_compared(input tracks, input [2:0] number);
    case ({tracks, number})
        4'd0: motion_compared = `EVCOT_MREG_NEV_LOW;
        4'd1: motion_compared = `EVCOT_MREG_NEV_HIGH;
        4'd2: motion_compared = `EVCOT_MREG_RING_PX;
        4'd3: motion_compared = `EVCOT_MREG_RING_MAX;
        4'd4: motion_compared = `EVCOT_MREG_SEED_PX;
        4'd5: motion_compared = `EVCOT_MREG_SIDE_MAX;
        4'd8: motion_compared = `EVCOT_MREG_LIFE_TICKS;
        4'd9: motion_compared = `EVCOT_MREG_COAST_TICKS;
        default: motion_compared = {`EVCOT_MREG_W{1'b0}};
    endcase
endfunction

// It is doubled before.
function motion_doubled(input tracks, input [2:0] number);
    motion_doubled = {tracks, number} == 4'd4;
endfunction
