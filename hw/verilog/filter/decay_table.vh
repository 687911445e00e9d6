// SPDX-License-Identifier: Apache-2.0
// The decaying weight within one half-life: 256 * 2^(-age/32), in 1/256, at an age in units of 1/32 half-life.
// Generated from sw/evcot/filters/decay.py by `python -m evcot.hardware.generate`: edit there.
// For the inside of a module, so it carries no include guard.
localparam CLOCK_FRAC = 24;  // fractional bits of the clock that counts units
function [8:0] decay_weight;
    input [4:0] age;
    begin
        case (age)
            5'd0: decay_weight = 9'd256;
            5'd1: decay_weight = 9'd251;
            5'd2: decay_weight = 9'd245;
            5'd3: decay_weight = 9'd240;
            5'd4: decay_weight = 9'd235;
            5'd5: decay_weight = 9'd230;
            5'd6: decay_weight = 9'd225;
            5'd7: decay_weight = 9'd220;
            5'd8: decay_weight = 9'd215;
            5'd9: decay_weight = 9'd211;
            5'd10: decay_weight = 9'd206;
            5'd11: decay_weight = 9'd202;
            5'd12: decay_weight = 9'd197;
            5'd13: decay_weight = 9'd193;
            5'd14: decay_weight = 9'd189;
            5'd15: decay_weight = 9'd185;
            5'd16: decay_weight = 9'd181;
            5'd17: decay_weight = 9'd177;
            5'd18: decay_weight = 9'd173;
            5'd19: decay_weight = 9'd170;
            5'd20: decay_weight = 9'd166;
            5'd21: decay_weight = 9'd162;
            5'd22: decay_weight = 9'd159;
            5'd23: decay_weight = 9'd156;
            5'd24: decay_weight = 9'd152;
            5'd25: decay_weight = 9'd149;
            5'd26: decay_weight = 9'd146;
            5'd27: decay_weight = 9'd143;
            5'd28: decay_weight = 9'd140;
            5'd29: decay_weight = 9'd137;
            5'd30: decay_weight = 9'd134;
            5'd31: decay_weight = 9'd131;
        endcase
    end
endfunction
