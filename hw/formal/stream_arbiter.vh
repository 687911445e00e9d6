// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "a word of a stream leaves after those of its stream before it, unchanged"
count = "each word that came leaves once; at most two of a stream are inside"
owner = "each word that leaves is of one stream"
fair = "while a word of a stream waits, at most N - 1 words of others go before it"
progress = "the output is valid in the clock after one in which a word waits"
stable = "a word that is not taken stays"

[[tasks]]
name = "8"
parameters = { N = 8, W = 32 }
k = 2
covers_within = 14
quick = true

[[tasks]]
name = "3"
parameters = { N = 3, W = 2 }
k = 2
covers_within = 10
quick = true

[[tasks]]
name = "1"
parameters = { N = 1, W = 1 }
k = 2
covers_within = 8

[[tasks]]
name = "records"
parameters = { N = 8, W = 194 }
k = 2
covers_within = 14

[[faults]]
meaning = "the register in front is overwritten while it waits"
right = "if (s_valid[stream] && s_ready_reg[stream]) waiting"
wrong = "if (s_valid[stream]) waiting"
breaks = ["order"]
within = 8

[[faults]]
meaning = "a stream is ready although its turn has not come"
right = "(turn_reg & {N{output_free}})"
wrong = "turn_reg"
breaks = ["count"]
within = 8

[[faults]]
meaning = "two streams have their turn at once"
right = "(j < i) ? above_reg[j] || !above_reg[i]"
wrong = "(j < i) ? above_reg[j] && !above_reg[i]"
breaks = ["owner"]
within = 8

[[faults]]
meaning = "the lowest stream always goes first"
task = "3"
right = "above_next[i-1] || turn_next[i-1]"
wrong = "1'b0"
breaks = ["fair"]
within = 14

[[faults]]
meaning = "the last stream is not among those above"
task = "3"
right = "for (i = 1; i < N; i = i + 1) above_next[i]"
wrong = "above_next = {N{1'b0}}; for (i = 1; i < N - 1; i = i + 1) above_next[i]"
breaks = ["fair"]
within = 14

[[faults]]
meaning = "a word waits a clock before it may have its turn"
right = "waiting = (s_valid | ~s_ready_reg)"
wrong = "waiting = (~s_ready_reg)"
breaks = ["progress"]
within = 10

[[faults]]
meaning = "a stalled word is replaced"
right = "output_free = m_ready || !m_valid_reg"
wrong = "output_free = 1'b1"
breaks = ["stable"]
within = 8
*/
// f_stream is any one stream, f_word any one of its words, and f_others counts the words of other streams that leave the registers in
// front while a word of f_stream waits there. f_owner says whose the word at the output is: with it, what leaves is an interleaving of
// what came in.
localparam F_W = $clog2(N + 1) + 1;

(* anyconst *) wire [W-1:0] f_word;
(* anyconst *) wire [F_W-1:0] f_stream;
(* anyseq *)   wire         f_choose;
always @* assume (f_stream < N);

reg [N-1:0]   f_owner;
reg           f_waits, f_was_stalled, f_was_waiting;
reg [1:0]     f_ahead, f_inside;
reg [W-1:0]   f_was;
reg [F_W-1:0] f_others;

wire f_held   = !s_ready_reg[f_stream];  // a word of f_stream is in its register
wire f_mine   = m_valid_reg && f_owner[f_stream];
wire f_in     = s_valid[f_stream] && s_ready[f_stream];
wire f_out    = f_mine && m_ready;
wire [W-1:0] f_data   = s_data[f_stream*W +: W];
wire [W-1:0] f_stored = waiting_data_reg[f_stream*W +: W];
wire f_mark   = f_in && f_choose && !f_waits && f_data == f_word;
wire f_moves  = output_free && turn_reg != {N{1'b0}};

always @(posedge clk) begin
    f_was_stalled <= m_valid && !m_ready;
    f_was_waiting <= !(&s_ready_reg);
    f_was    <= m_data;
    f_inside <= f_inside + {1'b0, f_in} - {1'b0, f_out};
    if (output_free) f_owner <= turn_reg;
    if (f_mark) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside - {1'b0, f_out};
    end else if (f_waits && f_out) begin
        f_ahead <= f_ahead - 2'd1;
        if (f_ahead == 2'd0) f_waits <= 1'b0;
    end
    if (!f_held) f_others <= {F_W{1'b0}};
    else if (f_moves && !turn_reg[f_stream]) f_others <= f_others + 1'b1;
    if (rst) begin
        {f_waits, f_was_stalled, f_was_waiting} <= 3'b000;
        f_inside <= 2'd0;
        f_others <= {F_W{1'b0}};
    end
end

// The stream that had the last turn, N - 1 if none had, and how many words of others may still go before the one of f_stream.
reg [F_W-1:0] f_last, f_before;
always @* begin : f_count
    integer i;
    f_last = N - 1;
    for (i = 0; i < N; i = i + 1) f_last = f_last - {{(F_W - 1) {1'b0}}, above_reg[i]};
    f_before = (f_stream > f_last) ? f_stream - f_last - 1'b1 : f_stream + N[F_W-1:0] - f_last - 1'b1;
    if (turn_reg != {N{1'b0}}) f_before = turn_reg[f_stream] ? {F_W{1'b0}} : f_before + 1'b1;
end

always @* if (f_past) begin
    p_order:    assert (!(f_waits && f_ahead == 2'd0 && f_mine) || m_data == f_word);
    p_count:    assert (f_inside == {1'b0, f_held} + {1'b0, f_mine});
    p_owner:    assert (!m_valid || (f_owner != {N{1'b0}} && (f_owner & (f_owner - 1'b1)) == {N{1'b0}}));
    p_fair:     assert (!f_held || f_others < N);
    p_progress: assert (!f_was_waiting || m_valid);
    p_stable:   assert (!f_was_stalled || (m_valid && m_data == f_was));
    i_place:    assert (!f_waits || f_ahead < f_inside);
    i_stored:   assert (!(f_waits && f_ahead == {1'b0, f_mine}) || f_stored == f_word);
    i_turn:     assert ((turn_reg & (turn_reg - 1'b1)) == {N{1'b0}} && (turn_reg & s_ready_reg) == {N{1'b0}});
    i_last:     assert (turn_reg == {N{1'b0}} || turn_reg == ({{(N - 1) {1'b0}}, 1'b1} << f_last));
    i_above:    assert (above_reg == ({N{1'b1}} << f_last << 1));
    i_busy:     assert (&s_ready_reg || turn_reg != {N{1'b0}});
    i_before:   assert (!f_held || f_others + f_before < N);
    c_order:    cover (f_waits && f_ahead == 2'd1);
    c_count:    cover (f_inside == 2'd2);
    c_owner:    cover (m_valid && f_owner[N-1] && f_was_stalled);
    c_fair:     cover (f_held && f_others == N - 1);
    c_progress: cover (f_was_waiting);
    c_stable:   cover (f_was_stalled && m_ready);
end
