// SPDX-License-Identifier: Apache-2.0
// The cells of one angle of hough_lines.v, in block RAM: reads a cell, counts a hit, writes the cell back (docs/lines.md).
//
// A word is the period at which the cell's potential reaches 0. Slots move through the stages row, found, past and hit; a cell is
// written from `hit`, and slots up to three behind it may have read the cell before. They take over what the slot ahead leaves:
// the third in `found` from a register, the second in `found` directly, the first in `past` directly. Slots so near are at most
// one period apart, as a period has at least four events.
//
// Latency:    3 clocks from row to hit_row and fires: RAM, potential, hits.
// Throughput: 1 event per clock.
// Stall:      nothing moves while advance is low.
// Reset:      none of its own; while clearing is high, the cell clear_row is emptied. hit_period must be 0 then, and inhibits high.
// RAM:        2^RHO_W words of 12 bits.
// Combinational paths: none; fires and hit_row come from registers, fires through a comparison with threshold.
`default_nettype none

module hough_angle #(
    parameter RHO_W = 9  // bits of a cell's index, 4 to 12
) (
    input  wire             clk,
    input  wire             advance,  // all slots move on

    input  wire [3:0]       threshold,

    // the slot in `row`
    input  wire [RHO_W-1:0] row,

    // what all angles share; a period is that of the slot's event, modulo 2^12
    input  wire [11:0]      found_period,
    input  wire [11:0]      hit_period,
    input  wire             hit_event,      // the slot in `hit` is an event
    input  wire             past_crosses,   // a period ended between the slots in `past` and `hit`
    input  wire             found_crosses,  // between the slots in `found` and `hit`
    input  wire             last_crosses,   // between the slots in `found` and behind `hit`
    input  wire             inhibits,       // an angle fires: the cell in `hit` is emptied

    input  wire             clearing,
    input  wire [RHO_W-1:0] clear_row,

    output wire             fires,          // the cell in `hit` has reached the threshold
    output wire [RHO_W-1:0] hit_row
);

    parameter_check #(.OK(RHO_W >= 4 && RHO_W <= 12)) RHO_W_must_be_4_to_12 ();

    `include "hough_table.vh"

    function [3:0] leaked;  // a potential after the end of a period, if one has ended
        input [3:0] potential;
        input       crosses;
        leaked = (crosses && potential != 4'd0) ? potential - 4'd1 : potential;
    endfunction

    // ---- memory ------------------------------------------------------------------------------------------------------

    (* ram_style = "block", no_rw_check *)
    reg [STAMP_W-1:0] cells [0:(1<<RHO_W)-1];
    reg [STAMP_W-1:0] found;

    reg  [3:0]       hit_hits;
    reg  [RHO_W-1:0] hit_row_reg;

    wire [3:0]         left       = inhibits ? 4'd0 : hit_hits;  // potential that the slot in `hit` leaves
    wire [STAMP_W-1:0] write_word = hit_period + {{(STAMP_W - 4) {1'b0}}, left};

    always @(posedge clk) begin
        if (clearing || (advance && hit_event)) cells[clearing ? clear_row : hit_row_reg] <= write_word;
        if (advance) found <= cells[row];
    end

    // ---- potential, hits ---------------------------------------------------------------------------------------------

    reg  [RHO_W-1:0] found_row, past_row;
    reg              found_same_first, found_same_second, found_same_third;  // the cell of the slot ahead, of the second, the third
    reg              past_same_first;
    reg  [3:0]       past_potential;
    reg  [3:0]       last_left;  // `left` of the slot behind `hit`

    wire [STAMP_W-1:0] remains = found - found_period;
    wire               empty   = |remains[STAMP_W-1:4] || remains[3:0] >= threshold;
    wire [3:0]         past_left = (past_same_first && hit_event) ? leaked(left, past_crosses) : past_potential;

    always @(posedge clk)
        if (advance) begin
            found_row         <= row;
            found_same_first  <= row == found_row;
            found_same_second <= row == past_row;
            found_same_third  <= row == hit_row_reg && hit_event;

            past_row          <= found_row;
            past_same_first   <= found_same_first;
            past_potential    <= (found_same_second && hit_event) ? leaked(left, found_crosses)
                               : found_same_third ? leaked(last_left, last_crosses)
                               : empty ? 4'd0 : remains[3:0];

            hit_row_reg       <= past_row;
            hit_hits          <= past_left + 4'd1;
            last_left         <= left;
        end

    assign fires   = hit_hits == threshold;
    assign hit_row = hit_row_reg;

    wire unused = &{1'b0, COSINES};

endmodule

`default_nettype wire
