// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "each set bit on the sensor with a known time leaves as one event, after those of earlier vectors and of lower bits, with the right t, x, y, p"
all = "events that go out have left or are inside, none is lost or repeated"
events = "n_events counts the events that left"
left_out = "n_untimed and n_outside count each event left out, by its reason"
stall = "s_ready is high again after L - 1 clocks in which the output moves, at most"
stable = "an event that is not taken stays"

[[tasks]]
name = "12"
parameters = { L = 12, T_W = 48, X_W = 11, Y_W = 11, WIDTH = 1280, HEIGHT = 720, COUNT_W = 32 }
k = 1
covers_within = 14
quick = true

[[tasks]]
name = "small"
parameters = { L = 5, T_W = 3, X_W = 3, Y_W = 1, WIDTH = 7, HEIGHT = 1, COUNT_W = 8 }
k = 1
covers_within = 14
quick = true

[[tasks]]
name = "1"
parameters = { L = 1, T_W = 1, X_W = 1, Y_W = 1, WIDTH = 1, HEIGHT = 1, COUNT_W = 8 }
k = 1
covers_within = 14
only = ["order", "events", "left_out", "stable"]

[[faults]]
task = "small"
meaning = "an event goes with the address of the vector"
right = "next_x = left + {7'd0, index}"
wrong = "next_x = left"
breaks = ["order"]
within = 12

[[faults]]
task = "small"
meaning = "a vector begins while the one before has a bit left"
right = "in_leaves ? !in_several : !several(rest)"
wrong = "in_leaves ? 1'b1 : !several(rest)"
breaks = ["all", "order"]
within = 14

[[faults]]
task = "small"
meaning = "the last column is beyond the sensor"
right = "wide || index < room"
wrong = "wide || index + 1 < room"
breaks = ["all", "left_out"]
within = 12

[[faults]]
task = "small"
meaning = "an event is counted that waits"
right = "if (m_valid && m_ready) n_events"
wrong = "if (m_valid) n_events"
breaks = ["events"]
within = 12

[[faults]]
task = "small"
meaning = "untimed events count as outside, too"
right = "if (leaves && event_known && !event_inside)"
wrong = "if (leaves && !event_inside)"
breaks = ["left_out"]
within = 12

[[faults]]
task = "small"
meaning = "a vector waits a clock longer than needed"
right = "in_leaves = in_valid && ending && output_ready"
wrong = "in_leaves = in_valid && ending && output_ready && lowest == {L{1'b0}}"
breaks = ["stall"]
within = 16

[[faults]]
task = "small"
meaning = "a stalled event is replaced"
file = "skid_buffer.v"
right = "output_free = m_ready || !m_valid_reg"
wrong = "output_free = 1'b1"
breaks = ["stable"]
within = 12
*/
// One event is marked, any set bit of any vector that is on the sensor and whose time is known: bit f_bit, with the fields f_word.
// f_ahead counts the events before it that go out. Where it must be follows from how many are in each stage.
localparam F_W = T_W + X_W + Y_W + 1;

(* anyconst *) wire [F_W-1:0] f_word;
(* anyconst *) wire [4:0]     f_bit;
(* anyseq *)   wire           f_choose;
always @* assume (f_bit < L);

(* hierconn *) wire [F_W-1:0] \u_output.skid_data_reg ;
(* hierconn *) wire           \u_output.skid_valid_reg ;

function [6:0] f_ones;
    input [L-1:0] bits;
    integer i;
    begin
        f_ones = 7'd0;
        for (i = 0; i < L; i = i + 1) f_ones = f_ones + {6'd0, bits[i]};
    end
endfunction

// The bits of a vector that lie on the sensor.
function [L-1:0] f_on;
    input [11:0] x;
    input [10:0] y;
    integer i;
    for (i = 0; i < L; i = i + 1) f_on[i] = {20'd0, x} + i < COLUMNS && {21'd0, y} < ROWS;
endfunction

wire [L-1:0] f_below  = ~({L{1'b1}} << f_bit);
wire [L-1:0] f_coming = f_on(s_x, s_y) & s_mask & {L{s_known}};
wire [L-1:0] f_first  = f_on(in_x, in_y) & in_mask & {L{in_valid && in_known}};
wire [L-1:0] f_second = f_on(left, y) & (lowest | rest) & {L{known}};
wire         f_third  = event_valid && event_known && event_inside;
wire [6:0]   f_at_output = {6'd0, m_valid} + {6'd0, u_output.skid_valid_reg};
wire [6:0]   f_third_n   = f_at_output + {6'd0, f_third};
wire [6:0]   f_second_n  = f_third_n + f_ones(f_second);

reg         f_waits, f_was_stalled;
reg [6:0]   f_ahead, f_inside, f_stall;
reg [F_W-1:0] f_was;
reg [COUNT_W-1:0] f_out;
wire f_in   = s_valid && s_ready;
wire f_gone = m_valid && m_ready;
wire [F_W-1:0] f_now = {m_t, m_x, m_y, m_p};
wire [11:0] f_s_x = s_x + {7'd0, f_bit}, f_in_x = in_x + {7'd0, f_bit}, f_left_x = left + {7'd0, f_bit};
wire f_mark = f_in && f_choose && !f_waits && f_coming[f_bit] && {s_t, f_s_x[X_W-1:0], s_y[Y_W-1:0], s_p} == f_word;

always @(posedge clk) begin
    f_was_stalled <= m_valid && !m_ready;
    f_was    <= f_now;
    f_inside <= f_inside + (f_in ? f_ones(f_coming) : 7'd0) - {6'd0, f_gone};
    f_stall  <= s_ready ? 7'd0 : f_stall + {6'd0, output_ready};
    f_out    <= f_out + f_gone;
    if (f_mark) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside + f_ones(f_coming & f_below) - {6'd0, f_gone};
    end else if (f_waits && f_gone) begin
        f_ahead <= f_ahead - 7'd1;
        if (f_ahead == 7'd0) f_waits <= 1'b0;
    end
    if (rst) begin
        {f_waits, f_was_stalled} <= 2'b00;
        f_inside <= 7'd0;
        f_stall  <= 7'd0;
        f_out    <= {COUNT_W{1'b0}};
    end
end

// Events that are left out leave the third stage: why, and how many are on their way there.
wire [L-1:0] f_dropped_first  = in_mask & {L{in_valid}} & ~f_first;
wire [L-1:0] f_dropped_second = (lowest | rest) & ~f_second;
reg  [COUNT_W-1:0] f_untimed, f_outside;
always @(posedge clk) begin
    if (f_in && !s_known) f_untimed <= f_untimed + f_ones(s_mask);
    if (f_in && s_known) f_outside <= f_outside + f_ones(s_mask & ~f_coming);
    if (rst) {f_untimed, f_outside} <= {2 * COUNT_W{1'b0}};
end
wire [7:0] f_late_untimed = (in_known ? 8'd0 : f_ones(f_dropped_first)) + (known ? 8'd0 : f_ones(f_dropped_second)) + {7'd0, event_valid && !event_known};
wire [7:0] f_late_outside = (in_known ? f_ones(f_dropped_first) : 8'd0) + (known ? f_ones(f_dropped_second) : 8'd0) + {7'd0, event_valid && event_known && !event_inside};

wire f_is_second = f_waits && f_ahead >= f_third_n && f_ahead < f_second_n;
wire f_is_first  = f_waits && f_ahead >= f_second_n;
wire [11:0] f_room = COLUMNS[12:0] - {1'b0, left};

always @* if (f_past) begin
    p_order:  assert (!(f_waits && f_ahead == 7'd0 && m_valid) || f_now == f_word);
    p_all:    assert (f_inside == f_second_n + f_ones(f_first));
    p_events: assert (n_events == f_out);
    p_left_out: assert (f_untimed == n_untimed + f_late_untimed && f_outside == n_outside + f_late_outside);
    p_stall:  assert (s_ready || f_stall <= L - 1);
    p_stable: assert (!f_was_stalled || (m_valid && f_now == f_was));
    i_place:  assert (!f_waits || f_ahead < f_inside);
    i_skid:   assert (!(f_waits && f_ahead == 7'd1 && u_output.skid_valid_reg) || u_output.skid_data_reg == f_word);
    i_third:  assert (!(f_waits && f_ahead == f_at_output && f_third) || {event_t, event_x, event_y, event_p} == f_word);
    i_second: assert (!f_is_second || (f_second[f_bit] && f_ahead == f_third_n + f_ones(f_second & f_below)
                                       && {t, f_left_x[X_W-1:0], y[Y_W-1:0], p} == f_word));
    i_first:  assert (!f_is_first || (f_first[f_bit] && f_ahead == f_second_n + f_ones(f_first & f_below)
                                      && {in_t, f_in_x[X_W-1:0], in_y[Y_W-1:0], in_p} == f_word));
    i_lowest: assert ((lowest & (lowest - 1'b1)) == {L{1'b0}} && (lowest == {L{1'b0}} ? rest == {L{1'b0}} : (rest & (lowest | (lowest - 1'b1))) == {L{1'b0}}));
    i_ending: assert (ending == (rest == {L{1'b0}}) && (!in_valid || in_several == (f_ones(in_mask) > 7'd1)));
    i_room:   assert (lowest == {L{1'b0}} || ({21'd0, y} >= ROWS || {20'd0, left} > COLUMNS ? !wide && room == 5'd0 : wide == |f_room[11:5] && room == f_room[4:0]));
    i_skids:  assert (!(output_ready && u_output.skid_valid_reg) && !(u_output.skid_valid_reg && !m_valid));
    i_stall:  assert (s_ready || f_stall + f_ones(rest) <= L - 1);
    c_order:  cover (f_waits && f_ahead == 7'd1 && f_bit == L - 1 && f_was_stalled);
    c_all:    cover (f_inside == L + 1);
    c_events: cover (n_events == 2);
    c_left_out: cover (n_untimed == 2 && n_outside == 2);
    c_stall:  cover (!s_ready && f_stall != 7'd0);
    c_stable: cover (f_was_stalled && m_ready);
end
