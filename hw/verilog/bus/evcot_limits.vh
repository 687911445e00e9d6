// SPDX-License-Identifier: Apache-2.0
// Legal values of the registers of a slot and of the filters, for a module with the parameters that give their widths.
// Generated from sw/evcot/hardware/contract.py and registers.toml by `python -m evcot.hardware.generate`: edit there.

// Words that exist: the registers, and the word that commits. (Not as a case: Yosys would make a ROM of it that is read with
// the address, before its register.)
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

// Words that exist: the registers, and the word that commits. (Not as a case: Yosys would make a ROM of it that is read with
// the address, before its register.)
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
        || word == `EVCOT_FREG_STAMP_SHIFT;
endfunction

function [31:0] filter_low(input [`EVCOT_FREG_W-1:0] word);
    case (word)
        `EVCOT_FREG_REFRACTORY_TICKS: filter_low = 32'd1;
        `EVCOT_FREG_ACTIVITY_SUPPORT: filter_low = 32'd1;
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
        default: filter_high = 32'hffffffff;
    endcase
endfunction

// An illegal value is refused, not clamped.
function filter_refuses(input [`EVCOT_FREG_W-1:0] word);
    filter_refuses = word == `EVCOT_FREG_ENABLE || word == `EVCOT_FREG_POLARITY;
endfunction
