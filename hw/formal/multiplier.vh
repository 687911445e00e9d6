// SPDX-License-Identifier: Apache-2.0
/*
[properties]
product = "p is the product, with sign, of a and b two clocks before"

[[tasks]]
name = "18"
parameters = { A_W = 18, B_W = 18 }
k = 2
covers_within = 4
quick = true

[[tasks]]
name = "mixed"
parameters = { A_W = 25, B_W = 3 }
k = 2
covers_within = 4

[[faults]]
meaning = "one factor has no sign"
right = "p_2 <= a_1 * b_1"
wrong = "p_2 <= a_1 * $signed({1'b0, b_1})"
breaks = ["product"]
within = 4

[[faults]]
meaning = "a clock is missing"
right = "p_2 <= a_1 * b_1"
wrong = "p_2 <= a * b"
breaks = ["product"]
within = 4
*/
reg signed [A_W-1:0] f_a_1, f_a_2;
reg signed [B_W-1:0] f_b_1, f_b_2;
reg [1:0] f_clocks;
initial f_clocks = 2'd0;
always @(posedge clk) begin
    {f_a_2, f_a_1} <= {f_a_1, a};
    {f_b_2, f_b_1} <= {f_b_1, b};
    f_clocks <= (f_clocks == 2'd2) ? 2'd2 : f_clocks + 2'd1;
end
wire signed [A_W+B_W-1:0] f_product = f_a_2 * f_b_2;

always @* begin
    p_product: assert (f_clocks != 2'd2 || p == f_product);
    i_first:   assert (f_clocks == 2'd0 || (a_1 == f_a_1 && b_1 == f_b_1));
    c_product: cover (f_clocks == 2'd2 && f_a_2 == -2 && f_b_2 == -2);
end
