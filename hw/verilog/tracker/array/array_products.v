// SPDX-License-Identifier: Apache-2.0
// The arithmetic right shift of ~a_not | ~b_not | c by BY, or 0: one look-up table for each bit.
//
// Combinational. Synthesised separately: otherwise synthesis shares the or between several shifts, which costs a level of logic.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> y.
`default_nettype none

(* keep_hierarchy *)
module array_products #(
    parameter W  = 14,
    parameter BY = 2
) (
    input  wire [W-1:0] a_not,
    input  wire [W-1:0] b_not,
    input  wire [W-1:0] c,
    input  wire         wanted,  // else 0
    output wire [W-1:0] y
);

    wire signed [W-1:0] sum     = ~a_not | ~b_not | c;
    wire        [W-1:0] shifted = sum >>> BY;

    assign y = shifted & {W{wanted}};

endmodule

`default_nettype wire
