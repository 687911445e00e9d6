// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*cot"]

[properties]
once = "an event that came is in one tracker until it leaves, and in none afterwards"
one = "it leaves as owned by one tracker, or as passed"
number = "it leaves with its place among the events that came"

[[tasks]]
name = "8"
parameters = { N = 8 }
k = 2
covers_within = 14
quick = true

[[tasks]]
name = "1"
parameters = { N = 1 }
k = 2
covers_within = 10

[[faults]]
meaning = "the last tracker passes into nothing what it should pass on"
right = "m_pass_valid  = link_valid[N] && last_event"
wrong = "m_pass_valid  = link_valid[N] && !last_event"
breaks = ["once"]
within = 12

[[faults]]
meaning = "an event leaves that is not offered"
right = "m_pass_valid  = link_valid[N] && last_event"
wrong = "m_pass_valid  = last_event"
breaks = ["one", "once"]
within = 12
task = "1"

[[faults]]
meaning = "an event that was taken out before is not counted"
right = "first_ready && (first[EVENT_W-1] || first_skip)"
wrong = "first_ready && first[EVENT_W-1]"
breaks = ["number"]
within = 12
task = "1"
*/
// Trackers do what cot.vh proves of each: an event that one accepts leaves it once, owned or passed, before the next one is accepted,
// with its number. One event is marked where it comes in; f_at says which tracker has it.
(* anyseq *) wire f_choose;

reg          f_marked, f_gone;
reg [N-1:0]  f_has, f_at;  // an event, the marked event
reg [N*SEQ_W-1:0] f_number;
reg [SEQ_W-1:0]   f_seq;
reg [SEQ_W-1:0]   f_next;
integer f_i;

wire f_first_event = first[EVENT_W-1];
wire f_mark = first_valid && first_ready && f_first_event && f_choose && !f_marked;

always @* for (f_i = 0; f_i < N; f_i = f_i + 1) begin
    assume (!own_valid[f_i] || (f_has[f_i] && own[f_i*OWN_W +: SEQ_W] == f_number[f_i*SEQ_W +: SEQ_W]));
    assume (!(link_valid[f_i+1] && link[(f_i+1)*TOKEN_W + SEQ_W + 1 + Y_W + X_W])
            || (f_has[f_i] && !own_valid[f_i] && link[(f_i+1)*TOKEN_W +: SEQ_W] == f_number[f_i*SEQ_W +: SEQ_W]));
    assume (!(link_ready[f_i] && link_valid[f_i] && link[f_i*TOKEN_W + SEQ_W + 1 + Y_W + X_W]) || !f_has[f_i]);
end

wire [N-1:0] f_owns   = own_valid & own_ready & f_at;
wire         f_passes = m_pass_valid && m_pass_ready && f_at[N-1];

always @(posedge clk) begin
    for (f_i = 0; f_i < N; f_i = f_i + 1) begin
        if ((own_valid[f_i] && own_ready[f_i])
            || (link_valid[f_i+1] && link_ready[f_i+1] && link[(f_i+1)*TOKEN_W + SEQ_W + 1 + Y_W + X_W]))
            {f_has[f_i], f_at[f_i]} <= 2'b00;
        if (link_valid[f_i] && link_ready[f_i] && link[f_i*TOKEN_W + SEQ_W + 1 + Y_W + X_W]) begin
            f_has[f_i] <= 1'b1;
            f_number[f_i*SEQ_W +: SEQ_W] <= link[f_i*TOKEN_W +: SEQ_W];
            f_at[f_i]  <= (f_i == 0) ? f_mark : f_at[(f_i == 0) ? 0 : f_i-1];
        end
    end
    if (f_mark) {f_marked, f_seq} <= {1'b1, f_next};
    if (first_valid && first_ready && (f_first_event || first_skip)) f_next <= f_next + 1'b1;
    if (|f_owns || f_passes) f_gone <= 1'b1;
    if (rst) begin
        {f_marked, f_gone} <= 2'b00;
        {f_has, f_at} <= {(2 * N) {1'b0}};
        f_next <= {SEQ_W{1'b0}};
    end
end

wire [N-1:0] f_kept;  // a tracker that has the marked event has its number, also at its output
generate
    for (i = 0; i < N; i = i + 1) begin : f_slots
        assign f_kept[i] = !f_at[i] || (f_number[i*SEQ_W +: SEQ_W] == f_seq && (!f_owns[i] || own[i*OWN_W +: SEQ_W] == f_seq));
    end
endgenerate

always @* if (f_past) begin
    p_once:   assert ((f_at & (f_at - 1'b1)) == {N{1'b0}} && f_marked == (f_gone || |f_at) && !(f_gone && |f_at));
    p_one:    assert ((f_owns & (f_owns - 1'b1)) == {N{1'b0}} && !(|f_owns && f_passes));
    p_number: assert (&f_kept && (!f_passes || m_pass_seq == f_seq));
    i_has:    assert ((f_at & ~f_has) == {N{1'b0}});
    i_next:   assert (f_next == seq);
    c_once:   cover (f_gone);
    c_one:    cover (f_owns[N-1]);
    c_number: cover (f_passes && f_seq == 2);
end
