// SPDX-License-Identifier: Apache-2.0
// Five words, or: one level of logic, of five inputs, for each bit.
//
// Combinational. Synthesised on its own: it would rather make two levels where it thinks that there is time.
`default_nettype none

(* keep_hierarchy *)
module engine_or #(
    parameter W = 15
) (
    input  wire [W-1:0] a, b, c, d, e,
    output wire [W-1:0] y
);

    assign y = a | b | c | d | e;

endmodule

`default_nettype wire
