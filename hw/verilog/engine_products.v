// SPDX-License-Identifier: Apache-2.0
// (~a_not | ~b_not | c) & d, bit by bit: one look-up table each.
//
// Combinational. Synthesised on its own: it would rather share the sum between many d, which costs a level of logic.
`default_nettype none

(* keep_hierarchy *)
module engine_products #(
    parameter W = 14
) (
    input  wire [W-1:0] a_not,
    input  wire [W-1:0] b_not,
    input  wire [W-1:0] c,
    input  wire [W-1:0] d,
    output wire [W-1:0] y
);

    assign y = (~a_not | ~b_not | c) & d;

endmodule

`default_nettype wire
