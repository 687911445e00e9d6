// SPDX-License-Identifier: Apache-2.0
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
