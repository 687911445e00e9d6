// SPDX-License-Identifier: Apache-2.0
/*
[properties]
said = "a record that is said is at the output in the next clock, with the fields as they were given"
other = "m_cm_other is the id of the track that stays in a merge, else 0"
stable = "a record at the output stays until it is accepted"
all = "no record is lost or repeated, if each is said a clock after one in which free is high and nothing is said"

[[tasks]]
name = "default"
k = 1
covers_within = 8
quick = true

[[faults]]
meaning = "a record replaces the one that waits"
right = "free = !m_cm_valid || m_cm_ready"
wrong = "free = 1'b1"
breaks = ["stable", "all"]
within = 8

[[faults]]
meaning = "a record has the number of an earlier clock"
right = "m_cm_seq     <= seq"
wrong = "m_cm_seq     <= m_cm_seq"
breaks = ["said"]
within = 8

[[faults]]
meaning = "a record that was accepted stays"
right = "if (m_cm_ready) m_cm_valid <= 1'b0"
wrong = "if (m_cm_ready && !m_cm_kind[1]) m_cm_valid <= 1'b0"
breaks = ["all"]
within = 8

[[faults]]
meaning = "the kind counts as it is when the record is said"
right = "m_cm_other   <= merges"
wrong = "m_cm_other   <= (kind == `EVCOT_KIND_MERGED)"
breaks = ["other"]
within = 8
*/
localparam F_W = 2 + SLOT_W + 2 * ID_W + 4 * SIDE_W + 42 + SUP_W + SEQ_W + TIME_W;

reg             f_free, f_said, f_was_stalled, f_merges;
reg [F_W-1:0]   f_given, f_was;
reg [1:0]       f_waiting;  // records that were said and are not accepted

// say comes a clock after free, and not twice in a row.
always @* if (f_past) assume (!say || f_free);

wire [F_W-1:0] f_out = {m_cm_kind, m_cm_slot, m_cm_id, m_cm_other, m_cm_x, m_cm_y, m_cm_width, m_cm_height, m_cm_v_x, m_cm_v_y,
                        m_cm_n_ev, m_cm_support, m_cm_seq, m_cm_time};

always @(posedge clk) begin
    f_free        <= free && !say;
    f_merges      <= kind == `EVCOT_KIND_MERGED;
    f_said        <= say;
    f_was_stalled <= m_cm_valid && !m_cm_ready;
    f_was         <= f_out;
    f_given       <= {kind, slot, id, f_merges ? stays_id : {ID_W{1'b0}}, sum_x[SIDE_W:1], sum_y[SIDE_W:1], side_x, side_y, v_x, v_y,
                      n_ev, support, seq, now};
    f_waiting     <= f_waiting + {1'b0, say} - {1'b0, m_cm_valid && m_cm_ready};
    if (rst) begin
        {f_free, f_said, f_was_stalled} <= 3'b000;
        f_waiting <= 2'd0;
    end
end

always @* if (f_past) begin
    p_said:   assert (!f_said || (m_cm_valid && f_out == f_given));
    p_other:  assert (!f_said || m_cm_other == f_given[4*SIDE_W+42+SUP_W+SEQ_W+TIME_W+:ID_W]);
    p_stable: assert (!f_was_stalled || (m_cm_valid && f_out == f_was));
    p_all:    assert (f_waiting == {1'b0, m_cm_valid});
    i_merges: assert (merges == f_merges);
    i_free:   assert (!f_free || !m_cm_valid);
    c_said:   cover (f_said && m_cm_kind == `EVCOT_KIND_MERGED);
    c_other:  cover (f_said && m_cm_other != {ID_W{1'b0}});
    c_stable: cover (f_was_stalled && m_cm_ready);
    c_all:    cover (f_waiting == 2'd1 && m_cm_ready);
end
