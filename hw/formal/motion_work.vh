// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*motion_slot*", "t:*motion_pace*", "t:*motion_velocity*", "t:*motion_look*", "t:*motion_birth*", "t:*motion_lives*", "t:*motion_pair*", "t:*motion_meeting*", "t:*block_memory*", "t:*array_sum*", "t:*motion_sum*", "t:*multiplier*"]

[properties]
read = "a slot is read four clocks after it is asked for, not before; that of a correction when the correction begins, and loaded then"
lane = "`lane` changes in each clock, but for the one after a slot is loaded: there it is high"
leading = "the leading bit of the time is known seven clocks after it is asked for, at most"
placed = "a window is there six clocks after it is asked for, not before, and said to be there soon two clocks earlier"
alone = "a correction or a seed begins only when the one before is done"

[[tasks]]
name = "8 slots"
parameters = { N = 8, SLOT_W = 3 }
k = 1
covers_within = 44

[[tasks]]
name = "16 slots"
quick = true
parameters = { N = 16, SLOT_W = 4 }
k = 1
covers_within = 44
only = []

[[tasks]]
name = "64 slots"
parameters = { N = 64, SLOT_W = 6, X_W = 16, Y_W = 16, SIDE_W = 32, PX_W = 20, SUP_W = 32 }
k = 1
covers_within = 44
only = []

[[faults]]
meaning = "a slot is not always read"
right = "was_read   <= read_done;"
wrong = "was_read   <= read_done && may_return;"
breaks = ["read"]
within = 14

[[faults]]
file = "motion_sides.v"
meaning = "`lane` does not follow what is loaded"
right = "lane  <= is_y || load;"
wrong = "lane  <= is_y;"
breaks = ["lane"]
within = 14

[[faults]]
file = "motion_inverse.v"
meaning = "leading zeros are left out one by one"
right = "by_8 = left[23:16] == 8'd0"
wrong = "by_8 = 1'b0"
breaks = ["leading"]
within = 22

[[faults]]
file = "motion_window.v"
meaning = "the window is there a clock early"
right = "done <= step[4];"
wrong = "done <= step[3];"
breaks = ["placed"]
within = 44

[[faults]]
file = "motion_order.v"
meaning = "a job begins while another one is computed"
right = "job_valid && !at_work && k_rests && s_rests;"
wrong = "job_valid && s_rests;"
breaks = ["alone"]
within = 14
*/
// What motion_correct.vh assumes of the parts around motion_correct.v. A reset takes two clocks. Invariants say what is on its way, in
// which states of the three parts that say what is done.
(* hierconn *) wire [4:0] \u_order.u_correct.state ;
(* hierconn *) wire [6:0] \u_order.u_correct.pause ;
(* hierconn *) wire       \u_order.u_correct.reads ;
(* hierconn *) wire       \u_order.u_correct.rests ;
(* hierconn *) wire       \u_order.u_correct.c_window ;
(* hierconn *) wire       \u_order.u_correct.start ;
(* hierconn *) wire       \u_order.u_correct.load ;
(* hierconn *) wire [4:0] \u_order.u_step.state ;
(* hierconn *) wire [6:0] \u_order.u_step.pause ;
(* hierconn *) wire       \u_order.u_step.done ;
(* hierconn *) wire       \u_order.u_step.rests ;
(* hierconn *) wire       \u_order.u_step.fetch ;
(* hierconn *) wire       \u_order.u_step.merge ;
(* hierconn *) wire       \u_order.u_step.c_window ;
(* hierconn *) wire [2:0] \u_order.u_step.places ;
(* hierconn *) wire [4:0] \u_order.u_merge.state ;
(* hierconn *) wire [6:0] \u_order.u_merge.pause ;
(* hierconn *) wire       \u_order.u_merge.rests ;
(* hierconn *) wire       \u_order.u_merge.fetch ;
(* hierconn *) wire       \u_order.u_merge.done ;
(* hierconn *) wire       \u_order.u_merge.c_window ;
(* hierconn *) wire       \u_order.at_work ;
(* hierconn *) wire       \u_order.passes ;
(* hierconn *) wire       \u_order.loads ;
(* hierconn *) wire       \u_sides.is_y ;
(* hierconn *) wire [4:0] \u_window.step ;
(* hierconn *) wire       \u_inverse.busy ;
(* hierconn *) wire [23:0] \u_inverse.left ;

wire [4:0] f_k      = u_order.u_correct.state;
wire [6:0] f_k_ones = u_order.u_correct.pause;
wire       f_k_goes = !f_k_ones[0];
wire [4:0] f_s      = u_order.u_step.state;
wire [6:0] f_s_ones = u_order.u_step.pause;
wire       f_s_goes = !f_s_ones[0];
wire [4:0] f_m      = u_order.u_merge.state;
wire [6:0] f_m_ones = u_order.u_merge.pause;
wire       f_m_goes = !f_m_ones[0];

// States of motion_correct.v.
localparam [4:0] K_REST = 0, K_SEED = 1, K_SEED_1 = 2, K_SEED_2 = 3, K_LOAD = 5, K_SHRINK = 6, K_OFFSET = 7, K_LOOK = 8, K_LOOK_AT = 9,
    K_LOOK_GO = 10, K_LOOKING = 11, K_CUT = 12, K_ORDER = 13, K_ORDERED = 14, K_LOOKED = 15, K_CLEAR = 16, K_SPEED = 17, K_TURN = 18,
    K_COUNT = 19, K_SAY = 20, K_PLACE = 21, K_WINDOW = 22, K_KEPT = 23;
// Of motion_step.v, those that wait for what is read, or for the window, and of motion_merge.v.
localparam [4:0] S_REST = 0, S_AGE = 3, S_FETCHED = 4, S_WINDOW = 9, S_PAIR = 12, S_TOUCHED = 22, S_MERGE = 24;
localparam [4:0] M_REST = 0, M_GOES = 3, M_UNITE = 10, M_WINDOW = 16;

// Whether all that is set before the first clock of a reset is over: a reset takes two clocks at least.
reg f_was_rst, f_ok;
always @(posedge clk) begin
    f_was_rst <= rst;
    f_ok      <= rst ? f_was_rst && f_past : f_ok;
end
always @* assume (!f_past || f_ok || rst);

// ---- clocks since something was asked for ---------------------------------------------------------------------------------

reg [4:1] f_read;                        // a correction began so many clocks ago
reg [6:1] f_window;                      // its window was asked for
reg       f_works, f_was_lane, f_loads;  // the clock before: a job begins or goes on, `lane`, and its slot is loaded
reg [2:0] f_inverse;                     // for so many clocks the leading bit may still be looked for
reg       f_again;                       // a job was done
reg [4:1] f_fetch;                       // a slot was asked for so many clocks ago, by whatever job,
reg [6:1] f_place;                       // and a window
reg       f_loaded;                      // and one was loaded in the clock before

wire f_begins = u_order.u_correct.start;

always @(posedge clk) begin
    f_read     <= {f_read[3:1], f_begins && !job_kind[0]};
    f_window   <= {f_window[5:1], u_order.u_correct.c_window};
    f_works    <= f_begins || !u_order.u_correct.rests;
    f_was_lane <= lane;
    f_loads    <= u_order.u_correct.load && was_read;
    f_inverse  <= c_invert ? 3'd6 : f_inverse == 3'd0 ? 3'd0 : f_inverse - 3'd1;
    f_again    <= f_again || f_k == K_KEPT;
    f_fetch    <= {f_fetch[3:1], fetch};
    f_place    <= {f_place[5:1], c_place};
    f_loaded   <= c_loads;
    if (rst) begin
        f_fetch   <= 4'd0;
        f_place   <= 6'd0;
        f_read    <= 4'd0;
        f_window  <= 6'd0;
        f_inverse <= 3'd0;
        {f_works, f_again} <= 2'b00;
    end
end

// For so many clocks the leading bit is still looked for.
reg [3:0] f_wait;
always @* begin
    f_wait = 4'd0;
    if (!u_inverse.busy) f_wait = 4'd0;
    else if (u_inverse.left[23:20] != 0) f_wait = 4'd0;
    else if (u_inverse.left[23:19] != 0) f_wait = 4'd1;
    else if (u_inverse.left[23:18] != 0) f_wait = 4'd2;
    else if (u_inverse.left[23:17] != 0) f_wait = 4'd3;
    else if (u_inverse.left[23:16] != 0) f_wait = 4'd4;
    else if (u_inverse.left[23:12] != 0) f_wait = 4'd1;
    else if (u_inverse.left[23:11] != 0) f_wait = 4'd2;
    else if (u_inverse.left[23:10] != 0) f_wait = 4'd3;
    else if (u_inverse.left[23:9] != 0) f_wait = 4'd4;
    else if (u_inverse.left[23:8] != 0) f_wait = 4'd5;
    else if (u_inverse.left[23:4] != 0) f_wait = 4'd2;
    else if (u_inverse.left[23:3] != 0) f_wait = 4'd3;
    else if (u_inverse.left[23:2] != 0) f_wait = 4'd4;
    else if (u_inverse.left[23:1] != 0) f_wait = 4'd5;
    else f_wait = 4'd6;
end

// What is on its way: what is read, and the window.
wire [5:0] f_reading  = {u_order.u_step.fetch, u_order.u_merge.fetch, fetches, was_read};
wire [11:0] f_placing = {u_order.u_correct.c_window, u_order.u_step.places, u_order.u_step.c_window, u_order.u_merge.c_window,
                         u_window.step, window_done};
wire f_reads  = f_k == K_LOAD || f_s == S_AGE || f_s == S_FETCHED || f_s == S_PAIR || f_s == S_TOUCHED || f_m == M_GOES || f_m == M_UNITE;
wire f_places = f_k == K_WINDOW || f_s == S_WINDOW || f_m == M_WINDOW;

// In the first clock of a reset.
wire f_rests = f_k == K_REST && f_s == S_REST && f_m == M_REST && f_k_goes && f_s_goes && f_m_goes && !u_order.at_work && !u_order.passes
            && u_order.u_correct.rests && u_order.u_step.rests && u_order.u_merge.rests;

always @* if (f_past) begin
    i_begin:  assert (f_ok || (f_was_rst && f_rests && {fetches, was_read, u_order.u_step.places, u_window.step, window_done} == 13'd0));
end

always @* if (f_past && f_ok) begin
    p_read:    assert (was_read == f_fetch[4] && (f_k != K_LOAD || (was_read == f_read[4] && (!was_read || u_order.loads))));
    p_lane:    assert ((f_was_rst || lane == (!f_was_lane || f_loaded)) && (!f_works || lane == (!f_was_lane || f_loads)));
    p_leading: assert (!inverse_goes_on || c_invert || f_inverse != 3'd0);
    p_placed:  assert (window_done == f_place[6] && window_soon == f_place[4] && (f_k != K_WINDOW || window_done == f_window[6]));
    p_alone:   assert (!u_order.u_correct.start || u_order.u_correct.rests);

    i_reset:  assert (!f_was_rst || (u_order.u_correct.rests && u_order.u_step.rests && u_order.u_merge.rests));
    i_legal:  assert (f_k != 5'd4 && f_k <= K_KEPT && f_s <= 5'd29 && f_m <= 5'd20 && f_m != 5'd1 && f_m != 5'd14);
    i_one:    assert (u_order.u_correct.rests || (u_order.u_step.rests && !u_order.u_step.done && u_order.at_work && !u_order.passes));
    i_step:   assert (u_order.u_step.rests == (f_s == S_REST) && (u_order.u_step.rests ? f_s_goes && (!u_order.u_step.done || u_order.at_work)
                      : u_order.at_work && !u_order.passes && !u_order.u_step.done));
    i_passes: assert (!u_order.passes || u_order.at_work);
    i_merge:  assert (u_order.u_merge.rests == (f_m == M_REST) && (f_m != M_REST || f_m_goes)
                      && (f_s == S_MERGE) == (u_order.u_step.merge || !u_order.u_merge.rests || u_order.u_merge.done)
                      && !(u_order.u_step.merge && (!u_order.u_merge.rests || u_order.u_merge.done))
                      && (u_order.u_merge.rests || !u_order.u_merge.done));
    i_waits:  assert ((f_k_goes || (f_k != K_LOAD && f_k != K_LOOKING && f_k != K_CUT && f_k != K_CLEAR && f_k != K_SPEED && f_k != K_WINDOW && f_k != K_KEPT))
                      && (f_m_goes || (f_m != M_GOES && f_m != M_UNITE && f_m != M_WINDOW))
                      && (f_s_goes || (f_s != S_FETCHED && f_s != S_WINDOW && f_s != S_PAIR && f_s != S_TOUCHED && f_s != S_MERGE)));
    i_age:    assert (f_s == S_AGE ? !was_read && f_s_ones == {5'd0, fetches[1], fetches[1] || fetches[2]} : f_s != S_FETCHED || was_read);
    i_ones:   assert ((f_k_ones & (f_k_ones + 7'd1)) == 7'd0 && (f_s_ones & (f_s_ones + 7'd1)) == 7'd0 && (f_m_ones & (f_m_ones + 7'd1)) == 7'd0
                      && (f_k != K_REST || f_k_goes));
    i_reads:  assert ((f_reading & (f_reading - 6'd1)) == 6'd0 && (f_reading != 6'd0) == f_reads);
    i_places: assert ((f_placing & (f_placing - 12'd1)) == 12'd0 && (f_placing != 12'd0) == f_places);
    i_own:    assert ((!u_order.u_step.fetch || f_s == S_PAIR || f_s == S_TOUCHED) && (!u_order.u_merge.fetch || f_m == M_GOES || f_m == M_UNITE)
                      && (!u_order.u_correct.c_window || f_k == K_WINDOW) && (!u_order.u_merge.c_window || f_m == M_WINDOW)
                      && (!(|u_order.u_step.places || u_order.u_step.c_window) || f_s == S_WINDOW));
    i_load:   assert (u_order.u_correct.reads == (f_k == K_LOAD) && (!u_order.loads || was_read));

    i_ticks:  assert (u_order.u_correct.rests == (f_k == K_REST) && ticks != 24'd0 && u_sides.is_y == !lane);
    i_since:  assert (f_k == K_LOAD ? {fetches, was_read} == {f_read[3:1], f_read[4]} : f_read == 4'd0);
    i_window: assert (f_k == K_WINDOW ? {u_order.u_correct.c_window, u_window.step, window_done}
                      == {f_window == 6'd0, f_window[5:1], f_window[6]} : f_window == 6'd0);
    i_fetch:   assert ({fetches, was_read} == {f_fetch[3:1], f_fetch[4]});
    i_place:   assert ({u_window.step, window_done} == {f_place[5:1], f_place[6]});
    i_known:  assert (!u_inverse.busy || (u_inverse.left != 24'd0 && f_wait <= {1'b0, f_inverse}));
    i_loads:  assert (!(f_k == K_LOAD && was_read) || u_order.loads);

    c_read:    cover (f_k == K_LOAD && was_read);
    c_lane:    cover (f_works && f_loads && f_was_lane);
    c_leading: cover (f_inverse == 3'd1 && inverse_goes_on);
    c_placed:  cover (f_k == K_WINDOW && window_done);
    c_alone:   cover (u_order.u_correct.start && u_order.u_correct.rests && f_again);
end
