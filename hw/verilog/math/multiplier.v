// SPDX-License-Identifier: Apache-2.0
// A product of two numbers with sign, with registers before and behind it.
//
// Multipliers are far from other cells, so their wires have a clock of their own on either side, in registers that those of most devices
// have inside. Yosys does not use them: on an ECP5 read hw/fpga/ecp5/multiplier.v after this file.
//
// Latency:    2 clocks.
// Throughput: a product per clock.
// Stall:      none.
// Reset:      none.
// Combinational paths: none.
`default_nettype none

module multiplier #(
    parameter A_W = 18,  // bits of a, at least 1
    parameter B_W = 18   // bits of b, at least 1
) (
    input  wire                      clk,
    input  wire signed [A_W-1:0]     a,
    input  wire signed [B_W-1:0]     b,
    output wire signed [A_W+B_W-1:0] p
);

    parameter_check #(.OK(A_W >= 1)) A_W_must_be_at_least_1 ();
    parameter_check #(.OK(B_W >= 1)) B_W_must_be_at_least_1 ();

    reg signed [A_W-1:0]     a_1;
    reg signed [B_W-1:0]     b_1;
    reg signed [A_W+B_W-1:0] p_2;

    assign p = p_2;

    always @(posedge clk) begin
        a_1 <= a;
        b_1 <= b;
        p_2 <= a_1 * b_1;
    end

endmodule

`default_nettype wire
