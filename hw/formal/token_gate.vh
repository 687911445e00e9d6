// SPDX-License-Identifier: Apache-2.0
// Registers may change only while nothing passes, and only once what is behind the gate has been idle since the last change.
reg             f_was_held, f_was_busy, f_was_ready, f_was_open, f_idle_since, f_idle_ever;
reg [1:0]       f_after;   // clocks since busy was high, at most 3
reg [2:0]       f_calm;    // clocks in a row with enable, idle, not busy
reg [SEQ_W-1:0] f_count;
wire f_passes = m_valid && m_ready;

always @* if (f_past && f_was_held) assume (s_valid);  // a token that waits is not withdrawn

always @(posedge clk) begin
    f_was_held  <= m_valid && !m_ready;
    f_was_busy  <= busy && !(m_valid && !m_ready);
    f_was_ready <= enable && !busy;
    f_was_open  <= open;
    f_idle_ever <= f_idle_ever || idle;
    f_after     <= busy ? 2'd0 : (f_after == 2'd3) ? 2'd3 : f_after + 2'd1;
    f_idle_since <= !busy && (f_idle_since || (idle && f_after >= 2'd2));
    f_calm      <= !(enable && idle && !busy) ? 3'd0 : (f_calm == 3'd7) ? 3'd7 : f_calm + 3'd1;
    if (f_passes && s_counts) f_count <= f_count + 1'b1;
    if (rst) begin
        {f_was_held, f_was_busy, f_was_ready, f_was_open, f_idle_ever} <= 5'd0;
        f_idle_since <= 1'b1;
        f_after <= 2'd3;
        f_calm  <= 3'd0;
        f_count <= {SEQ_W{1'b0}};
    end
end

always @* if (f_past) begin
    p_wire:    assert (f_passes == (s_valid && s_ready) && (!m_valid || s_valid));
    p_held:    assert (!f_was_held || m_valid);
    p_apply:   assert (!apply || (busy && idle && !f_passes && !m_valid));
    p_rises:   assert (!(open && !f_was_open) || (f_was_ready && f_idle_since && f_idle_ever));
    p_cleared: assert (cleared == f_idle_ever && (!open || cleared));
    p_closes:  assert (!f_was_busy || !open);
    p_opens:   assert (f_calm < 3'd4 || open);
    p_seq:     assert (seq == f_count);
    i_settle:  assert (settle <= 2'd3 - ((f_after == 2'd3) ? 2'd2 : f_after) && (settle == 2'd0 ? f_idle_since : settle >= 2'd3 - f_after));
    i_calm:    assert (f_calm == 3'd0 || (cleared && (settle == 2'd0 || {2'b00, settle} + {1'b0, f_calm} <= 4'd3)));
    c_wire:    cover (f_passes);
    c_held:    cover (f_was_held && busy && m_ready);
    c_apply:   cover (apply && f_count == 2);
    c_rises:   cover (open && !f_was_open && f_count == 1);
    c_cleared: cover (cleared && !open);
    c_closes:  cover (f_was_busy && f_was_open);
    c_opens:   cover (f_calm == 3'd4);
    c_seq:     cover (f_count == 2);
end
