// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*motion_bins*"]

[properties]
ends = "a look ends 47 clocks after it is asked for, not before, if none is asked for meanwhile or just after reset"
once = "done comes only after a look that was asked for"

[[tasks]]
name = "8 slots"
parameters = { PX_W = 13, SLOT_W = 3 }
k = 1
covers_within = 52
quick = true

[[tasks]]
name = "64 slots"
parameters = { PX_W = 20, SLOT_W = 6 }
k = 1
covers_within = 52
only = []

[[faults]]
meaning = "the width of the gap is waited for for one clock more"
right = "if (at == 5'd4) state <= JUDGE;"
wrong = "if (at == 5'd5) state <= JUDGE;"
breaks = ["ends"]
within = 54

[[faults]]
meaning = "what was found is judged twice"
right = "state     <= WAIT;\n            end\n            default"
wrong = "state     <= done ? WAIT : JUDGE;\n            end\n            default"
breaks = ["once"]
within = 54
*/
// For each state, how many clocks are left until done.
reg       f_open;    // a look was asked for and is not done
reg [5:0] f_clocks;  // since then

reg       f_was_rst;

always @* assume (!(look && (f_open || f_was_rst)));

always @(posedge clk) begin
    f_was_rst <= rst;
    f_open    <= look || (f_open && !done);
    f_clocks  <= look ? 6'd1 : f_clocks + 6'd1;
    if (rst) f_open <= 1'b0;
end

reg [5:0] f_left;
always @* begin
    f_left = 6'd0;
    case (state)
        SUM:     f_left = last ? 6'd28 : 6'd46 - {1'b0, at};
        LEAST:   f_left = 6'd27;
        RUNS:    f_left = last ? 6'd8 : 6'd26 - {1'b0, at};
        PLACE:   f_left = 6'd7;
        WIDE:    f_left = 6'd6 - {1'b0, at};
        JUDGE:   f_left = 6'd1;
        default: f_left = 6'd0;
    endcase
end

always @* if (f_past) begin
    p_ends:  assert (!f_open || (done ? f_clocks == 6'd47 : f_clocks < 6'd47));
    p_once:  assert (!done || f_open);
    i_open:  assert (f_open == (state != WAIT || done) && state <= JUDGE && !(state != WAIT && done));
    i_last:  assert (!(state == SUM || state == RUNS) || (last ? at == 5'd18 : at <= 5'd17));
    i_wide:  assert ((state != WIDE || (at <= 5'd4 && !last)) && (state != PLACE || at == 5'd0) && (state != JUDGE || at == 5'd5) && (state != LEAST || at == 5'd0)
                     && (state != WAIT || f_was_rst || at <= 5'd6));
    i_left:  assert (!f_open || f_clocks + f_left == 6'd47);
    c_ends:  cover (done && f_open && found);
    c_once:  cover (done && f_open && !found);
end
