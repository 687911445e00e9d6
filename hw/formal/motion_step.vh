// SPDX-License-Identifier: Apache-2.0
/*
[properties]
ends = "a motion step ends within the bound of docs/motion.md, besides waits for masks and records"
compares = "a step compares each of the other slots once at most"

[[tasks]]
name = "2 slots"
parameters = { N = 2, SLOT_W = 1 }
k = 1
covers_within = 62

[[tasks]]
name = "8 slots"
parameters = { N = 8, SLOT_W = 3 }
k = 1
quick = true
covers_within = 1
only = []

[[tasks]]
name = "64 slots"
parameters = { N = 64, SLOT_W = 6 }
k = 1
covers_within = 1
only = []

[[faults]]
meaning = "the length is waited for for one clock more"
right = "c_shorten <= 1'b1;\n                pause     <= clocks(3'd2);"
wrong = "c_shorten <= 1'b1;\n                pause     <= clocks(3'd3);"
breaks = ["ends"]
since = 58
within = 62

[[faults]]
meaning = "a slot that was compared is compared again"
right = "ahead      <= ahead & (ahead - {{(N - 1) {1'b0}}, 1'b1});"
wrong = "ahead      <= ahead;"
breaks = ["compares"]
since = 66
within = 80
*/
// The clocks from `start` to `done`. For each state, f_left is how many clocks are left at most, if no more slots are compared or united;
// what these take is allowed for when they begin.
//
// What is assumed of the parts around is proven in motion_work.vh, motion_meeting.vh, motion_pair.vh and motion_merge.vh: a slot is read
// four clocks after it is asked for, the window is there after six, what the slot meets 10 + n clocks after the question, n other slots
// being not free, a comparison after 22, a merge after 55 at most, besides its waits.
localparam [11:0] F_PAIR = 12'd22, F_MERGE = 12'd55;

(* anyconst *) wire [5:0] f_n;  // so many other slots are not free, at most
(* anyconst *) wire [5:0] f_d;  // by so many bits an age is shifted
(* anyseq *)   wire       f_merge_waits;
always @* assume (f_n < N);

reg        f_was_rst, f_ok;           // what was set before the first clock of a reset is over
reg        f_job;                     // a step is being computed
reg [11:0] f_credit;                  // clocks that are left of the bound, at most 4095
reg        f_late;                    // none was left
reg        f_any;                     // a slot was compared
reg [6:0]  f_compared;                // so many were
reg [4:1]  f_read;                    // so many clocks ago a slot was asked for,
reg [6:1]  f_window;                  // and a window
reg [7:0]  f_met;                     // since what it meets was asked for, 0 if it was not
reg [4:0]  f_pair;                    // since a comparison
reg [5:0]  f_merged;                  // since a merge, without waits
reg [6:0]  f_div;                     // for so many clocks a division may go on

wire       f_in_merge = state == MERGE && !merge;

always @* assume (!f_past || f_ok || rst);
always @* assume (!start || rests);
always @* assume (read_done == f_read[4]);
always @* assume (window_done == f_window[6] && window_soon == f_window[4]);
always @* assume (meet_done ? f_met >= 8'd10 : f_met != 8'd10 + {2'd0, f_n});
always @* assume (pair_done == (f_pair == 5'd22));
always @* assume (merged ? f_in_merge && f_merged >= 6'd1 : f_merged != 6'd55 || f_merge_waits);
always @* assume (!dividing || c_divide || f_div != 7'd0);
always @* assume (!nearby[slot]);

wire f_stall = goes_on && ((state == SAY && !record_free) || ((state == LENGTH || state == PLACE) && mask_busy && !(state == LENGTH && (too_long_x || too_long))))
            || (f_in_merge && f_merge_waits && !merged);

function [11:0] f_max;
    input [11:0] a, b;
    f_max = a < b ? b : a;
endfunction

function [11:0] f_count;  // of a pause
    input [6:0] ones;
    f_count = ones[6] ? 7 : ones[5] ? 6 : ones[4] ? 5 : ones[3] ? 4 : ones[2] ? 3 : ones[1] ? 2 : {11'd0, ones[0]};
endfunction

function [6:0] f_ones;  // slots of a mask
    input [N-1:0] mask;
    integer i;
    begin
        f_ones = 7'd0;
        for (i = 0; i < N; i = i + 1) f_ones = f_ones + {6'd0, mask[i]};
    end
endfunction

wire [11:0] f_p = f_count(pause), f_nn = {6'd0, f_n}, f_dd = {6'd0, f_d};
wire [11:0] f_fd = c_divide ? 12'd3 + f_dd : {5'd0, f_div};                     // until a division is over
wire [11:0] f_r  = f_read[4] ? 12'd0 : f_read[3] ? 12'd1 : f_read[2] ? 12'd2 : f_read[1] ? 12'd3 : 12'd4;  // until a slot is read
wire [11:0] f_w  = f_window[6] ? 12'd0 : f_window[5] ? 12'd1 : f_window[4] ? 12'd2 : f_window[3] ? 12'd3 : f_window[2] ? 12'd4
                 : f_window[1] ? 12'd5 : c_window ? 12'd6 : places[2] ? 12'd7 : places[1] ? 12'd8 : 12'd9;  // until the window is there
wire [11:0] f_m  = 12'd10 + f_nn - {4'd0, f_met};                               // until it is known what the slot meets
wire [11:0] f_q  = F_PAIR - {7'd0, f_pair};
wire [11:0] f_g  = F_MERGE - {6'd0, f_merged};
wire [11:0] f_again = f_max(12'd30 + f_nn, 12'd10 + f_dd);                      // from MEET to the end

function [11:0] f_placed;  // from where a window is asked for to the end
    input [11:0] n, d;
    f_placed = f_max(12'd39 + n, 12'd20 + d);
endfunction

function [11:0] f_decided;  // if DECIDE goes on in `then`
    input [11:0] then, divided;
    f_decided = f_max(then + 12'd18, divided + 12'd3);
endfunction

reg [11:0] f_left;
always @* begin
    f_left = 12'd0;
    case (state)
        AGE:     f_left = f_p + 12'd14 + f_placed(f_nn, f_dd);
        FETCHED: f_left = f_r + 12'd13 + f_placed(f_nn, f_dd);
        AGED:    f_left = f_p + 12'd12 + f_placed(f_nn, f_dd);
        MOVE:    f_left = f_p + 12'd9 + f_placed(f_nn, f_dd);
        LONG:    f_left = f_p + 12'd3 + f_placed(f_nn, f_dd);
        LENGTH:  f_left = f_p + f_placed(f_nn, f_dd);
        PLACE:   f_left = f_p + (widest ? 12'd14 : f_placed(f_nn, f_dd));
        WINDOW:  f_left = f_w + (widest ? 12'd4 : f_max(12'd29 + f_nn, 12'd10 + f_dd));
        SINCE:   f_left = f_max((c_ask ? 12'd10 + f_nn : f_m) + (compared ? 12'd19 : 12'd20), f_p + 12'd7 + f_dd);
        MET:     f_left = f_decided((c_ask ? 12'd10 + f_nn : f_m) + (compared ? 12'd1 : 12'd2), f_fd);
        SCAN:    f_left = f_decided(f_p + (at == slot ? 12'd1 : 12'd5), f_fd);
        COMPARE: f_left = f_decided(f_p + 12'd34, f_fd);
        PAIR:    f_left = f_decided(f_r + 12'd29, f_fd);
        FOUND:   f_left = f_decided((c_compare ? F_PAIR : f_q) + 12'd6, f_fd);
        YOUNGER: f_left = f_p + 12'd13 + f_dd + F_MERGE + f_again;
        OLDER:   f_left = f_p + 12'd7 + f_dd + F_MERGE + f_again;
        LIVED:   f_left = f_p + 12'd6 + f_dd + F_MERGE + f_again;
        STEPS:   f_left = f_max(f_p, f_fd) + 12'd2 + F_MERGE + f_again;
        MERGE:   f_left = touching ? f_decided((merge ? F_MERGE : f_g) + 12'd12 + f_nn, f_fd) : (merge ? F_MERGE : f_g) + 12'd1 + f_again;
        MEET:    f_left = f_p + f_again;
        DECIDE:  f_left = f_decided(f_p, f_fd);
        TOUCH:   f_left = f_p + 12'd38 + F_MERGE + f_nn;
        TOUCHED: f_left = f_r + 12'd33 + F_MERGE + f_nn;
        UNITE:   f_left = f_p + 12'd31 + F_MERGE + f_nn;
        REPORT:  f_left = f_max(f_p, f_fd) + 12'd3;
        BORN:    f_left = f_p + (!back ? 12'd12 : at != slot ? 12'd8 : 12'd7);
        SAY:     f_left = f_p + (kind == `EVCOT_KIND_LOST ? 12'd15 : 12'd2);
        LAPSE:   f_left = f_p + 12'd4;
        DONE:    f_left = f_p + 12'd1;
        default: f_left = 12'd0;
    endcase
end

localparam [4:0] DONE_LAST = DONE;

wire f_scans = state == SCAN || state == COMPARE || state == PAIR || state == FOUND;
wire f_waits = f_scans || state == FETCHED || state == WINDOW || state == MET || state == TOUCHED || state == MERGE;
wire f_other = state == COMPARE || state == PAIR || state == FOUND || state == YOUNGER || state == SCAN || state == TOUCH || state == TOUCHED || state == BORN;

wire f_early = state == AGE || state == FETCHED || state == AGED || state == MOVE || state == LONG || state == LENGTH || state == PLACE
            || state == WINDOW;
wire f_ends  = state == SAY || state == LAPSE || state == DONE || state == REST;

function f_one;  // at most one bit is set
    input [3:0] bits;
    f_one = (bits & (bits - 4'd1)) == 4'd0;
endfunction

wire f_is_alike = goes_on && state == FOUND && pair_done && alike;
wire f_touches  = goes_on && state == DECIDE && !is_visible && !(held && !again) && touches;
wire f_compares = goes_on && state == SCAN && any_ahead;
wire f_lengthen = goes_on && state == LENGTH && (too_long_x || too_long);

wire [11:0] f_base   = f_max(12'd56 + f_nn, 12'd37 + f_dd);
wire [13:0] f_allows = (f_lengthen ? 14'd5 : 14'd0) + (f_compares ? (f_any ? 14'd30 : 14'd34) : 14'd0)
                     + (f_is_alike ? {2'd0, f_dd + F_MERGE - 12'd7 + f_again} : 14'd0) + (f_touches ? {2'd0, 12'd21 + F_MERGE + f_nn} : 14'd0);
wire [13:0] f_next   = {2'd0, f_credit} + f_allows - {13'd0, f_job && !done && !f_stall};

always @(posedge clk) begin
    f_was_rst  <= rst;
    f_ok       <= rst ? f_was_rst && f_past : f_ok;
    f_job      <= start || (f_job && !done);
    f_credit   <= start ? f_base - 12'd1 : f_next[13:12] != 2'd0 ? 12'd4095 : f_next[11:0];
    f_late     <= !start && (f_late || (f_job && !done && f_credit == 12'd0 && f_allows == 14'd0 && !f_stall));
    f_any      <= !start && (f_any || f_compares);
    f_compared <= start ? 7'd0 : f_compared + {6'd0, f_compares};
    f_read     <= {f_read[3:1], start || fetch};
    f_window   <= {f_window[5:1], c_window};
    f_met      <= c_ask ? 8'd1 : f_met == 8'd0 || meet_done ? 8'd0 : f_met + 8'd1;
    f_pair     <= c_compare ? 5'd1 : f_pair == 5'd0 || pair_done ? 5'd0 : f_pair + 5'd1;
    f_merged   <= merge ? 6'd1 : merged || f_merged == 6'd0 ? 6'd0 : f_merged + {5'd0, !f_merge_waits};
    f_div      <= c_divide ? 7'd2 + {1'b0, f_d} : f_div == 7'd0 ? 7'd0 : f_div - 7'd1;
    if (rst) begin
        f_job    <= 1'b0;
        f_read   <= 4'd0;
        f_window <= 6'd0;
        f_met    <= 8'd0;
        f_pair   <= 5'd0;
        f_merged <= 6'd0;
        f_div    <= 7'd0;
    end
end


always @* if (f_past) begin
    i_begin: assert (f_ok || (f_was_rst && state == REST && rests && goes_on && !reads && places == 3'd0));
end

always @* if (f_past && f_ok) begin
    p_ends:     assert (!f_job || !f_late);
    p_compares: assert (!f_job || f_compared < N);

    i_job:     assert (rests == (state == REST) && f_job == (!rests || done) && (!done || rests) && state <= DONE_LAST && (!f_was_rst || (rests && !done)));
    i_pause:   assert ((pause & (pause + 7'd1)) == 7'd0 && (goes_on || !(state == REST || f_waits)));
    i_read:    assert (f_one(f_read) && (state == AGE ? !fetch && f_p <= 12'd2 && f_read == 4'd1 << (12'd2 - f_p)
                       : state == FETCHED ? !fetch && f_read == 4'd8 : state == PAIR || state == TOUCHED ? fetch != (f_read != 4'd0) : !fetch && f_read == 4'd0));
    i_place:   assert (f_one({c_window, places}) && f_one(f_window[4:1]) && f_one({f_window[6:5], 2'b00}) && !(f_window[4:1] != 4'd0 && f_window[6:5] != 2'd0)
                       && (state == WINDOW ? ({c_window, places} != 4'd0) != (f_window != 6'd0) : {c_window, places} == 4'd0 && f_window == 6'd0));
    i_meet:    assert (f_met <= 8'd10 + {2'd0, f_n} && (state == WINDOW ? c_ask == (!widest && f_window[5]) && f_met == {7'd0, !widest && f_window[6]}
                       : state == SINCE ? (compared ? c_ask == (f_p == 12'd2) && {4'd0, f_met} == 12'd2 - f_p : !c_ask && {4'd0, f_met} == 12'd4 - f_p)
                       : state == MET ? c_ask != (f_met != 8'd0) : !c_ask && f_met == 8'd0));
    i_since:   assert (state != SINCE || f_p <= 12'd2);
    i_pair:    assert (f_pair <= 5'd22 && (state == FOUND ? c_compare != (f_pair != 5'd0) : !c_compare && f_pair == 5'd0));
    i_merge:   assert (f_merged <= 6'd55 && (state == MERGE ? merge != (f_merged != 6'd0) : !merge && f_merged == 6'd0));
    i_divide:  assert (f_div <= 7'd2 + {1'b0, f_d});
    i_at:      assert (f_other || at == slot);
    i_scan:    assert (!f_scans || (f_any ? at != slot : state == SCAN && at == slot));
    i_any:     assert (!f_job || f_any == (f_compared != 7'd0));
    i_ahead:   assert (!f_job || (f_scans ? compared && !ahead[slot] && {1'b0, f_compared} + {1'b0, f_ones(ahead)} < N : f_compared < N));
    i_back:    assert (!f_job || !back || state == BORN || state == SAY || state == DONE || state == REST);
    i_born:    assert (state != BORN || back || at == slot);
    i_order:   assert (!f_job || (f_early ? !compared : compared || state == SINCE || state == MET || f_ends));
    i_lost:    assert (!(state == SAY && kind == `EVCOT_KIND_LOST) || (!compared && !back));
    i_first:   assert (!f_job || compared || !f_any);
    i_left:    assert (!f_job || done || (f_left != 12'd0 && f_left <= f_credit));

    c_ends:     cover (f_job && done && f_credit == 12'd0 && f_n == 6'd0 && !f_any);
    c_compares: cover (f_job && f_compared == 7'd1 && state == FOUND);
end
