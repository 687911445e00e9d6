// SPDX-License-Identifier: Apache-2.0
// A score and a product, or what a score is less than the largest one.
//
// On an ECP5 the look-up tables before the carry chain make both selections: hw/fpga/ecp5/classifier_score.v.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> y.
`default_nettype none

module classifier_score #(
    parameter W = 22
) (
    input  wire         minus,    // `score` is subtracted from `most`, else added to `product`
    input  wire [W-1:0] score,
    input  wire [W-1:0] product,
    input  wire [W-1:0] most,
    output wire [W-1:0] y
);

    wire [W:0] total = {score ^ {W{minus}}, minus} + {minus ? most : product, 1'b1};

    assign y = total[W:1];

    wire unused = &{1'b0, total[0]};

endmodule

`default_nettype wire
