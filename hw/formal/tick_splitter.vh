// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "an event leaves after those before it, all fields unchanged"
time = "the ticks of all tokens that leave up to an event sum to those of the tokens that came up to it"
all = "ticks and events that came have left or are inside"
dry = "a token is at the output in the second clock after it came"
stable = "a token that is not taken stays"

[[tasks]]
name = "default"
parameters = { X_W = 9, Y_W = 9, WIDE_W = 48, TICK_W = 20 }
k = 2
covers_within = 8
quick = true

[[tasks]]
name = "bit"
parameters = { X_W = 1, Y_W = 1, WIDE_W = 8, TICK_W = 1 }
k = 2
covers_within = 8

[[tasks]]
name = "equal"
parameters = { X_W = 11, Y_W = 11, WIDE_W = 20, TICK_W = 20 }
k = 2
covers_within = 8

[[tasks]]
name = "32"
parameters = { X_W = 16, Y_W = 16, WIDE_W = 48, TICK_W = 32 }
k = 2
covers_within = 8

[[faults]]
meaning = "an event leaves with the first part of its ticks"
right = "is_event && !more, is_skip"
wrong = "is_event, is_skip"
breaks = ["order", "all"]
within = 8

[[faults]]
meaning = "each part that goes ahead loses a half"
right = "<= halves - 1'b1"
wrong = "<= halves - 2'd2"
breaks = ["time", "all"]
within = 10

[[faults]]
meaning = "three halves count as two"
task = "bit"
right = "more_low  <= &wide_halves[1:0]"
wrong = "more_low  <= 1'b0"
breaks = ["time"]
within = 10

[[faults]]
meaning = "of the bits beyond, one is not looked at"
right = "more_high <= (beyond >> SPLIT_W)"
wrong = "more_high <= (beyond >> (SPLIT_W + 1))"
breaks = ["time"]
within = 8

[[faults]]
meaning = "a token waits for the next one"
right = ".s_valid(valid),"
wrong = ".s_valid(valid && s_valid),"
breaks = ["dry"]
within = 8

[[faults]]
meaning = "a stalled token changes"
file = "skid_buffer.v"
right = "output_free = m_ready || !m_valid_reg"
wrong = "output_free = 1'b1"
breaks = ["stable"]
within = 8
*/
// An event, or a skipped one, that is accepted is marked, any one of them, with the sum f_time of all ticks up to it. f_ahead counts the
// events before it. Sums are modulo 2^WIDE_W.
localparam F_W = X_W + Y_W + 3;

(* anyconst *) wire [F_W-1:0]    f_word;
(* anyconst *) wire [WIDE_W-1:0] f_time;
(* anyseq *)   wire              f_choose;
(* hierconn *) wire [TICK_W+F_W-1:0] \u_output.skid_data_reg ;
(* hierconn *) wire                  \u_output.skid_valid_reg ;
wire [TICK_W+F_W-1:0] f_skid = u_output.skid_data_reg;
wire                  f_skids = u_output.skid_valid_reg;

reg              f_waits, f_was_stalled;
reg [1:0]        f_ahead, f_inside, f_dry;
reg [WIDE_W-1:0] f_time_in, f_time_out;
reg [TICK_W+F_W-1:0] f_was;
wire [TICK_W+F_W-1:0] f_now = {m_tick, m_event, m_skip, m_x, m_y, m_p};

wire f_in   = s_valid && s_ready;
wire f_out  = m_valid && m_ready;
wire f_in_event  = f_in && (s_event || s_skip);
wire f_out_event = f_out && (m_event || m_skip);
wire [WIDE_W-1:0] f_time_next = f_time_in + s_tick;
wire f_mark = f_in_event && f_choose && !f_waits && {s_event, s_skip, s_x, s_y, s_p} == f_word && f_time_next == f_time;

always @(posedge clk) begin
    f_was_stalled <= m_valid && !m_ready;
    f_was    <= f_now;
    f_inside <= f_inside + {1'b0, f_in_event} - {1'b0, f_out_event};
    f_dry    <= (!valid || m_valid) ? 2'd0 : (f_dry == 2'd3) ? 2'd3 : f_dry + 2'd1;
    if (f_in) f_time_in <= f_time_next;
    if (f_out) f_time_out <= f_time_out + m_tick;
    if (f_mark) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside - {1'b0, f_out_event};
    end else if (f_waits && f_out_event) begin
        f_ahead <= f_ahead - 2'd1;
        if (f_ahead == 2'd0) f_waits <= 1'b0;
    end
    if (rst) begin
        {f_waits, f_was_stalled} <= 2'b00;
        f_inside   <= 2'd0;
        f_dry      <= 2'd0;
        f_time_in  <= {WIDE_W{1'b0}};
        f_time_out <= {WIDE_W{1'b0}};
    end
end

// Where events are, and the sum of the ticks up to each place.
wire [1:0] f_at_output = {1'b0, m_valid && (m_event || m_skip)};
wire [1:0] f_in_skid   = {1'b0, f_skids && |f_skid[F_W-1-:2]};
wire [1:0] f_in_stage  = {1'b0, valid && (is_event || is_skip)};
wire [WIDE_W-1:0] f_to_output = f_time_out + (m_valid ? m_tick : {TICK_W{1'b0}});
wire [WIDE_W-1:0] f_to_skid   = f_to_output + (f_skids ? f_skid[F_W+:TICK_W] : {TICK_W{1'b0}});
wire [WIDE_W-1:0] f_to_stage  = f_to_skid + (valid ? left : {WIDE_W{1'b0}});
wire f_skid_marked  = f_waits && f_in_skid[0] && f_ahead == f_at_output;
wire f_stage_marked = f_waits && f_in_stage[0] && f_ahead == f_at_output + f_in_skid;

always @* if (f_past) begin
    p_order:  assert (!(f_waits && f_ahead == 2'd0 && m_valid && (m_event || m_skip)) || f_now[F_W-1:0] == f_word);
    p_time:   assert (!(f_waits && f_ahead == 2'd0 && m_valid && (m_event || m_skip)) || f_time_out + m_tick == f_time);
    p_all:    assert (f_inside == f_at_output + f_in_skid + f_in_stage && f_time_in == f_to_stage);
    p_dry:    assert (!valid || m_valid || f_dry == 2'd0);
    p_stable: assert (!f_was_stalled || (m_valid && f_now == f_was));
    i_place:  assert (!f_waits || f_ahead < f_inside);
    i_skid:   assert (!f_skid_marked || (f_skid[F_W-1:0] == f_word && f_to_skid == f_time));
    i_stage:  assert (!f_stage_marked || ({is_event, is_skip, x, y, p} == f_word && f_time_in == f_time));
    i_more:   assert (!valid || more == (left >> TICK_W != {WIDE_W{1'b0}}));
    i_ready:  assert (!(output_ready && f_skids) && !(f_skids && !m_valid));
    i_began:  assert (output_ready || f_skids || !valid);
    c_order:  cover (f_waits && f_ahead == 2'd1);
    c_time:   cover (f_waits && f_ahead == 2'd0 && m_valid && m_event && m_tick != {TICK_W{1'b0}} && f_time_out != {WIDE_W{1'b0}});
    c_all:    cover (f_inside == 2'd3);
    c_dry:    cover (valid && !m_valid);
    c_stable: cover (f_was_stalled && m_ready);
end
