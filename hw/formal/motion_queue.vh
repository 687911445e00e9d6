// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "each token leaves after those before it, unchanged, with the sum of all ticks up to it as its time"
burst = "it is marked as within a burst if, and only if, 16 events or more came before it at its tick"
all = "no token is lost or repeated, and at most 17 are inside"
stable = "a token at the output stays until it is taken"
soon = "while no step holds it up, a token inside is at the output after 4 clocks without one there"
due = "m_due and m_runs say whether a step is due before the token at the output; outside steps, at any clock"

[[tasks]]
name = "small"
parameters = { X_W = 1, Y_W = 1, TICK_W = 2, TIME_W = 6, DUE_W = 4 }
k = 2
covers_within = 30
quick = true

[[tasks]]
name = "default"
k = 2
covers_within = 12
only = ["stable", "soon", "due"]
quick = true

[[tasks]]
name = "wide"
parameters = { X_W = 16, Y_W = 16, TICK_W = 32, DUE_W = 34 }
k = 2
covers_within = 12
only = ["stable", "soon", "due"]

[[faults]]
meaning = "the next token is the one that is written"
right = "next       <= tokens[read[3:0]]"
wrong = "next       <= tokens[written[3:0]]"
breaks = ["order"]
within = 10

[[faults]]
meaning = "a token has the time of the one before it"
right = "in_2       <= {in_time,"
wrong = "in_2       <= {m_time,"
breaks = ["order"]
within = 10

[[faults]]
meaning = "the fifteenth event is within a burst"
right = "in_event && !before_it[4]};"
wrong = "in_event && !before_it[4]} + {4'd0, before_it == 5'd14};"
breaks = ["burst"]
since = 23
within = 28

[[faults]]
meaning = "time that passes does not end a burst"
right = "in_later <= |s_tick"
wrong = "in_later <= s_tick[0]"
breaks = ["burst"]
since = 23
within = 28

[[faults]]
meaning = "tokens are accepted until the memory is full"
right = "level < 5'd12"
wrong = "level < 5'd16"
breaks = ["all"]
within = 26

[[faults]]
meaning = "a token is replaced while it waits"
right = "gives = (!m_valid && !holds) || m_ready"
wrong = "gives = !holds || m_ready"
breaks = ["stable"]
within = 10

[[faults]]
meaning = "only a token that leaves makes room"
right = "reads = gives || !next_valid"
wrong = "reads = m_ready"
breaks = ["soon"]
within = 10

[[faults]]
meaning = "a step under way is compared with the token behind"
right = "holds ? after_step[DUE_W-1] : until_step[DUE_W-1]"
wrong = "until_step[DUE_W-1]"
breaks = ["due"]
within = 12
*/
// A token is taken only where there is one and no step is under way, which alone moves next_step: not in its last clock.
(* anyseq *) wire f_choose;

reg               f_waits, f_was_stalled, f_was_holds, f_moved;
reg [4:0]         f_ahead, f_inside;
reg [TOKEN_W-1:0] f_token, f_was;
reg [TIME_W-1:0]  f_time, f_was_step;
reg [4:0]         f_same;   // events at the tick of the token that came last, at most 16
reg [2:0]         f_clocks; // in which there was a token inside, none at the output, and no step

always @* assume (!m_ready || (m_valid && !holds));
always @* if (f_past) assume (next_step == f_was_step || f_was_holds);
always @* if (f_past && next_step != f_was_step) assume (holds);

wire               f_in     = s_valid && s_ready;
wire [4:0]         f_before = |s_tick ? 5'd0 : f_same;
wire [TIME_W-1:0]  f_at     = f_time + {{(TIME_W - TICK_W) {1'b0}}, s_tick};
wire [TOKEN_W-1:0] f_out    = {m_time, m_event, m_skip, m_x, m_y, m_p, m_burst};
wire [DUE_W-1:0]   f_until  = m_time[DUE_W-1:0] - next_step[DUE_W-1:0];

always @(posedge clk) begin
    f_was_stalled <= m_valid && !m_ready;
    f_was         <= f_out;
    f_was_holds   <= holds;
    f_was_step    <= next_step;
    f_moved       <= next_step != f_was_step;
    f_inside      <= f_inside + {4'd0, f_in} - {4'd0, m_ready};
    f_clocks      <= (f_inside == 5'd0 || m_valid || holds) ? 3'd0 : (f_clocks == 3'd7) ? 3'd7 : f_clocks + 3'd1;
    if (f_in) begin
        f_time <= f_at;
        f_same <= f_before + {4'd0, s_event && !f_before[4]};
    end
    if (f_in && f_choose && !f_waits) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside - {4'd0, m_ready};
        f_token <= {f_at, s_event, s_skip, s_x, s_y, s_p, f_before[4]};
    end else if (f_waits && m_ready) begin
        f_ahead <= f_ahead - 5'd1;
        if (f_ahead == 5'd0) f_waits <= 1'b0;
    end
    if (rst) begin
        {f_waits, f_was_stalled} <= 2'b00;
        f_inside <= 5'd0;
        f_clocks <= 3'd0;
        f_time   <= {TIME_W{1'b0}};
        f_same   <= 5'd0;
    end
end

// Where the marked token is: the place of each of these is the number of tokens nearer to the output.
wire [4:0] f_at_next   = {4'd0, m_valid};
wire [4:0] f_at_memory = f_at_next + {4'd0, next_valid};
wire [4:0] f_at_in_2   = f_at_memory + level;
wire [4:0] f_at_in     = f_at_in_2 + {4'd0, in_valid_2};
wire [4:0] f_entry     = read + f_ahead - f_at_memory;
wire [TOKEN_W-1:0] f_stored = tokens[f_entry[3:0]];
wire [TOKEN_W-1:0] f_found  = (f_ahead < f_at_next) ? f_out : (f_ahead < f_at_memory) ? next : (f_ahead < f_at_in_2) ? f_stored
                            : (f_ahead < f_at_in) ? in_2 : {in_time, in_event, in_skip, in_x, in_y, in_p, before_it[4]};
wire       f_first = f_waits && f_ahead == 5'd0 && m_valid;

always @* if (f_past) begin
    p_order:  assert (!f_first || f_out[TOKEN_W-1:1] == f_token[TOKEN_W-1:1]);
    p_burst:  assert (!f_first || m_burst == f_token[0]);
    p_all:    assert (f_inside == f_at_in + {4'd0, in_valid} && f_inside <= 5'd17);
    p_stable: assert (!f_was_stalled || (m_valid && f_out == f_was));
    p_soon:   assert (f_clocks <= 3'd4);
    p_due:    assert (!(m_valid && !f_was_holds && !holds) || (m_due == !f_until[DUE_W-1] && m_runs == !m_due));
    i_where:  assert (!f_waits || (f_ahead < f_inside && f_found == f_token));
    i_level:  assert (level <= 5'd15 && level + {4'd0, in_valid_2} + {4'd0, in_valid} <= (s_ready ? 5'd14 : 5'd15));
    i_time:   assert (in_time == f_time);
    i_same:   assert (f_same == (in_valid ? before_it + {4'd0, in_event && !before_it[4]} : same_tick) && f_same <= 5'd16 && same_tick <= 5'd16);
    i_due:    assert (!m_valid || f_moved || next_step != f_was_step || (m_due == !f_until[DUE_W-1] && m_runs == !m_due));
    i_soon:   assert (f_inside == 5'd0 || m_valid || f_clocks + (next_valid ? 3'd1 : |level ? 3'd2 : in_valid_2 ? 3'd3 : 3'd4) <= 3'd4);
    i_none:   assert (m_valid || !(m_due || m_runs));
    c_order:  cover (f_first && m_ready && f_token[X_W+Y_W+4+:3] == 3'd5 && f_was_stalled);
    c_burst:  cover (f_waits && f_token[0]);
    c_all:    cover (f_inside == 5'd17);
    c_stable: cover (f_was_stalled && m_ready);
    c_soon:   cover (f_clocks == 3'd4);
    c_due:    cover (m_valid && m_due && f_was_holds && !holds && !f_moved);
end
