// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*cot_axis*", "t:*cot_regs*"]

[properties]
states = "the FSM takes the transitions of the paper only"
once = "an accepted event leaves at one output, owned or passed, and not twice"
lost = "the next token is accepted only when event and ticks of the one before have left"
ticks = "the ticks of a token travel on once, whoever owns its event"
fields = "a passed event keeps address, polarity and number, an owned one polarity and number"
time = "the tracker's time is the sum of all ticks that came"
stable = "an output that is not taken stays"
limits = "with legal registers that stay, g, N_ev and the count keep their limits"
alive = "no event is decided by a cluster whose last event is max_ticks ago or more, if registers are legal and stay"
dead = "a LOST record has the time of the last owned event plus max_ticks, if registers stay and mode was not written"

[[tasks]]
name = "default"
parameters = { X_W = 9, Y_W = 9, FRAC = 4, TICK_W = 20, RADIX_W = 8, NEV_W = 10, TC_W = 24, SUP_W = 16, ID_W = 32, SEQ_W = 48, TIME_W = 48 }
k = 5
covers_within = 24
only = ["states", "once", "lost", "ticks", "fields", "time", "stable"]
quick = true

[[tasks]]
name = "covers"
parameters = { TICK_W = 4, RADIX_W = 3, NEV_W = 3, TC_W = 4, SUP_W = 4, ID_W = 4, SEQ_W = 8, TIME_W = 8 }
k = 5
covers_within = 16
quick = true

[[tasks]]
name = "bits"
parameters = { X_W = 1, Y_W = 1, FRAC = 0, TICK_W = 1, RADIX_W = 1, NEV_W = 1, TC_W = 1, SUP_W = 1, ID_W = 1, SEQ_W = 8, TIME_W = 8 }
k = 5
covers_within = 24
only = ["states", "once", "lost", "ticks", "fields", "time", "stable"]

[[tasks]]
name = "long_ticks"
parameters = { X_W = 11, Y_W = 11, TICK_W = 32, RADIX_W = 12, NEV_W = 16, TC_W = 32, SUP_W = 32, ID_W = 32, SEQ_W = 48, TIME_W = 48 }
k = 5
covers_within = 24
only = ["states", "once", "lost", "ticks", "fields", "time", "stable"]

[[tasks]]
name = "short_timers"
parameters = { TICK_W = 32, TC_W = 2 }
k = 5
covers_within = 24
only = ["states", "once", "lost", "ticks", "fields", "time", "stable"]

[[faults]]
task = "covers"
meaning = "a passed token restarts the tracker"
right = "`EVCOT_ST_EV_PASS_TH: state <= `EVCOT_ST_IDLE;"
wrong = "`EVCOT_ST_EV_PASS_TH: state <= `EVCOT_ST_INIT_CELL;"
breaks = ["states"]
within = 14

[[faults]]
task = "covers"
meaning = "an owned event is passed on, too"
right = "pass_event <= token_event && !owned;"
wrong = "pass_event <= token_event;"
breaks = ["once"]
within = 14

[[faults]]
task = "covers"
meaning = "an owned event is not offered with its ticks"
right = "own_pending  <= 1'b1;"
wrong = "own_pending  <= token_tick == {TICK_W{1'b0}};"
breaks = ["lost"]
within = 14

[[faults]]
task = "covers"
meaning = "the ticks of an owned event stay"
right = "pass_pending <= token_tick != {TICK_W{1'b0}};"
wrong = "pass_pending <= 1'b0;"
breaks = ["lost"]
within = 14

[[faults]]
task = "covers"
meaning = "ticks travel on without the event only"
right = "m_pass_tick  = token_tick;"
wrong = "m_pass_tick  = pass_event ? {TICK_W{1'b0}} : token_tick;"
breaks = ["ticks"]
within = 14

[[faults]]
task = "covers"
meaning = "the number of the event that comes goes out"
right = "m_own_seq    = token_seq;"
wrong = "m_own_seq    = s_seq;"
breaks = ["fields", "stable"]
within = 14

[[faults]]
task = "covers"
meaning = "ticks that end a life count twice"
right = "if (!held) now <="
wrong = "now <="
breaks = ["time"]
within = 22

[[faults]]
task = "covers"
meaning = "a record is withdrawn"
right = "if (m_cm_ready) cm_pending"
wrong = "if (m_cm_ready || s_valid) cm_pending"
breaks = ["stable"]
within = 22

[[faults]]
task = "covers"
meaning = "the radius goes below its limit"
right = "({1'b0, g} < lowest) ? radix_min :"
wrong = "({1'b0, g} < 1) ? radix_min :"
breaks = ["limits"]
within = 22

[[faults]]
task = "covers"
meaning = "N_ev goes above its limit"
right = "({1'b0, nev_max} < doubled) ? nev_max :"
wrong = "({1'b0, nev_max} < halved) ? nev_max :"
breaks = ["limits"]
within = 34

[[faults]]
task = "covers"
meaning = "a cluster lives a tick too long"
right = "{1'b1, ~timer, !active};"
wrong = "{1'b1, ~timer, 1'b1};"
breaks = ["alive", "dead"]
within = 26

[[faults]]
task = "covers"
meaning = "a loss has the time of the token that ends it"
right = "cm_time    <= deadline[TIME_W:1];"
wrong = "cm_time    <= now;"
breaks = ["dead"]
within = 26
*/
// The axes, and so whether an event lies inside, may do anything. So may the registers, unless f_fixed is chosen: then they are legal and
// stay, and sizes and times have their limits.
(* anyconst *) wire f_fixed;
localparam F_REGS_W = 5 * RADIX_W + 3 * TC_W + 3 * NEV_W;
wire [F_REGS_W-1:0] f_regs = {init_radix, radix_th, radix_step, radix_min, radix_max, max_ticks, nev_th, detect_ticks, clust_nev, nev_min, nev_max};
reg  [F_REGS_W-1:0] f_were;
always @(posedge clk) f_were <= f_regs;
always @* if (f_fixed) begin
    assume (!f_past || f_were == f_regs);
    assume (radix_min <= init_radix && init_radix <= radix_max);
    assume (max_ticks != 0 && nev_min != 0 && nev_min <= clust_nev && clust_nev <= nev_max);
end

wire f_in   = s_valid && s_ready;
wire f_own  = m_own_valid && m_own_ready;
wire f_pass = m_pass_valid && m_pass_ready;

// What the token that was accepted last has not yet delivered.
reg f_event, f_ticks;
reg [TICK_W-1:0] f_tick;
reg [X_W+Y_W+SEQ_W:0] f_token;
reg [TIME_W-1:0] f_time, f_last;  // of all ticks that came; of the last owned event
reg [`EVCOT_ST_W-1:0] f_was;
reg f_began, f_restarts, f_own_waits, f_pass_waits, f_cm_waits;
reg [RADIX_W*2+SEQ_W+4:0] f_own_was;
reg [TICK_W+X_W+Y_W+SEQ_W+1:0] f_pass_was;
wire [RADIX_W*2+SEQ_W+4:0] f_own_now = {m_own_x, m_own_y, m_own_p, m_own_seq};
wire [TICK_W+X_W+Y_W+SEQ_W+1:0] f_pass_now = {m_pass_tick, m_pass_event, m_pass_x, m_pass_y, m_pass_p, m_pass_seq};
reg [2+ID_W+NEV_W+SUP_W+SEQ_W+TIME_W-1:0] f_cm_was;
wire [2+ID_W+NEV_W+SUP_W+SEQ_W+TIME_W-1:0] f_cm_now = {m_cm_kind, m_cm_id, m_cm_n_ev, m_cm_support, m_cm_seq, m_cm_time};
always @(posedge clk) begin
    f_was   <= state;
    f_began <= rst;
    {f_own_waits, f_pass_waits, f_cm_waits} <= {m_own_valid && !m_own_ready, m_pass_valid && !m_pass_ready, m_cm_valid && !m_cm_ready};
    {f_own_was, f_pass_was, f_cm_was} <= {f_own_now, f_pass_now, f_cm_now};
    if (f_own || (f_pass && m_pass_event)) f_event <= 1'b0;
    if (f_pass) f_ticks <= 1'b0;
    if (f_in) begin
        f_event <= s_event;
        f_ticks <= s_tick != {TICK_W{1'b0}};
        f_tick  <= s_tick;
        f_token <= {s_x, s_y, s_p, s_seq};
        f_time  <= f_time + {{(TIME_W - TICK_W) {1'b0}}, s_tick};
    end
    if (takes) f_last <= now;
    if (state == `EVCOT_ST_IDLE && waits) f_restarts <= restart;
    else if (state == `EVCOT_ST_EV_DISCRI) f_restarts <= 1'b0;
    if (rst) begin
        {f_event, f_ticks} <= 2'b00;
        {f_own_waits, f_pass_waits, f_cm_waits} <= 3'b000;
        f_time <= {TIME_W{1'b0}};
    end
end

wire f_undecided = state == `EVCOT_ST_EV_DISCRI || held;
wire f_decides = state == `EVCOT_ST_EV_DISCRI && !expired && !held;
wire [TIME_W-1:0] f_age  = now + {{(TIME_W - TICK_W) {1'b0}}, token_tick} - f_last;  // of the last owned event, at the token being decided
wire [TIME_W-1:0] f_idle = now - f_last;
reg f_legal;
always @* case (f_was)
    `EVCOT_ST_INIT_CELL:  f_legal = state == `EVCOT_ST_INIT_CELL || state == `EVCOT_ST_IDLE;
    `EVCOT_ST_IDLE:       f_legal = state == `EVCOT_ST_IDLE || state == `EVCOT_ST_INIT_CELL || state == `EVCOT_ST_EV_DISCRI;
    `EVCOT_ST_EV_DISCRI:  f_legal = state == `EVCOT_ST_INIT_CELL || state == `EVCOT_ST_EV_PASS_TH || state == `EVCOT_ST_EV_NO_PROC || state == `EVCOT_ST_EV_PROC;
    `EVCOT_ST_EV_PASS_TH: f_legal = state == `EVCOT_ST_IDLE;
    `EVCOT_ST_EV_NO_PROC: f_legal = state == `EVCOT_ST_IDLE;
    `EVCOT_ST_EV_PROC:    f_legal = state == `EVCOT_ST_IDLE || (state == `EVCOT_ST_EV_PROC && updated);
    default:              f_legal = 1'b0;
endcase

always @* if (f_past) begin
    p_states: assert (f_began ? state == `EVCOT_ST_INIT_CELL : f_legal);
    p_once:   assert ((!m_own_valid || f_event) && (!(m_pass_valid && m_pass_event) || f_event) && !(m_own_valid && m_pass_valid && m_pass_event));
    p_lost:   assert (!s_ready || !(f_event || f_ticks));
    p_ticks:  assert (!m_pass_valid || (m_pass_tick == f_tick && (m_pass_event || f_ticks)));
    p_fields: assert ((!(m_pass_valid && m_pass_event) || {m_pass_x, m_pass_y, m_pass_p, m_pass_seq} == f_token)
                   && (!m_own_valid || {m_own_p, m_own_seq} == f_token[SEQ_W:0]));
    p_time:   assert ((f_undecided && !held ? now + {{(TIME_W - TICK_W) {1'b0}}, token_tick} : now) == f_time);
    p_stable: assert ((!f_own_waits || (m_own_valid && f_own_now == f_own_was)) && (!f_pass_waits || (m_pass_valid && f_pass_now == f_pass_was))
                   && (!f_cm_waits || (m_cm_valid && f_cm_now == f_cm_was)));
    p_limits: assert (!f_fixed || state == `EVCOT_ST_INIT_CELL || (radix_min <= g && g <= radix_max && nev_min <= n_ev && n_ev <= nev_max && count < n_ev));
    p_alive:  assert (!(f_fixed && f_decides && collecting && active) || f_age < max_ticks);
    p_dead:   assert (!(f_fixed && m_cm_valid && m_cm_kind == `EVCOT_KIND_LOST && !f_restarts) || m_cm_time == f_last + max_ticks);
    i_token:  assert (f_undecided ? !own_pending && !pass_pending && f_event == token_event && f_ticks == (token_tick != 0)
                                  : f_event == (own_pending || (pass_pending && pass_event)) && f_ticks == (pass_pending && token_tick != 0));
    i_ticks:  assert (!(f_event || f_ticks) || (token_tick == f_tick && {token_x, token_y, token_p, token_seq} == f_token));
    i_some:   assert (!f_undecided || token_event || token_tick != 0);
    i_over:   assert (!held || state == `EVCOT_ST_INIT_CELL || (!collecting && !active && !cm_pending));
    i_cm:     assert (!cm_pending || state == `EVCOT_ST_IDLE || state == `EVCOT_ST_INIT_CELL);
    i_held:   assert (!held || state == `EVCOT_ST_INIT_CELL || state == `EVCOT_ST_IDLE || state == `EVCOT_ST_EV_DISCRI);
    i_pend:   assert (!(own_pending && pass_pending) || !pass_event);
    i_expire: assert (!expired || (state == `EVCOT_ST_EV_DISCRI && !held && collecting) || !f_fixed);
    i_init:   assert (state != `EVCOT_ST_INIT_CELL || f_undecided || (!own_pending && !pass_pending));
    i_time:   assert (!(f_fixed && collecting && active) || state == `EVCOT_ST_EV_NO_PROC || state == `EVCOT_ST_EV_PROC || state == `EVCOT_ST_INIT_CELL
                      || ({{(TIME_W - TC_W) {1'b0}}, tc} == f_idle && tc < max_ticks));
    c_states: cover (f_was == `EVCOT_ST_EV_DISCRI && state == `EVCOT_ST_INIT_CELL);
    c_once:   cover (m_own_valid && m_pass_valid);
    c_lost:   cover (s_ready && f_time != 0);
    c_ticks:  cover (m_pass_valid && !m_pass_event);
    c_fields: cover (m_pass_valid && m_pass_event && f_pass_waits);
    c_time:   cover (held && now != 0);
    c_stable: cover (f_own_waits && f_cm_waits);
    c_limits: cover (f_fixed && count != 0 && active);
    c_alive:  cover (f_fixed && f_decides && collecting && active && f_age == max_ticks - 1 && max_ticks > 2);
    c_dead:   cover (f_fixed && m_cm_valid && m_cm_kind == `EVCOT_KIND_LOST && !f_restarts && max_ticks > 1);
end
