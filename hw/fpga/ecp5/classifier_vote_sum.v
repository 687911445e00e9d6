// SPDX-License-Identifier: Apache-2.0
// hw/verilog/recognition/classifier_vote_sum.v in the carry chain of an ECP5: the look-up table before each carry unites the first two operands.
`default_nettype none

(* keep_hierarchy *)
module classifier_vote_sum #(
    parameter W = 15
) (
    input  wire [W-1:0] a,
    input  wire [W-1:0] or_a,
    input  wire [W-1:0] b,
    input  wire         carry,
    output wire [W-1:0] y
);

    localparam PAIRS = W / 2 + 1;  // of bits, the one below included

    // (A ^ B) ^ (C & D). With C and D zero it is A ^ B, which a cell takes for its carry where it does not pass one on.
    localparam [15:0] CHOOSE = 16'h9666;

    // The carry of the bit below is `carry`.
    wire [2*PAIRS-1:0] all_a = {{(2 * PAIRS - W - 1) {1'b0}}, a, carry};
    wire [2*PAIRS-1:0] all_b = {{(2 * PAIRS - W - 1) {1'b0}}, or_a, 1'b0};
    wire [2*PAIRS-1:0] all_c = {{(2 * PAIRS - W - 1) {1'b0}}, b, 1'b1};
    wire [2*PAIRS-1:0] all_d = {(2 * PAIRS) {1'b1}};
    wire [2*PAIRS-1:0] total;
    wire [PAIRS:0]     chain;

    assign chain[0] = 1'b0;
    assign y        = total[W:1];

    genvar i;
    generate
        for (i = 0; i < PAIRS; i = i + 1) begin : g_pair
            CCU2C #(
                .INIT0    (CHOOSE),
                .INIT1    (CHOOSE),
                .INJECT1_0("NO"),
                .INJECT1_1("NO")
            ) u_carry (
                .CIN (chain[i]),
                .A0  (all_a[2*i]),
                .B0  (all_b[2*i]),
                .C0  (all_c[2*i]),
                .D0  (all_d[2*i]),
                .A1  (all_a[2*i+1]),
                .B1  (all_b[2*i+1]),
                .C1  (all_c[2*i+1]),
                .D1  (all_d[2*i+1]),
                .S0  (total[2*i]),
                .S1  (total[2*i+1]),
                .COUT(chain[i+1])
            );
        end
    endgenerate

endmodule

`default_nettype wire
