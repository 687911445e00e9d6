// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*array_input*", "t:*array_lives*", "t:*array_order*", "t:*array_output*", "t:*array_average*", "t:*cot_window*", "t:*weighted_mean*", "t:*cot_regs*"]

[properties]
apart = "when an event is decided, no two active windows share a pixel"
owner = "an event that an active window holds is owned by the slot of that window"

[[tasks]]
name = "2, narrow"
parameters = { N = 2, X_W = 3, Y_W = 3, FRAC = 1, TICK_W = 4, RADIX_W = 2, NEV_W = 2, TC_W = 4, SUP_W = 3, ID_W = 3, SEQ_W = 8, TIME_W = 8 }
k = 1
covers_within = 110
shorter = ["stale   <= 1'b1;\n            exempt", "stale   <= 1'b0;\n            exempt"]  # no look at lives before the first token

[[tasks]]
name = "2"
quick = true
parameters = { N = 2 }
k = 1
covers_within = 1
only = []

[[tasks]]
name = "8"
parameters = { N = 8 }
k = 1
covers_within = 1
only = []

[[tasks]]
name = "16"
parameters = { N = 16, X_W = 5, Y_W = 4, RADIX_W = 3 }
k = 1
covers_within = 1
only = []

[[tasks]]
name = "17"
parameters = { N = 17, X_W = 4, Y_W = 5, RADIX_W = 3 }
k = 1
covers_within = 1
only = []

[[faults]]
meaning = "a window that is born is not checked"
right = "m_check  <= w_checks;"
wrong = "m_check  <= w_checks && !w_born;"
breaks = ["apart"]
since = 36
within = 48

[[faults]]
meaning = "what follows a special event is not thrown out"
right = "rewind = u_ends || u_special || found || stalled;"
wrong = "rewind = u_ends || found || stalled;"
breaks = ["owner"]
since = 26
within = 40
*/
// Tokens, windows, centres, registers, the ends of lives and which of two tracks is older may be anything.
(* hierconn *) wire [N*AT_X-1:0] \u_match.f_lo_x_not ;
(* hierconn *) wire [N*AT_X-1:0] \u_match.f_hi_x ;
(* hierconn *) wire [N*AT_Y-1:0] \u_match.f_lo_y_not ;
(* hierconn *) wire [N*AT_Y-1:0] \u_match.f_hi_y ;
(* hierconn *) wire [N-1:0]      \u_match.hit_active_reg ;
(* hierconn *) wire [N-1:0]      \u_match.hit_other_reg ;
(* hierconn *) wire [N-1:0]      \u_match.free ;
(* hierconn *) wire              \u_match.any_free_reg ;
(* hierconn *) wire              \u_match.refreshes ;
(* hierconn *) wire [SLOT_W-1:0] \u_match.else_slot ;
(* hierconn *) wire [SLOT_W-1:0] \u_match.d_else_slot ;
(* hierconn *) wire [SLOT_W-1:0] \u_match.d_active_slot ;
(* hierconn *) wire [SLOT_W-1:0] \u_match.d_other_slot ;
(* hierconn *) wire [N-1:0]      \u_update.f_timed ;
(* hierconn *) wire [SLOT_W-1:0] \u_update.u_slot ;
(* hierconn *) wire              \u_update.u_takes ;
(* hierconn *) wire              \u_update.u_active ;
(* hierconn *) wire              \u_update.u_placed ;
(* hierconn *) wire              \u_update.u_last ;
(* hierconn *) wire              \u_update.u_again ;
(* hierconn *) wire              \u_update.u_report ;
(* hierconn *) wire              \u_update.u_clear ;
(* hierconn *) wire              \u_update.u_join ;
(* hierconn *) wire              \u_update.v_active ;
(* hierconn *) wire              \u_update.v_special ;
(* hierconn *) wire              \u_update.v_last ;
(* hierconn *) wire              \u_update.v_report ;
(* hierconn *) wire              \u_update.v_clear ;
(* hierconn *) wire              \u_update.v_join ;
(* hierconn *) wire              \u_update.v_places ;
(* hierconn *) wire              \u_update.v_times ;
(* hierconn *) wire              \u_update.w_old ;
(* hierconn *) wire              \u_update.w_special ;
(* hierconn *) wire              \u_update.w_last ;
(* hierconn *) wire              \u_update.w_report ;
(* hierconn *) wire              \u_update.w_clear ;
(* hierconn *) wire [1:0]        \u_update.mode ;
(* hierconn *) wire [NEV_W-1:0]  \u_update.clust_nev ;
(* hierconn *) wire [NEV_W-1:0]  \u_update.nev_min ;
(* hierconn *) wire [NEV_W-1:0]  \u_update.nev_max ;
(* hierconn *) wire [SLOT_W-1:0] \u_merge.a_slot ;
(* hierconn *) wire [SLOT_W-1:0] \u_merge.b_slot ;
(* hierconn *) wire              \u_merge.take_a_reg ;
(* hierconn *) wire              \u_merge.take_b_reg ;
(* hierconn *) wire              \u_merge.start ;
(* hierconn *) wire              \u_merge.under_way ;
(* hierconn *) wire              \u_merge.b_older ;

// ---- windows -------------------------------------------------------------------------------------------------------------

function f_share;  // whether a window and that of a slot share a pixel, as array_match.v compares them
    input [AT_X-1:0] lo_x_not, hi_x;
    input [AT_Y-1:0] lo_y_not, hi_y;
    input integer    slot;
    reg   [AT_X:0]   from_lo_x, to_hi_x;
    reg   [AT_Y:0]   from_lo_y, to_hi_y;
    begin
        from_lo_x = {1'b0, hi_x} + {1'b0, \u_match.f_lo_x_not [AT_X*slot+:AT_X]} + 1'b1;
        to_hi_x   = {1'b0, \u_match.f_hi_x [AT_X*slot+:AT_X]} + {1'b0, lo_x_not} + 1'b1;
        from_lo_y = {1'b0, hi_y} + {1'b0, \u_match.f_lo_y_not [AT_Y*slot+:AT_Y]} + 1'b1;
        to_hi_y   = {1'b0, \u_match.f_hi_y [AT_Y*slot+:AT_Y]} + {1'b0, lo_y_not} + 1'b1;
        f_share   = from_lo_x[AT_X] && to_hi_x[AT_X] && from_lo_y[AT_Y] && to_hi_y[AT_Y];
    end
endfunction

function [N-1:0] f_holders;  // the active windows that hold a pixel
    input [X_W-1:0] x;
    input [Y_W-1:0] y;
    integer i;
    for (i = 0; i < N; i = i + 1)
        f_holders[i] = active[i] && f_share({1'b0, {(AT_X - X_W - 1) {1'b1}}, ~x}, {1'b1, {(AT_X - X_W - 1) {1'b0}}, x},
                                            {1'b0, {(AT_Y - Y_W - 1) {1'b1}}, ~y}, {1'b1, {(AT_Y - Y_W - 1) {1'b0}}, y}, i);
endfunction

wire [N*N-1:0] f_shares;  // bit N i + j: those of i and j share a pixel
genvar f_i, f_j;
generate
    for (f_i = 0; f_i < N; f_i = f_i + 1) begin : g_one
        for (f_j = 0; f_j < N; f_j = f_j + 1) begin : g_other
            if (f_i < f_j)
                assign f_shares[N*f_i+f_j] = f_share(\u_match.f_lo_x_not [AT_X*f_i+:AT_X], \u_match.f_hi_x [AT_X*f_i+:AT_X],
                                                     \u_match.f_lo_y_not [AT_Y*f_i+:AT_Y], \u_match.f_hi_y [AT_Y*f_i+:AT_Y], f_j);
            else if (f_i == f_j) assign f_shares[N*f_i+f_j] = 1'b0;
            else assign f_shares[N*f_i+f_j] = f_shares[N*f_j+f_i];
        end
    end
endgenerate

function f_apart;
    input [N-1:0] among;
    integer i;
    begin
        f_apart = 1'b1;
        for (i = 0; i < N; i = i + 1) if (among[i] && |(f_shares[N*i+:N] & among)) f_apart = 1'b0;
    end
endfunction

function f_is_one;  // at most one bit is set
    input [31:0] bits;
    f_is_one = (bits & (bits - 32'd1)) == 32'd0;
endfunction

// ---- what is under way ---------------------------------------------------------------------------------------------------

wire f_d_valid = FAR != 0 && d_valid;
wire f_d_busy  = FAR != 0 && d_busy, f_d_report = FAR != 0 && d_report, f_d_clear = FAR != 0 && d_clear, f_d_join = FAR != 0 && d_join;
wire f_m_valid = m_valid && !rewound;
wire f_none    = !f_m_valid && !e_valid && !f_d_valid && !c_valid && !u_valid && !u_ends;  // no token that counts
wire w_join    = w_checks && !u_update.w_last;
wire f_reports = o_report || f_d_report || c_report || u_update.u_report || u_update.v_report || u_update.w_report;
wire f_clears  = o_clear || f_d_clear || c_clear || u_update.u_clear || u_update.v_clear || u_update.w_clear;
wire f_joins   = o_join || f_d_join || c_join || u_update.u_join || u_update.v_join || w_join;
wire f_special = u_special || u_update.v_special || u_update.w_special;
wire f_busy    = f_reports || f_clears || f_joins || u_update.v_special || u_update.w_special;
wire f_merging = ((phase == REPORT || phase == CLEAR || phase == SETTLE) && why == MERGE) || phase == JOIN;
wire f_late    = phase == FETCH && step >= 6 + FAR;  // both slots have been taken
wire [SLOT_W-1:0] c_slot = c_slots[2*SLOT_W+:SLOT_W], c_slot_rest = c_slots[SLOT_W+:SLOT_W];

// The slot of the operation that is under way.
wire [SLOT_W-1:0] f_slot = o_busy ? u_match.else_slot : f_d_busy ? u_match.d_else_slot : c_busy ? c_slot_rest
                         : u_busy ? u_update.u_slot : v_busy ? v_slot : w_slot;

// All windows but this one are apart.
wire [N-1:0] f_pending = (m_check ? FIRST << m_self : NONE) | (e_check ? FIRST << e_self : NONE)
                       | ((found || phase == FETCH || f_merging || f_joins) ? FIRST << moved : NONE);

wire [N-1:0] f_at_e = f_holders(e_x, e_y), f_at_d = f_holders(d_x, d_y), f_at_c = f_holders(c_x, c_y), f_at_u = f_holders(u_x, u_y);

reg f_merged;  // a merge is over
always @(posedge clk) f_merged <= !rst && (f_merged || w_join);

// One way to a merge, by which its cover is found: the first window is the pixel at 0, the second one is larger than the sensor.
reg f_led = 1'b1, f_second;
always @(posedge clk) begin
    f_second <= !rst && (f_second || w_born);
    f_led <= f_led && rst == !f_past && !cfg_valid && m_cm_ready && room && token_valid && token_event && !m_due
             && u_update.mode == `EVCOT_MODE_SEEDED && u_update.clust_nev == 1 && u_update.nev_min == 1 && u_update.nev_max == 1
             && token_x == (f_merged || !f_second ? 0 : 1) && token_y == 0
             && (!w_busy || {w_lo_x_not, w_hi_x, w_lo_y_not, w_hi_y} == (f_second ? {(2 * AT_X + 2 * AT_Y) {1'b1}}
                 : {1'b0, {(AT_X - 1) {1'b1}}, 1'b1, {(AT_X - 1) {1'b0}}, 1'b0, {(AT_Y - 1) {1'b1}}, 1'b1, {(AT_Y - 1) {1'b0}}}));
end

always @* if (f_past) begin
    p_apart:   assert (!(commit && (u_takes || u_passes)) || f_apart(active));
    p_owner:   assert (!(commit && (u_takes || u_passes)) || f_at_u == NONE || (u_takes && f_at_u == FIRST << u_update.u_slot));

    i_apart:   assert (f_apart(active & ~f_pending));
    i_sets:    assert ((active & u_match.free) == NONE);

    // One thing at a time.
    i_one:     assert (f_is_one({25'd0, u_special, o_busy, f_d_busy, c_busy, u_busy, v_busy, w_busy}));
    i_o:       assert (o_busy == (o_report || o_clear || o_join) && f_is_one({29'd0, o_report, o_clear, o_join}));
    i_d:       assert (f_d_busy == (f_d_report || f_d_clear || f_d_join) && f_is_one({29'd0, f_d_report, f_d_clear, f_d_join})
                       && (!f_d_busy || (!d_active && !d_other)));
    i_c:       assert (c_busy == (c_report || c_clear || c_join) && f_is_one({29'd0, c_report, c_clear, c_join}));
    i_u:       assert (u_busy == (u_update.u_report || u_update.u_clear || u_update.u_join)
                       && f_is_one({29'd0, u_update.u_report, u_update.u_clear, u_update.u_join}));
    i_v:       assert (v_busy == (u_update.v_special || u_update.v_report || u_update.v_clear || u_update.v_join)
                       && f_is_one({28'd0, u_update.v_special, u_update.v_report, u_update.v_clear, u_update.v_join})
                       && (!u_update.v_last || u_update.v_special));
    i_w:       assert (w_busy == (u_update.w_special || u_update.w_report || u_update.w_clear || w_join)
                       && f_is_one({28'd0, u_update.w_special, u_update.w_report, u_update.w_clear, w_join})
                       && (!u_update.w_last || (u_update.w_special && w_checks)));
    i_u_takes: assert ((!u_update.u_takes || (u_valid && u_takes)) && (!u_special || (u_valid && u_update.u_takes))
                       && (!u_update.u_last || u_special) && !(u_valid && u_ends));
    i_still:   assert (!f_busy || (f_none && !m_check && !e_check && !found));
    i_closed:  assert (!(o_busy || f_d_busy || c_busy || u_busy) || closed);
    i_shut:    assert ((!v_busy || closed || rewound) && (!w_busy || closed));
    i_settled: assert (!settled || !f_busy);
    i_restart: assert ((restart == NONE || restart_due) && (!restarting || (restart_due && closed)));
    i_due:     assert ((!restarting || restart != NONE || (phase == REPORT && !reports)) && (!restarts || (restart != NONE && restart_due)));
    i_begins:  assert (!restarts || (phase == RUN && f_none && closed && !f_busy && !m_check && !e_check && !found));
    i_phase:   assert (phase <= JOIN && (phase == RUN || (f_none && (closed || rewound) && !u_special && !m_check && !e_check && !found)));
    i_run:     assert (!(f_special || f_joins || w_checks) || (phase == RUN && !restarts));
    i_flight:  assert ((phase == CLEAR || !f_reports) && (phase == RUN || phase == SETTLE || !f_clears));
    i_m_check: assert (!m_check || (f_none && phase == RUN && !restarts && !e_check && !found));
    i_e_check: assert (!e_check || (!e_valid && !f_d_valid && !c_valid && !u_valid && !u_ends && phase == RUN && !restarts && !found));
    i_found:   assert (!found || (!f_d_valid && !c_valid && !u_valid && !u_ends && phase == RUN && !restarts));
    i_why:     assert ((phase < REPORT || phase == JOIN || why <= MERGE) && (phase != SETTLE || why != RESTART));

    // What a window is changed by.
    i_places:  assert ((!u_update.u_join || u_update.u_placed) && (!u_update.v_join || u_update.v_places) && (!u_update.v_last || u_update.v_places)
                       && (!w_checks || w_places) && (!w_places || w_checks || u_update.w_clear || u_update.w_special)
                       && (!u_update.v_places || u_update.v_join || u_update.v_clear || u_update.v_special));
    i_first:   assert ((!u_special || u_update.u_again) && (!(u_special && !u_update.u_last) || !u_update.u_active)
                       && (!(u_update.v_special && !u_update.v_last) || !u_update.v_active)
                       && (!(u_update.w_special && !u_update.w_last) || !u_update.w_old));
    i_new:     assert (!(u_update.u_takes && u_update.u_placed) || u_special);
    i_seeds:   assert (!c_seeds || !c_active);

    // Numbers of slots, which may have room for more.
    i_slots_d: assert (!(f_d_valid && d_event) || (d_active ? u_match.d_active_slot < N : !d_other || u_match.d_other_slot < N));
    i_slots:   assert ((!(c_valid && c_takes) || c_slot < N) && (!u_update.u_takes || u_update.u_slot < N) && (!u_update.v_special || v_slot < N)
                       && (!(u_update.w_special || w_checks) || w_slot < N) && (!m_check || m_self < N) && (!e_check || e_self < N)
                       && (!(found || phase == FETCH || f_merging || f_joins) || (moved < N && found_slot < N)));

    // The windows that are checked.
    i_probe:   assert (!m_check || (active[m_self] && m_lo_x_not == u_match.f_lo_x_not[AT_X*m_self+:AT_X] && m_hi_x == u_match.f_hi_x[AT_X*m_self+:AT_X]
                       && m_lo_y_not == u_match.f_lo_y_not[AT_Y*m_self+:AT_Y] && m_hi_y == u_match.f_hi_y[AT_Y*m_self+:AT_Y]));
    i_result:  assert (!e_check || (active[e_self] && u_match.hit_other_reg == (f_shares[N*e_self+:N] & active)));
    i_both:    assert (!(found || phase == FETCH) || (active[moved] && active[found_slot]));
    i_differ:  assert (!(found || phase == FETCH || f_merging || f_joins) || moved != found_slot);

    // The owner of an event.
    i_at_m:    assert (!f_m_valid || (m_lo_x_not == {1'b0, {(AT_X - X_W - 1) {1'b1}}, ~m_hi_x[X_W-1:0]} && m_hi_x[AT_X-1:X_W] == {1'b1, {(AT_X - X_W - 1) {1'b0}}}
                       && m_lo_y_not == {1'b0, {(AT_Y - Y_W - 1) {1'b1}}, ~m_hi_y[Y_W-1:0]} && m_hi_y[AT_Y-1:Y_W] == {1'b1, {(AT_Y - Y_W - 1) {1'b0}}}));
    i_at_e:    assert (!(e_valid && e_event) || u_match.hit_active_reg == f_at_e);
    i_at_d:    assert (!(f_d_valid && d_event) || (d_active ? f_at_d == FIRST << u_match.d_active_slot : f_at_d == NONE));
    i_at_c:    assert (!(c_valid && (c_takes || c_passes)) || (c_active ? c_takes && f_at_c == FIRST << c_slot : f_at_c == NONE));
    i_at_u:    assert (!(u_valid && (u_takes || u_passes)) || (u_update.u_active ? u_takes && f_at_u == FIRST << u_update.u_slot : f_at_u == NONE));
    i_copies:  assert (!(c_valid || c_busy) || c_slot == c_slot_rest);

    // A free slot has no deadline, so that its first event is special.
    i_else:    assert (u_match.refreshes || (u_match.any_free_reg == |u_match.free && (!u_match.any_free_reg || (u_match.else_slot < N && u_match.free[u_match.else_slot]))));
    i_fresh:   assert (!e_valid || !u_match.refreshes);
    i_else_d:  assert (!(f_d_valid && d_event && d_free && !d_active && !d_other) || (u_match.d_else_slot < N && u_match.free[u_match.d_else_slot]));
    i_else_c:  assert (!(c_valid && c_takes && c_seeds) || u_match.free[c_slot]);
    i_free:    assert ((u_match.free & u_update.f_timed & ~(u_update.w_special ? FIRST << w_slot : NONE)) == NONE);
    i_cleared: assert ((!u_update.w_clear || !u_update.f_timed[w_slot]) && (!u_update.v_clear || u_update.v_times) && (!u_update.v_report || !u_update.v_times));
    i_quiet:   assert (!w_busy || !u_update.v_times);
    i_times:   assert (!(u_update.v_times && !u_update.v_clear && !v_busy) || !u_match.free[v_slot]);

    // Two that merge.
    i_hits:    assert (!((phase == FETCH && step != 0) || phase == REPORT || phase == CLEAR || phase == SETTLE || phase == JOIN || o_busy)
                       || (u_match.hit_active_reg == NONE && u_match.hit_other_reg == NONE));
    i_step:    assert (phase != FETCH || step <= 8 + FAR);
    i_slow:    assert ((phase != FETCH || slow_slot == (step == 0 ? moved : found_slot))
                       && (!(f_merging && phase != JOIN) || slow_slot == goes) && (phase != JOIN || slow_slot == stays));
    i_reads:   assert (phase != FETCH || ((step < 1 || u_match.else_slot == (step == 1 ? moved : found_slot))
                       && (FAR == 0 || step < 2 || (!d_active && !d_other && u_match.d_else_slot == (step == 2 ? moved : found_slot)))
                       && (step < 2 + FAR || c_slot_rest == (step == 2 + FAR ? moved : found_slot))
                       && (step < 3 + FAR || u_update.u_slot == (step == 3 + FAR ? moved : found_slot))
                       && (step < 4 + FAR || v_slot == (step == 4 + FAR ? moved : found_slot))
                       && (step < 5 + FAR || u_merge.a_slot == moved)));
    i_take:    assert (phase != FETCH || (take_a == (step == 3 + FAR) && take_b == (step == 4 + FAR)
                       && (step < 1 || (u_merge.take_a_reg == (step == 4 + FAR) && u_merge.take_b_reg == (step == 5 + FAR)))
                       && (step < 2 || u_merge.start == (step == 6 + FAR)) && ((step != 6 + FAR && step != 7 + FAR) || u_merge.under_way)));
    i_taken:   assert (!(f_merging || f_joins) || {take_a, take_b, u_merge.take_a_reg, u_merge.take_b_reg, u_merge.start} == 5'd0);
    i_order:   assert (!(f_late || f_merging || f_joins) || (u_merge.a_slot == moved && u_merge.b_slot == found_slot));
    i_stays:   assert (!((phase == FETCH && step == 8 + FAR) || f_merging || f_joins)
                       || (stays == (u_merge.b_older ? u_merge.b_slot : u_merge.a_slot) && goes == (u_merge.b_older ? u_merge.a_slot : u_merge.b_slot)));
    i_alive:   assert (!(f_merging || f_joins) || active[stays]);
    i_clears:  assert (!(phase == SETTLE && why == MERGE) || (f_clears ? f_slot == goes : !active[goes]));
    i_gone:    assert (!(phase == JOIN || f_joins) || !active[goes]);
    i_joins:   assert (!f_joins || f_slot == stays);

    c_apart:   cover (commit && u_takes && f_merged && f_led);
    c_owner:   cover (commit && u_takes && f_at_u != NONE && f_led);
end
