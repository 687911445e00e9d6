// SPDX-License-Identifier: Apache-2.0
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
