// SPDX-License-Identifier: Apache-2.0
// The arithmetic right shift of ~a_not | ~b_not | c by BY, or 0: one look-up table for each bit.
//
// Combinational. Synthesised on its own: it would rather share the sum between several shifts, which costs a level of logic.
`default_nettype none

(* keep_hierarchy *)
module engine_products #(
    parameter W  = 14,
    parameter BY = 2
) (
    input  wire [W-1:0] a_not,
    input  wire [W-1:0] b_not,
    input  wire [W-1:0] c,
    input  wire         wanted,  // else 0
    output reg  [W-1:0] y
);

    wire signed [W-1:0] a = ~a_not;
    wire signed [W-1:0] b = ~b_not;
    wire signed [W-1:0] d = c;

    always @* begin
        y = {W{1'b0}};
        if (wanted) y = (a >>> BY) | (b >>> BY) | (d >>> BY);
    end

endmodule

`default_nettype wire
