// SPDX-License-Identifier: Apache-2.0
/*
[properties]
time = "a mark that is lower than the last one by more than half of the range adds a turn, any other adds none; all turns are counted"
differs = "differs says whether the mark on offer is a new one"
holds = "without a mark the time stays"

[[tasks]]
name = "evt2"
parameters = { MARK_W = 28, HIGH_W = 42 }
k = 2
covers_within = 10
quick = true

[[tasks]]
name = "evt3"
parameters = { MARK_W = 12, HIGH_W = 36 }
k = 2
covers_within = 10

[[tasks]]
name = "2"
parameters = { MARK_W = 2, HIGH_W = 3 }
k = 2
covers_within = 10

[[faults]]
meaning = "half of the range already adds a turn"
right = "last[TOP-1:0] > mark[TOP-1:0]"
wrong = "last[TOP-1:0] >= mark[TOP-1:0]"
breaks = ["time"]
within = 8

[[faults]]
meaning = "a second turn is lost"
right = "if (wrapped) turn <= turn_next;"
wrong = "if (wrapped && !mark[TOP]) turn <= turn_next;"
breaks = ["time"]
within = 10

[[faults]]
meaning = "the first mark after reset is no new one if it is 0"
right = "differs = !known || mark != last"
wrong = "differs = mark != last"
breaks = ["differs"]
within = 6

[[faults]]
meaning = "a turn is counted without a mark"
right = "turn_next <= turn + 1'b1;"
wrong = "turn_next <= turn_next + 1'b1;"
breaks = ["holds"]
within = 10
*/
// The whole time as the sum of what each mark adds: a mark that is lower by more than half of its range adds a turn.
reg [HIGH_W-1:0] f_time;
reg              f_known, f_was_set, f_was_known;
reg [HIGH_W-1:0] f_was;
wire [MARK_W-1:0] f_low = f_time[MARK_W-1:0];
wire f_turns = f_known && f_low > mark && f_low - mark > {1'b1, {(MARK_W - 1) {1'b0}}};
wire [HIGH_W-MARK_W-1:0] f_turn = f_time[HIGH_W-1:MARK_W] + {{(HIGH_W - MARK_W - 1) {1'b0}}, f_turns};

always @(posedge clk) begin
    f_was_set <= set;
    f_was     <= high;
    if (set) begin
        f_known <= 1'b1;
        f_time  <= {f_turn, mark};
    end
    if (rst) begin
        f_known   <= 1'b0;
        f_was_set <= 1'b1;
        f_time    <= {HIGH_W{1'b0}};
    end
end

always @* if (f_past) begin
    p_time:    assert (high == f_time && known == f_known);
    p_differs: assert (differs == (!f_known || mark != f_low));
    p_holds:   assert (f_was_set || high == f_was);
    i_turn:    assert (!wrapped || turn_next == turn + 1'b1);
    i_half:    assert (!wrapped || !last[TOP]);
    i_known:   assert (known || (last == {MARK_W{1'b0}} && !wrapped));
    c_time:    cover (wrapped && f_turns == 1'b0 && turn == 1);
    c_differs: cover (f_known && !differs);
    c_holds:   cover (!f_was_set && wrapped);
end
