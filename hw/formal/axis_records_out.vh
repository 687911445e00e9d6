// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "each beat of a record leaves after those before it, unchanged"
all = "no beat is lost or repeated, and at most DEPTH records are in the memory"
ends = "tkeep leaves bytes out in the last beat of a record only, and tlast is high there only"
packet = "a packet has at most packet_records records"
stable = "a beat that is not taken stays, tkeep and tlast as well"

[[tasks]]
name = "motion"
parameters = { DATA_W = 64, DEPTH = 16, MOTION = 1, X_W = 25, Y_W = 25, SLOT_W = 4 }
k = 2
covers_within = 30
only = ["ends", "stable"]

[[tasks]]
name = "array"
parameters = { DATA_W = 256, DEPTH = 3, MOTION = 0 }
k = 2
covers_within = 20
quick = true

[[tasks]]
name = "one"
parameters = { DATA_W = 128, DEPTH = 1, MOTION = 1, X_W = 25, Y_W = 25 }
k = 2
covers_within = 20
only = ["order", "ends", "stable"]

[[tasks]]
name = "verdicts"
parameters = { DATA_W = 64, DEPTH = 2, MOTION = 1, CLASSIFY = 1, X_W = 25, Y_W = 25 }
k = 2
covers_within = 30

[[faults]]
task = "verdicts"
meaning = "a verdict goes into a record"
right = "takes_verdict = CLASSIFY != 0 && (beat_in == {BEAT_W{1'b0}} ? s_verdict_valid : in_verdict)"
wrong = "takes_verdict = CLASSIFY != 0 && s_verdict_valid"
breaks = ["order"]
within = 20

[[faults]]
task = "one"
meaning = "a beat is written over one that has not been read"
right = "put      = offered && !full"
wrong = "put      = offered"
breaks = ["order", "all"]
within = 20

[[faults]]
task = "array"
meaning = "a record is read a beat short"
right = "last_out = beat_out == LAST[BEAT_W-1:0]"
wrong = "last_out = beat_out == LAST[BEAT_W-1:0] - 1'b1"
breaks = ["ends"]
within = 12

[[faults]]
task = "array"
meaning = "every beat has all its bytes"
right = "assign m_axis_tkeep  = out_last ? SOME : ALL"
wrong = "assign m_axis_tkeep  = ALL"
breaks = ["ends"]
within = 10

[[faults]]
task = "one"
meaning = "tlast is high in all beats of the last record"
right = "tlast     <= ram_last && ends"
wrong = "tlast     <= ends"
breaks = ["ends"]
within = 14

[[faults]]
task = "one"
meaning = "a packet has a record too many"
right = "!(records + 16'd1 < packet_records)"
wrong = "!(records < packet_records)"
breaks = ["packet"]
within = 24

[[faults]]
task = "array"
meaning = "a beat is replaced while it waits"
right = "moves = (m_axis_tready && !holds) || !out_valid"
wrong = "moves = !holds || !out_valid"
breaks = ["stable", "all"]
within = 14
*/
// Registers of packets stay, and a record or a verdict that waits stays until the clock after s_rst. One beat is marked, f_beat of any record that is accepted,
// with its place f_record in the memory. f_ahead counts the beats before it.
(* anyconst *) wire [DATA_W-1:0]      f_word;
(* anyconst *) wire [BEAT_W-1:0]      f_beat;
(* anyconst *) wire [RECORD_NO_W-1:0] f_record;
(* anyconst *) wire [15:0]            f_packet_records, f_packet_wait;
(* anyseq *)   wire                   f_choose;

localparam F_W = LEVEL_W + BEAT_W + 2;
localparam [31:0] F_BEATS = BEATS, F_ALL = BEATS * DEPTH;

reg                    f_waits, f_was_stalled, f_just_came, f_was_last;
reg [F_W-1:0]          f_ahead, f_inside;
reg [DATA_W-1:0]       f_was;
reg [DATA_W/8-1:0]     f_was_keep;
reg [BEATS*DATA_W-1:0] f_was_record, f_was_verdict;
reg                    f_record_waits, f_verdict_waits;
reg [BEAT_W-1:0]       f_beat_out;  // of the beat at the output, or the next there
reg [15:0]             f_records;   // taken since the last tlast

always @* assume (packet_records == f_packet_records && f_packet_records != 16'd0 && packet_wait == f_packet_wait);
always @* assume (!f_record_waits || (s_cm_valid && bytes == f_was_record));
always @* assume (!f_verdict_waits || (s_verdict_valid && verdict == f_was_verdict));
always @* assume ({{(32 - RECORD_NO_W) {1'b0}}, f_record} < DEPTH && {{(32 - BEAT_W) {1'b0}}, f_beat} < BEATS);

wire [BEATS*DATA_W-1:0] f_bytes = takes_verdict ? verdict : bytes;
wire [BEATS*DATA_W-1:0] f_was_bytes  = in_verdict ? f_was_verdict : f_was_record;
wire                    f_was_source = in_verdict ? f_verdict_waits : f_record_waits;
wire f_in   = (s_cm_valid && s_cm_ready) || (s_verdict_valid && s_verdict_ready);
wire f_gone = m_axis_tvalid && m_axis_tready;
wire f_mark = f_in && f_choose && !f_waits && to == f_record && f_bytes[f_beat*DATA_W +: DATA_W] == f_word;
wire f_end  = f_beat_out == LAST[BEAT_W-1:0];
wire [F_W-1:0] f_one  = {{(F_W - 1) {1'b0}}, 1'b1};
wire [F_W-1:0] f_leaves = {{(F_W - 1) {1'b0}}, f_gone};

always @(posedge clk) begin
    f_was_stalled <= m_axis_tvalid && !m_axis_tready;
    f_was         <= m_axis_tdata;
    f_was_keep    <= m_axis_tkeep;
    f_was_last    <= m_axis_tlast;
    f_record_waits  <= s_cm_valid && !s_cm_ready && !s_rst;
    f_verdict_waits <= CLASSIFY != 0 && s_verdict_valid && !s_verdict_ready && !s_rst;
    f_was_record  <= bytes;
    f_was_verdict <= verdict;
    f_just_came   <= f_in;
    f_inside      <= f_inside + (f_in ? F_BEATS[F_W-1:0] : {F_W{1'b0}}) - f_leaves;
    if (f_gone) begin
        f_beat_out <= f_end ? {BEAT_W{1'b0}} : f_beat_out + 1'b1;
        if (m_axis_tlast) f_records <= 16'd0;
        else if (f_end) f_records <= f_records + 16'd1;
    end
    if (f_mark) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside + {{(F_W - BEAT_W) {1'b0}}, f_beat} - f_leaves;
    end else if (f_waits && f_gone) begin
        f_ahead <= f_ahead - f_one;
        if (f_ahead == {F_W{1'b0}}) f_waits <= 1'b0;
    end
    if (rst) begin
        {f_waits, f_was_stalled, f_record_waits, f_verdict_waits, f_just_came} <= 5'b00000;
        f_inside   <= {F_W{1'b0}};
        f_beat_out <= {BEAT_W{1'b0}};
        f_records  <= 16'd0;
    end
end

(* hierconn *) wire [DATA_W-1:0] \u_memory.ram_reg ;
(* hierconn *) wire [DATA_W-1:0] \u_memory.f_content ;
(* hierconn *) wire [RECORD_NO_W+BEAT_W-1:0] \u_memory.f_address ;
assign u_memory.f_address = {f_record, f_beat};

function [F_W-1:0] f_place;  // of a beat, as they lie in a row
    input [RECORD_NO_W-1:0] record;
    input [BEAT_W-1:0]      beat;
    f_place = {{(F_W - RECORD_NO_W) {1'b0}}, record} * F_BEATS[F_W-1:0] + {{(F_W - BEAT_W) {1'b0}}, beat};
endfunction

function [F_W-1:0] f_around;
    input [F_W-1:0] sum;
    f_around = (sum >= F_ALL[F_W-1:0]) ? sum - F_ALL[F_W-1:0] : sum;
endfunction

function [BEAT_W-1:0] f_after;
    input [BEAT_W-1:0] beat;
    input              on;
    f_after = !on ? beat : (beat == LAST[BEAT_W-1:0]) ? {BEAT_W{1'b0}} : beat + 1'b1;
endfunction

wire [F_W-1:0] f_out      = {{(F_W - 1) {1'b0}}, out_valid};
wire [F_W-1:0] f_outer    = f_out + {{(F_W - 1) {1'b0}}, ram_valid};  // beats behind the memory
wire [F_W-1:0] f_stored   = {{(F_W - LEVEL_W) {1'b0}}, level} * F_BEATS[F_W-1:0];
wire [F_W-1:0] f_unread   = f_stored - {{(F_W - BEAT_W) {1'b0}}, beat_out};
wire           f_in_memory = f_waits && f_ahead >= f_outer;
wire           f_on_its_way = write && write_to == {f_record, f_beat};
wire [BEAT_W-1:0] f_ram_beat = f_after(f_beat_out, out_valid);

always @* if (f_past) begin
    p_order:   assert (!(f_waits && f_ahead == {F_W{1'b0}} && m_axis_tvalid) || m_axis_tdata == f_word);
    p_all:     assert (f_inside == f_unread + f_outer && {{(32 - LEVEL_W) {1'b0}}, level} <= DEPTH);
    p_ends:    assert (!m_axis_tvalid || (m_axis_tkeep == (f_end ? SOME : ALL) && (f_end || !m_axis_tlast)));
    p_packet:  assert (!(m_axis_tvalid && f_end && !m_axis_tlast) || f_records + 16'd1 < packet_records);
    p_stable:  assert (!f_was_stalled || (m_axis_tvalid && m_axis_tdata == f_was && m_axis_tkeep == f_was_keep
                                          && m_axis_tlast == f_was_last));
    i_word:    assert (!(f_waits && f_ahead == {F_W{1'b0}} && out_valid) || m_axis_tdata == f_word);
    i_inside:  assert (!f_waits || f_ahead < f_inside);
    i_beat:    assert (f_beat_out <= LAST[BEAT_W-1:0] && beat_in <= LAST[BEAT_W-1:0]);
    i_out:     assert (!out_valid || out_last == f_end);
    i_tlast:   assert (!(out_valid && tlast) || out_last);
    i_holds:   assert (!holds || (out_valid && out_last && !tlast));
    i_ram:     assert (!ram_valid || ram_last == (f_ram_beat == LAST[BEAT_W-1:0]));
    i_read:    assert (beat_out == f_after(f_ram_beat, ram_valid));
    i_level:   assert (level != {LEVEL_W{1'b0}} || beat_out == {BEAT_W{1'b0}});
    i_to:      assert (f_around(f_place(from, {BEAT_W{1'b0}}) + f_stored) == f_place(to, {BEAT_W{1'b0}}));
    i_ends:    assert ({{(32 - RECORD_NO_W) {1'b0}}, from} < DEPTH && {{(32 - RECORD_NO_W) {1'b0}}, to} < DEPTH);
    i_where:   assert (!f_in_memory || f_around(f_place(from, beat_out) + f_ahead - f_outer) == f_place(f_record, f_beat));
    i_just:    assert (!f_just_came || f_unread >= F_BEATS[F_W-1:0]);
    i_write:   assert (!f_just_came || (write && write_to[BEAT_W-1:0] == LAST[BEAT_W-1:0]
                                        && f_around(f_place(write_to[BEAT_W+:RECORD_NO_W], LAST[BEAT_W-1:0]) + f_one)
                                           == f_place(to, {BEAT_W{1'b0}})));
    i_memory:  assert (!f_in_memory || (f_on_its_way && f_just_came && f_beat == LAST[BEAT_W-1:0]
                                        && f_ahead == f_inside - f_one ? write_data : u_memory.f_content) == f_word);
    i_other:   assert (!write || f_just_came || (write_to[BEAT_W+:RECORD_NO_W] == to && {{(32 - LEVEL_W) {1'b0}}, level} != DEPTH));
    i_partial: assert (!(f_was_source && to == f_record && f_beat < beat_in)
                       || (f_on_its_way ? write_data : u_memory.f_content) == f_was_bytes[f_beat*DATA_W +: DATA_W]);
    i_source:  assert (f_was_source || beat_in == {BEAT_W{1'b0}});
    i_begun:   assert (beat_in == {BEAT_W{1'b0}} || {{(32 - LEVEL_W) {1'b0}}, level} != DEPTH);
    i_ram_word: assert (!(f_waits && f_ahead == f_out && ram_valid) || u_memory.ram_reg == f_word);
    i_records: assert (records == (!(out_valid && out_last) ? f_records : tlast ? 16'd0 : f_records + 16'd1)
                       && records < packet_records && f_records < packet_records);
    c_order:   cover (f_waits && f_ahead == {F_W{1'b0}} && m_axis_tvalid && f_was_stalled && f_beat == LAST[BEAT_W-1:0]);
    c_all:     cover (f_inside > F_BEATS[F_W-1:0]);
    c_ends:    cover (f_gone && m_axis_tlast);
    c_packet:  cover (f_gone && f_end && !m_axis_tlast && f_records == 16'd1);
    c_stable:  cover (f_was_stalled && m_axis_tready && f_was_last);
end
