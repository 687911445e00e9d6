// SPDX-License-Identifier: Apache-2.0
/*
[properties]
ends = "what a slot meets is known 10 + n clocks after the question, not before, n other slots being not free, if nothing is asked meanwhile"
once = "done comes only after a question"

[[tasks]]
name = "8 slots"
parameters = { N = 8, SLOT_W = 3, PX_W = 13 }
k = 1
covers_within = 22
quick = true

[[tasks]]
name = "64 slots"
parameters = { N = 64, SLOT_W = 6, PX_W = 20 }
k = 1
covers_within = 1
only = []

[[faults]]
meaning = "the end comes a clock early"
right = "{done, ends} <= {ends, busy && !any_ahead};"
wrong = "{done, ends} <= {ends[5:0], busy && !any_ahead, 1'b0};"
breaks = ["ends"]
within = 24

[[faults]]
meaning = "an end comes whenever nothing is asked"
right = "{done, ends} <= {ends, busy && !any_ahead};"
wrong = "{done, ends} <= {ends, !any_ahead};"
breaks = ["once"]
within = 24
*/
// For each state, how many clocks are left until done.
reg       f_open;            // a question that is not answered
reg [7:0] f_clocks, f_asks;  // since then; slots that were not free, but for its own
reg [N-1:0] f_others;

function [7:0] f_ones;  // slots of a mask
    input [N-1:0] mask;
    integer i;
    begin
        f_ones = 8'd0;
        for (i = 0; i < N; i = i + 1) f_ones = f_ones + {7'd0, mask[i]};
    end
endfunction

always @* assume (!(start && f_open && !done));

always @* f_others = (visible | candidate | left) & ~(one << slot);

always @(posedge clk) begin
    f_open   <= start || (f_open && !done);
    f_clocks <= start ? 8'd1 : f_clocks + 8'd1;
    if (start) f_asks <= f_ones(f_others);
    if (rst) f_open <= 1'b0;
end

wire [7:0] f_tail = done ? 8'd0 : ends[6] ? 8'd1 : ends[5] ? 8'd2 : ends[4] ? 8'd3 : ends[3] ? 8'd4 : ends[2] ? 8'd5 : ends[1] ? 8'd6 : 8'd7;

always @* if (f_past) begin
    p_ends: assert (!f_open || (done ? f_clocks == 8'd10 + f_asks : f_clocks < 8'd10 + f_asks));
    p_once: assert (!done || f_open);

    i_one:  assert (({done, ends} & ({done, ends} - 8'd1)) == 8'd0 && f_open == (starts || busy || {done, ends} != 8'd0)
                    && {1'b0, starts} + {1'b0, busy} + {1'b0, {done, ends} != 8'd0} <= 2'd1);
    i_asks: assert (!f_open || f_asks < N);
    i_left: assert (!f_open || f_clocks + (starts ? 8'd9 + f_ones(ahead) : busy ? 8'd8 + f_ones(ahead) : f_tail) == 8'd10 + f_asks);

    c_ends: cover (done && f_asks == 8'd7 && meets);
    c_once: cover (done && f_open && touches);
end
