// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*axis_words*"]

[properties]
once = "each word of events, and no other, is given to event_vector once; other words are taken at once"
mark = "each time mark, and nothing else, is given to time_mark once"
single = "a single event has the column and polarity of its word, and the row and time that were set last"
vector = "a vector begins at the base, which each vector moves on by its length; row, time and polarity are those set last"
known = "events are known once time and row are set, and a base for vectors; a change of another row makes them unknown"
reserved = "n_reserved is the number of words of reserved types"

[[tasks]]
name = "defaults"
parameters = { DATA_W = 32, T_W = 48 }
k = 1
covers_within = 22
quick = true

[[tasks]]
name = "25"
parameters = { DATA_W = 16, T_W = 25, X_W = 1, Y_W = 1, WIDTH = 1, HEIGHT = 1, COUNT_W = 8 }
k = 1
covers_within = 22

[[tasks]]
name = "64"
parameters = { DATA_W = 64, T_W = 64, COUNT_W = 64 }
k = 1
covers_within = 22

[[faults]]
meaning = "vectors of 8 are skipped"
right = "kind == VECTOR_12 || kind == VECTOR_8;"
wrong = "kind == VECTOR_12;"
breaks = ["once"]
within = 8

[[faults]]
meaning = "a mark is taken from types 9 to 15 as well"
right = "taken && kind == TIME_HIGH"
wrong = "taken && kind[3]"
breaks = ["mark"]
within = 8

[[faults]]
meaning = "a mark that is repeated sets the low bits to 0"
right = "if (new_mark) low"
wrong = "low"
breaks = ["single"]
within = 10

[[faults]]
meaning = "the base moves on by 12 after a vector of 8"
right = "(kind == VECTOR_12 ? 12'd12 : 12'd8)"
wrong = "12'd12"
breaks = ["vector"]
within = 10

[[faults]]
meaning = "the base stays from 1024 on"
right = "is_vector && !base[11]"
wrong = "is_vector && !base[10]"
breaks = ["vector"]
within = 10

[[faults]]
meaning = "a vector of 8 has the upper bits of its word, too"
right = "kind == VECTOR_12 ? word[11:8] : 4'd0"
wrong = "word[11:8]"
breaks = ["vector"]
within = 10

[[faults]]
meaning = "another row leaves the old one known"
right = "OTHER_ROW: row_known <= 1'b0"
wrong = "OTHER_ROW: row_known <= row_known"
breaks = ["known", "single"]
within = 10

[[faults]]
meaning = "type 1 is not counted as reserved"
right = "16'b1100_0101_1111_1101"
wrong = "16'b1100_0101_1111_1111"
breaks = ["reserved"]
within = 8
*/
// Words come as axis_words gives them: one that is not taken stays. What words have set so far is kept here anew, as the format has
// it, and compared with what time_mark and event_vector are given; their own properties say what becomes of that.
(* hierconn *) wire              \u_mark.set ;
(* hierconn *) wire [MARK_W-1:0] \u_mark.mark ;
(* hierconn *) wire              \u_events.s_valid ;
(* hierconn *) wire [T_W-1:0]    \u_events.s_t ;
(* hierconn *) wire [11:0]       \u_events.s_x ;
(* hierconn *) wire [10:0]       \u_events.s_y ;
(* hierconn *) wire              \u_events.s_p ;
(* hierconn *) wire [11:0]       \u_events.s_mask ;
(* hierconn *) wire              \u_events.s_known ;

reg                f_was_stalled, f_has_row, f_has_base, f_p;
reg [15:0]         f_was;
reg [11:0]         f_low;
reg [10:0]         f_row;
reg [12:0]         f_base;  // 2048 and more: beyond every sensor
reg [COUNT_W-1:0]  f_reserved;
wire [3:0]  f_type   = word[15:12];
wire        f_vector = f_type == 4'd4 || f_type == 4'd5;
wire        f_event  = f_type == 4'd2 || f_vector;
wire        f_in     = word_valid && word_ready;

always @* assume (!f_was_stalled || (word_valid && word == f_was));

always @(posedge clk) begin
    f_was_stalled <= word_valid && !word_ready;
    f_was <= word;
    if (f_in && f_type == 4'd0) {f_has_row, f_row} <= {1'b1, word[10:0]};
    if (f_in && f_type == 4'd1) f_has_row <= 1'b0;
    if (f_in && f_type == 4'd3) {f_has_base, f_p, f_base} <= {1'b1, word[11], 2'b00, word[10:0]};
    if (f_in && f_type == 4'd4 && f_base < 13'd2048) f_base <= f_base + 13'd12;
    if (f_in && f_type == 4'd5 && f_base < 13'd2048) f_base <= f_base + 13'd8;
    if (f_in && f_type == 4'd6) f_low <= word[11:0];
    if (f_in && f_type == 4'd8 && (!timed || word[11:0] != high[11:0])) f_low <= 12'd0;
    if (f_in && (f_type == 4'd1 || f_type == 4'd9 || f_type >= 4'd11 && f_type <= 4'd13)) f_reserved <= f_reserved + 1'b1;
    if (rst) begin
        {f_was_stalled, f_has_row, f_has_base} <= 3'b000;
        f_low      <= 12'd0;
        f_reserved <= {COUNT_W{1'b0}};
    end
end

always @* if (f_past) begin
    p_once:     assert (u_events.s_valid == (word_valid && f_event) && word_ready == (!f_event || events_ready));
    p_mark:     assert (u_mark.set == (f_in && f_type == 4'd8) && (!u_mark.set || u_mark.mark == word[11:0]));
    p_single:   assert (!(u_events.s_valid && f_type == 4'd2 && u_events.s_known)
                        || (timed && f_has_row && u_events.s_t == {high, f_low} && u_events.s_x == {1'b0, word[10:0]}
                            && u_events.s_y == f_row && u_events.s_p == word[11] && u_events.s_mask == 12'd1));
    p_vector:   assert (!(u_events.s_valid && f_vector && u_events.s_known)
                        || (timed && f_has_row && f_has_base && u_events.s_t == {high, f_low}
                            && (f_base < 13'd2048 ? u_events.s_x == f_base[11:0] : u_events.s_x >= 12'd2048)
                            && u_events.s_y == f_row && u_events.s_p == f_p
                            && u_events.s_mask == (f_type == 4'd4 ? word[11:0] : {4'd0, word[7:0]})));
    p_known:    assert (!u_events.s_valid || u_events.s_known == (timed && f_has_row && (f_has_base || f_type == 4'd2)));
    p_reserved: assert (n_reserved == f_reserved);
    i_set:      assert (low == f_low && row_known == f_has_row && base_known == f_has_base && (!f_has_row || row == f_row)
                        && (!f_has_base || (base == f_base[11:0] && polarity == f_p && f_base < 13'd2060)));
    c_once:     cover (f_was_stalled && f_in && f_vector);
    c_mark:     cover (u_mark.set && timed && f_low != 12'd0);
    c_single:   cover (f_in && f_type == 4'd2 && u_events.s_known && f_low != 12'd0);
    c_vector:   cover (f_in && f_vector && u_events.s_known && f_base == 13'd2047 + 13'd12);
    c_known:    cover (f_in && f_event && u_events.s_known);
    c_reserved: cover (n_reserved == 2);
end
