// SPDX-License-Identifier: Apache-2.0
// The cells of one angle of hough_lines.v, in block RAM: reads a cell, counts a hit, writes the cell back (docs/lines.md).
//
// A word is the potential that an event has left, 0 to 7 hits, and the event's period. Slots move through the stages row, found,
// past and hit. A cell is written from `hit`, and slots up to three behind may have read it before. They take what the slot ahead
// leaves: the third behind and the second in `found`, the first in `past`. Slots so near are at most one period apart, as a period
// has at least four events.
//
// Latency:    3 clocks from row to hit_row and fires: RAM, potential, forwarding.
// Throughput: 1 event per clock.
// Stall:      nothing moves while advance is low.
// Reset:      none; an event with inhibits high empties a cell.
// RAM:        2^RHO_W words of 12 bits.
// Combinational paths: none; all outputs come from registers.
`default_nettype none

module hough_angle #(
    parameter RHO_W = 9  // bits of a cell's index, 4 to 12
) (
    input  wire             clk,
    input  wire             advance,  // all slots move on

    // the slot in `row`
    input  wire [RHO_W-1:0] row,

    // what all angles share; a period is that of the slot's event, modulo 2^9
    input  wire [8:0]       found_period,
    input  wire [8:0]       hit_period,
    input  wire             hit_event,     // the slot in `hit` is an event
    input  wire             past_leaks,    // a period ended between the slots in `past` and `hit`
    input  wire             found_leaks,   // between the slots in `found` and `hit`
    input  wire             last_leaks,    // between the slot in `found` and the one that has left `hit`
    input  wire             inhibits,      // the cell in `hit` is emptied: an angle fires, or the memory is cleared

    output wire             fires,          // the cell in `hit` has reached the threshold
    output wire [RHO_W-1:0] hit_row
);

    parameter_check #(.OK(RHO_W >= 4 && RHO_W <= 12)) RHO_W_must_be_4_to_12 ();

    `include "hough_table.vh"

    // ---- memory ------------------------------------------------------------------------------------------------------

    (* ram_style = "block", no_rw_check *)
    reg [STAMP_W+2:0] cells [0:(1<<RHO_W)-1];
    reg [STAMP_W+2:0] found;

    reg  [2:0]         hit_potential;
    reg  [RHO_W-1:0]   hit_row_reg;
    wire [2:0]         left = inhibits ? 3'd0 : hit_potential + 3'd1;

    always @(posedge clk) begin
        if (advance && hit_event) cells[hit_row_reg] <= {left, hit_period};
        if (advance) found <= cells[row];
    end

    // ---- potential ---------------------------------------------------------------------------------------------------

    reg  [RHO_W-1:0]   found_row, past_row;
    reg                found_same_first, found_same_second, found_same_third;  // the cell of the first slot ahead, the second ...
    reg                past_same_first;
    reg                past_forwards;   // from the second or third slot ahead, not from the RAM
    reg  [2:0]         past_forwarded;
    reg  [2:0]         past_stored;     // potential in the RAM
    reg  [STAMP_W-1:0] past_age;        // of it, in periods
    reg  [2:0]         last_left;       // by the slot that has left `hit`

    wire               second         = found_same_second && hit_event;
    wire               past_empty     = |past_age[STAMP_W-1:3] || past_age[2:0] > past_stored;
    wire [2:0]         past_potential = past_forwards ? past_forwarded : past_empty ? 3'd0 : past_stored - past_age[2:0];

    function [2:0] leaked;  // a potential after the end of a period, if one has ended
        input [2:0] potential;
        input       ended;
        leaked = potential - {2'd0, ended && potential != 3'd0};
    endfunction

    always @(posedge clk)
        if (advance) begin
            found_row         <= row;
            found_same_first  <= row == found_row;
            found_same_second <= row == past_row;
            found_same_third  <= row == hit_row_reg && hit_event;

            past_row          <= found_row;
            past_same_first   <= found_same_first;
            past_forwards     <= second || found_same_third;
            past_forwarded    <= leaked(second ? left : last_left, second ? found_leaks : last_leaks);
            past_stored       <= found[STAMP_W+2:STAMP_W];
            past_age          <= found_period - found[STAMP_W-1:0];

            hit_row_reg       <= past_row;
            hit_potential     <= (past_same_first && hit_event) ? leaked(left, past_leaks) : past_potential;
            last_left         <= left;
        end

    assign fires   = &hit_potential;
    assign hit_row = hit_row_reg;

    wire unused = &{1'b0, COSINES};

endmodule

`default_nettype wire
