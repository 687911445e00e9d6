// SPDX-License-Identifier: Apache-2.0
/*
[properties]
next = "q is d of the clock before; in reset 0, or the complement of d"
zero = "q powers up at 0"

[[tasks]]
name = "zero"
parameters = { RESET_TO_COMPLEMENT = 0 }
k = 2
covers_within = 4
quick = true

[[tasks]]
name = "complement"
parameters = { RESET_TO_COMPLEMENT = 1 }
k = 2
covers_within = 4

[[faults]]
meaning = "no reset"
right = "if (rst) q_reg"
wrong = "if (1'b0) q_reg"
breaks = ["next"]
within = 4

[[faults]]
meaning = "it powers up at 1"
right = "initial q_reg = 1'b0"
wrong = "initial q_reg = 1'b1"
breaks = ["zero"]
within = 4
*/
reg f_next, f_began;
initial f_began = 1'b0;
always @(posedge clk) begin
    f_began <= 1'b1;
    f_next <= rst ? RESET_TO_COMPLEMENT != 0 && !d : d;
end
always @* begin
    p_next: assert (!f_began || q == f_next);
    p_zero: assert (f_began || !q);
    c_next: cover (f_past && q && rst);
    c_zero: cover (!f_began);
end
