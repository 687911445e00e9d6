// SPDX-License-Identifier: Apache-2.0
// The bitwise or of five words: one level of logic, of five inputs, for each bit.
//
// Combinational. Synthesised separately: otherwise synthesis uses two levels where it estimates enough slack.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> y.
`default_nettype none

(* keep_hierarchy *)
module array_or #(
    parameter W = 15
) (
    input  wire [W-1:0] a, b, c, d, e,
    output wire [W-1:0] y
);

    assign y = a | b | c | d | e;

endmodule

`default_nettype wire
