// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "a word that was accepted leaves after those before it, unchanged"
count = "m_valid is high exactly while more words went in than out, and at most two are held"
ready = "s_ready is high while less than two words are held, except in the first clock after reset"
stable = "a word that is not taken stays"

[[tasks]]
name = "wide"
parameters = { W = 71 }
k = 2
covers_within = 6
quick = true

[[tasks]]
name = "bit"
parameters = { W = 1 }
k = 2
covers_within = 6

[[faults]]
meaning = "the second word overtakes the first"
right = "m_data_reg <= skid_valid_reg ? skid_data_reg : s_data"
wrong = "m_data_reg <= s_data"
breaks = ["order"]
within = 8

[[faults]]
meaning = "the second register is overwritten while it waits"
right = "if (s_ready_reg) skid_data_reg"
wrong = "skid_data_reg"
breaks = ["order"]
within = 8

[[faults]]
meaning = "a word that comes during a stall is lost"
right = "(skid_valid_reg || accept);"
wrong = "skid_valid_reg;"
breaks = ["count"]
within = 8

[[faults]]
meaning = "a word that waits for the output closes the input"
right = "s_ready_reg <= !skid_valid_next"
wrong = "s_ready_reg <= output_free && !skid_valid_next"
breaks = ["ready"]
within = 8

[[faults]]
meaning = "a stalled word is replaced"
right = "output_free = m_ready || !m_valid_reg"
wrong = "output_free = 1'b1"
breaks = ["stable"]
within = 8
*/
// A word that is accepted is marked, any one of them; f_ahead counts the words before it, and the marked one must leave after them.
(* anyconst *) wire [W-1:0] f_word;
(* anyseq *)   wire         f_choose;

reg       f_waits, f_was_stalled, f_began;
reg [1:0] f_ahead;
reg [W-1:0] f_was;
wire [1:0] f_held = {1'b0, m_valid_reg} + {1'b0, skid_valid_reg};
wire f_in   = s_valid && s_ready;
wire f_out  = m_valid && m_ready;
wire f_mark = f_in && f_choose && !f_waits && s_data == f_word;

always @(posedge clk) begin
    f_was_stalled <= m_valid && !m_ready;
    f_was <= m_data;
    if (f_mark) begin
        f_waits <= 1'b1;
        f_ahead <= f_held - {1'b0, f_out};
    end else if (f_waits && f_out) begin
        f_ahead <= f_ahead - 2'd1;
        if (f_ahead == 2'd0) f_waits <= 1'b0;
    end
    f_began <= rst;
    if (rst) {f_waits, f_was_stalled} <= 2'b00;
end

// The count of words in and out, apart from the registers of the buffer.
reg [1:0] f_inside;
always @(posedge clk) f_inside <= rst ? 2'd0 : f_inside + {1'b0, f_in} - {1'b0, f_out};

always @* if (f_past) begin
    p_order:  assert (!(f_waits && f_ahead == 2'd0) || (m_valid && m_data == f_word));
    p_count:  assert (f_inside == f_held && m_valid == (f_inside != 2'd0));
    p_stable: assert (!f_was_stalled || (m_valid && m_data == f_was));
    p_ready:  assert (s_ready == (f_inside != 2'd2 && !f_began));
    i_place:  assert (!f_waits || f_ahead < f_held);
    i_second: assert (!(f_waits && f_ahead == 2'd1) || skid_data_reg == f_word);
    i_ready:  assert (!(s_ready_reg && skid_valid_reg) && !(skid_valid_reg && !m_valid_reg));
    c_order:  cover (f_waits && f_ahead == 2'd1);
    c_count:  cover (f_inside == 2'd2);
    c_ready:  cover (f_inside == 2'd1 && s_ready);
    c_stable: cover (f_was_stalled && m_ready);
end
