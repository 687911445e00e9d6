// SPDX-License-Identifier: Apache-2.0
/*
[properties]
wire = "a token passes at both sides in the same clock"
held = "a token that waits at the output is never withdrawn"
apply = "registers are written only while all behind is idle and no token is at the output"
rises = "the gate opens only if enabled, not busy, and idle was high from the third clock after busy on, and once since reset"
cleared = "cleared is high once idle was high since reset, and the gate is closed until then"
closes = "the gate closes in the clock after busy rises, as soon as no token waits"
opens = "the gate is open after four clocks of enable and idle without busy"
seq = "seq is the number of tokens with an event that passed"

[[tasks]]
name = "48"
parameters = { SEQ_W = 48 }
k = 3
covers_within = 16
quick = true

[[tasks]]
name = "8"
parameters = { SEQ_W = 8 }
k = 3
covers_within = 16

[[faults]]
meaning = "the source is not stopped by the closed gate"
right = "s_ready = m_ready && open"
wrong = "s_ready = m_ready"
breaks = ["wire"]
within = 6

[[faults]]
meaning = "the gate closes while a token waits"
right = "if (!waits) open"
wrong = "open"
breaks = ["held"]
within = 10

[[faults]]
meaning = "registers are written through the open gate"
right = "busy && !open && idle"
wrong = "busy && idle"
breaks = ["apply"]
within = 10

[[faults]]
meaning = "it opens a clock after the registers were written"
right = "SETTLE = 2'd3"
wrong = "SETTLE = 2'd1"
breaks = ["rises"]
within = 12

[[faults]]
meaning = "it opens without waiting for idle"
right = "settle > 2'd1 || idle"
wrong = "1'b1"
breaks = ["rises"]
within = 14

[[faults]]
meaning = "it opens before memories are cleared"
right = "enable && cleared && !busy"
wrong = "enable && !busy"
breaks = ["cleared", "rises"]
within = 6

[[faults]]
meaning = "it stays open when registers are to be written"
right = "cleared && !busy &&"
wrong = "cleared &&"
breaks = ["closes"]
within = 10

[[faults]]
meaning = "it opens only when a token waits"
right = "if (!waits) open <= enable"
wrong = "if (!waits) open <= s_valid && enable"
breaks = ["opens"]
within = 12

[[faults]]
meaning = "tokens without event are numbered"
right = "m_ready && s_counts"
wrong = "m_ready"
breaks = ["seq"]
within = 8
*/
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
