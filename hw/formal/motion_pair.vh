// SPDX-License-Identifier: Apache-2.0
/*
[properties]
ends = "a comparison is done 22 clocks after it is asked for, not before, if none is asked for meanwhile"
once = "done comes only after a comparison that was asked for"

[[tasks]]
name = "8 slots"
parameters = { PX_W = 13, SUP_W = 16 }
k = 1
covers_within = 26
quick = true

[[tasks]]
name = "64 slots"
parameters = { PX_W = 20, SUP_W = 32 }
k = 1
covers_within = 1
only = []

[[faults]]
meaning = "the second axis is compared a clock late"
right = "step[3] || (judges && !along)"
wrong = "step[4] || (judges && !along)"
breaks = ["ends"]
within = 26

[[faults]]
meaning = "both axes end"
right = "last <= {last[1:0], judges && along};"
wrong = "last <= {last[1:0], judges};"
breaks = ["once"]
within = 40
*/
// For each state, how many clocks are left until done.
reg       f_open;  // a comparison was asked for and is not done
reg [5:0] f_clocks;

always @* assume (!(start && f_open && !done));
always @* assume (join_speed <= 4'd8 && join_reach <= 4'd8);  // the limits of both registers

always @(posedge clk) begin
    f_open   <= start || (f_open && !done);
    f_clocks <= start ? 6'd1 : f_clocks + 6'd1;
    if (rst) f_open <= 1'b0;
end

// The stage that something is in: a bit for each clock since then, in turn.
wire [4:0] f_steps = f_clocks >= 6'd1 && f_clocks <= 6'd5 ? 5'd1 << (f_clocks - 6'd1) : 5'd0;
wire [5:0] f_parts = f_clocks >= 6'd5 && f_clocks <= 6'd10 ? 6'd1 << (f_clocks - 6'd5)
                   : f_clocks >= 6'd12 && f_clocks <= 6'd17 ? 6'd1 << (f_clocks - 6'd12) : 6'd0;
wire [2:0] f_lasts = f_clocks >= 6'd19 && f_clocks <= 6'd21 ? 3'd1 << (f_clocks - 6'd19) : 3'd0;

always @* if (f_past) begin
    p_ends:  assert (!f_open || (done ? f_clocks == 6'd22 : f_clocks < 6'd22));
    p_once:  assert (!done || f_open);

    i_idle:  assert (f_open || (step == 5'd0 && part == 6'd0 && !waits && last == 3'd0));
    i_open:  assert (!f_open || (step == f_steps && part == f_parts && last == f_lasts && waits == (f_clocks == 6'd11 || f_clocks == 6'd18)
                     && done == (f_clocks == 6'd22) && f_clocks != 6'd0 && along == (f_clocks >= 6'd12)));
    i_fast:  assert (!f_open || f_clocks < 6'd6 || f_clocks > 6'd18 || {2'b00, fast_down} <= 6'd18 - f_clocks);
    i_reach: assert (!f_open || f_clocks < 6'd10 || f_clocks > 6'd18 || {2'b00, reach_down} <= 6'd18 - f_clocks);

    c_ends:  cover (done && f_open && alike);
    c_once:  cover (done && f_open && !alike);
end
