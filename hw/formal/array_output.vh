// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "an event leaves after those before it, at the output for owned or for passed ones as it came, all fields unchanged"
count = "each event leaves once, and never at both outputs"
overflow = "the queue never holds more than its 16 places, if at most eight events follow the fall of room"
stable = "an owned or passed event that is not taken stays"
dry = "an event inside is at the output within three clocks"

[[tasks]]
name = "default"
parameters = { X_W = 9, Y_W = 9, REL_W = 10, SEQ_W = 48, SLOT_W = 3 }
k = 2
covers_within = 22
quick = true

[[tasks]]
name = "wide"
parameters = { X_W = 11, Y_W = 10, REL_W = 9, SEQ_W = 64, SLOT_W = 6 }
k = 2
covers_within = 22

[[faults]]
meaning = "a passed event goes with its recentred address"
right = "in_x = s_owned ?"
wrong = "in_x = 1'b1 ?"
breaks = ["order"]
within = 8

[[faults]]
meaning = "an event overtakes while the output stalls"
right = "wire       gives      = waiting && !held"
wrong = "wire       gives      = waiting"
breaks = ["order", "count"]
within = 12

[[faults]]
meaning = "room falls an event late"
right = "level <= 5'd7"
wrong = "level <= 5'd8"
breaks = ["overflow"]
within = 22

[[faults]]
meaning = "a waiting owned event is overwritten"
right = "(own && !m_own_ready) ||"
wrong = ""
breaks = ["stable"]
within = 10

[[faults]]
meaning = "a waiting passed event is overwritten"
right = "|| (pass && !m_pass_ready)"
wrong = ""
breaks = ["stable"]
within = 10

[[faults]]
meaning = "an event is seen a clock late"
right = "waiting <= gives ? after_read != written : read != written"
wrong = "waiting <= gives ? after_read != written : read != written && after_read != written"
breaks = ["dry"]
within = 12
*/
// An event that comes is marked, any one of them, and where it must be follows from how many are ahead of it. At most eight events
// may follow once `room` is low: this is assumed, as cot_array promises it.
localparam F_W = 1 + SLOT_W + AT_X_W + AT_Y_W + 1 + SEQ_W;

(* anyconst *) wire [F_W-1:0] f_word;
(* anyconst *) wire [3:0]     f_place;
(* anyseq *)   wire           f_choose;

reg [4:0] f_ahead, f_inside;
reg [3:0] f_since;  // events since room is low
reg [1:0] f_dry;    // clocks in a row with events inside and none at the output
reg       f_waits, f_was_own, f_was_pass;
reg [F_W-1:0] f_was;

wire f_valid = own || pass;
wire f_out   = f_valid && !held;
wire [4:0] f_level = written - read;
wire [F_W-1:0] f_in = {s_owned, s_slot & {SLOT_W{s_owned}}, s_owned ? {{(AT_X_W - REL_W) {1'b0}}, s_rel_x} : {{(AT_X_W - X_W) {1'b0}}, s_x},
                       s_owned ? {{(AT_Y_W - REL_W) {1'b0}}, s_rel_y} : {{(AT_Y_W - Y_W) {1'b0}}, s_y}, s_p, s_seq};
wire [F_W-1:0] f_now = m_own_valid
    ? {1'b1, m_own_slot, {{(AT_X_W - REL_W) {1'b0}}, m_own_x}, {{(AT_Y_W - REL_W) {1'b0}}, m_own_y}, m_own_p, m_own_seq}
    : {1'b0, {SLOT_W{1'b0}}, {{(AT_X_W - X_W) {1'b0}}, m_pass_x}, {{(AT_Y_W - Y_W) {1'b0}}, m_pass_y}, m_pass_p, m_pass_seq};
wire f_mark = s_valid && f_choose && !f_waits && f_in == f_word && written[3:0] == f_place;

wire [EVENT_W+1:0] f_stored = event_mem[f_place];
wire [SEQ_W-1:0]   f_stored_seq = seq_mem[f_place];
wire f_in_memory = f_waits && f_ahead >= {4'd0, f_valid};
wire [F_W-1:0] f_content = {f_stored[EVENT_W+1], f_stored[EVENT_W-1-:SLOT_W] & {SLOT_W{f_stored[EVENT_W+1]}},
                            f_stored[EVENT_W-SLOT_W-1:0], f_stored_seq};

// The word that is marked has nothing in bits that its output does not have.
wire [AT_X_W-1:0] f_x = f_word[SEQ_W+1+AT_Y_W+:AT_X_W];
wire [AT_Y_W-1:0] f_y = f_word[SEQ_W+1+:AT_Y_W];
wire f_fits = f_word[F_W-1] ? {f_x >> REL_W, f_y >> REL_W} == {(AT_X_W + AT_Y_W) {1'b0}}
                            : {f_word[F_W-2-:SLOT_W], f_x >> X_W, f_y >> Y_W} == {(SLOT_W + AT_X_W + AT_Y_W) {1'b0}};

always @* assume (!(s_valid && !room && f_since >= 4'd8));

always @(posedge clk) begin
    f_inside <= f_inside + {4'd0, s_valid} - {4'd0, f_out};
    f_since  <= room ? 4'd0 : f_since + {3'd0, s_valid};
    f_dry    <= (f_inside == 5'd0 || f_valid) ? 2'd0 : (f_dry == 2'd3) ? 2'd3 : f_dry + 2'd1;
    {f_was_own, f_was_pass} <= {m_own_valid && !m_own_ready, m_pass_valid && !m_pass_ready};
    f_was <= f_now;
    if (f_mark) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside - {4'd0, f_out};
    end else if (f_waits && f_out) begin
        f_ahead <= f_ahead - 5'd1;
        if (f_ahead == 5'd0) f_waits <= 1'b0;
    end
    if (rst) begin
        {f_waits, f_was_own, f_was_pass} <= 3'b000;
        f_inside <= 5'd0;
        f_since  <= 4'd0;
        f_dry    <= 2'd0;
    end
end

wire [15:0] f_one_owner;
genvar f_i;
generate
    for (f_i = 0; f_i < 16; f_i = f_i + 1) begin : f_each
        wire [EVENT_W+1:0] f_there = event_mem[f_i];
        wire [3:0] f_after = f_i[3:0] - read[3:0];
        assign f_one_owner[f_i] = {1'b0, f_after} >= f_level || f_there[EVENT_W] == !f_there[EVENT_W+1];
    end
endgenerate

always @* if (f_past) begin
    p_order:    assert (!(f_waits && f_ahead == 5'd0 && f_valid) || f_now == f_word);
    p_count:    assert (f_inside == f_level + {4'd0, f_valid} && !(own && pass));
    p_overflow: assert (f_level <= 5'd16);
    p_stable:   assert ((!f_was_own || (m_own_valid && f_now == f_was)) && (!f_was_pass || (m_pass_valid && f_now == f_was)));
    p_dry:      assert (f_inside == 5'd0 || f_valid || f_dry <= 2'd1);
    i_place:    assert (!f_waits || f_ahead < f_inside);
    i_where:    assert (!f_in_memory || read[3:0] + f_ahead[3:0] - {3'd0, f_valid} == f_place);
    i_memory:   assert (!f_in_memory || f_content == f_word);
    i_fits:     assert (!f_waits || f_fits);
    i_owner:    assert (&f_one_owner);
    i_one:      assert (!f_in_memory || f_stored[EVENT_W+1] == f_word[F_W-1]);
    i_after:    assert (after_read == read + 5'd1);
    i_waiting:  assert (!waiting || f_level != 5'd0);
    i_dry:      assert (f_valid || f_inside == 5'd0 || f_dry <= {1'b0, waiting});
    i_room:     assert (f_level <= 5'd8 + {1'b0, f_since} && f_since <= 4'd8);
    c_order:    cover (f_waits && f_ahead == 5'd0 && f_was_own);
    c_count:    cover (f_inside == 5'd9);
    c_overflow: cover (f_level == 5'd16);
    c_stable:   cover (f_was_pass && m_pass_ready);
    c_dry:      cover (f_dry == 2'd1 && !f_valid && f_inside != 5'd0);
end
