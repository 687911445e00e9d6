// SPDX-License-Identifier: Apache-2.0
// b or -b, added to a or to nothing.
//
// Combinational. On an ECP5, the look-up tables before the carry chain can make both selections: hw/fpga/ecp5/motion_sum.v.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> y.
`default_nettype none

module motion_sum #(
    parameter W = 25
) (
    input  wire         adds,   // a counts
    input  wire [W-1:0] a,
    input  wire         minus,  // b is subtracted
    input  wire [W-1:0] b,
    output wire [W-1:0] y
);

    wire [W:0] total = {adds ? a : {W{1'b0}}, 1'b1} + {b ^ {W{minus}}, minus};

    assign y = total[W:1];

    wire unused = &{1'b0, total[0]};

endmodule

`default_nettype wire
