// SPDX-License-Identifier: Apache-2.0
/*
[properties]
divides = "a division by 2^down takes down + 3 clocks: until then `dividing` is high, from the clock after it is asked for on"

[[tasks]]
name = "8 slots"
parameters = { SLOT_W = 3, TIME_W = 48 }
cut = ["t:*block_memory*", "t:*array_sum*"]
k = 1
covers_within = 14
quick = true

[[faults]]
meaning = "it goes on for one bit more"
right = "if (left == 6'd0) divides"
wrong = "if (left == 6'd63) divides"
breaks = ["divides"]
within = 14
*/
// A division begins when none is under way.
reg       f_open;    // it was asked for, and is not over
reg [6:0] f_clocks;  // since then
reg [5:0] f_down;

wire f_over = f_clocks == {1'b0, f_down} + 7'd3;

always @* assume (!(divide && f_open && !f_over));

always @(posedge clk) begin
    f_open   <= divide || (f_open && !f_over);
    f_clocks <= divide ? 7'd1 : f_clocks + 7'd1;
    if (divide) f_down <= down;
    if (rst) f_open <= 1'b0;
end

always @* if (f_past) begin
    p_divides: assert (dividing == (f_open && !f_over));

    i_divides: assert (divides == (f_open && f_clocks < {1'b0, f_down} + 7'd2));
    i_clocks:  assert (!f_open || (f_clocks != 7'd0 && f_clocks <= {1'b0, f_down} + 7'd3));
    i_left:    assert (!divides || {1'b0, left} + f_clocks == {1'b0, f_down} + 7'd1);

    c_divides: cover (f_open && f_over && f_down == 6'd5);
end
