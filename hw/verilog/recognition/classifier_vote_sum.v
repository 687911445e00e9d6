// SPDX-License-Identifier: Apache-2.0
// A sum of a or or_a, of which one is 0, of b, and of a carry.
//
// On an ECP5 the look-up tables before the carry chain unite the two: hw/fpga/ecp5/classifier_vote_sum.v.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> y.
`default_nettype none

module classifier_vote_sum #(
    parameter W = 15
) (
    input  wire [W-1:0] a,
    input  wire [W-1:0] or_a,
    input  wire [W-1:0] b,
    input  wire         carry,
    output wire [W-1:0] y
);

    wire [W:0] total = {a ^ or_a, carry} + {b, 1'b1};

    assign y = total[W:1];

    wire unused = &{1'b0, total[0]};

endmodule

`default_nettype wire
