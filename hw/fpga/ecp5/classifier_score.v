// SPDX-License-Identifier: Apache-2.0
// hw/verilog/recognition/classifier_score.v in the carry chain of an ECP5: the look-up table before each carry selects both operands.
`default_nettype none

(* keep_hierarchy *)
module classifier_score #(
    parameter W = 22
) (
    input  wire         minus,
    input  wire [W-1:0] score,
    input  wire [W-1:0] product,
    input  wire [W-1:0] most,
    output wire [W-1:0] y
);

    localparam PAIRS = W / 2 + 1;  // of bits, the one below included

    // (A ^ B) ^ (B ? C : D). With C and D zero it is A ^ B, which a cell takes for its carry where it does not pass one on.
    localparam [15:0] CHOOSE = 16'h95A6;

    // The carry of the bit below is `minus`.
    wire [2*PAIRS-1:0] all_a = {{(2 * PAIRS - W - 1) {1'b0}}, score, minus};
    wire [2*PAIRS-1:0] all_b = {{(2 * PAIRS - 1) {minus}}, 1'b0};
    wire [2*PAIRS-1:0] all_c = {{(2 * PAIRS - W - 1) {1'b0}}, most, 1'b1};
    wire [2*PAIRS-1:0] all_d = {{(2 * PAIRS - W - 1) {1'b0}}, product, 1'b1};
    wire [2*PAIRS-1:0] total;
    wire [PAIRS:0]     carry;

    assign carry[0] = 1'b0;
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
                .CIN (carry[i]),
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
                .COUT(carry[i+1])
            );
        end
    endgenerate

endmodule

`default_nettype wire
