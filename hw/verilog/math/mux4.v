// SPDX-License-Identifier: Apache-2.0
// One of four words.
//
// On an ECP5 two look-up tables a bit and the multiplexer behind them: hw/fpga/ecp5/mux4.v. Yosys makes three or four of it.
//
// Latency:    none, combinational.
// Throughput: a word per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> y.
`default_nettype none

module mux4 #(
    parameter W = 8  // bits of a word, at least 1
) (
    input  wire [1:0]     select,
    input  wire [4*W-1:0] words,  // the lowest is word 0
    output wire [W-1:0]   y
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();

    assign y = words[W*select +: W];

endmodule

`default_nettype wire
