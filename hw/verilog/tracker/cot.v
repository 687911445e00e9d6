// SPDX-License-Identifier: Apache-2.0
// Cluster Object Tracker: follows one cluster of events with the six-state FSM of the paper.
//
// Input: tokens in order. A token first advances the time by s_tick ticks and then, if s_event is 1, carries an event. The
// output depends on the order of tokens alone, never on when they are accepted.
// Outputs: the centre-of-mass stream (births, moves, losses), the owned events with their address in the window, and the
// pass-through of everything else. Time travels down the pass-through port in order with the events: an event that is owned
// here leaves its ticks there as a token without event.
//
// Latency:    unstalled, from the clock edge that takes the event: passed or owned event out after 2 clocks, centre out after 4.
// Throughput: a token every 3 clocks, every 5 at a centre update; 3 or 4 more where it ends a life.
// Stall:      every output is held until accepted. The FSM waits for all of them in IDLE, before it takes another token.
// Reset:      turns the tracker off.
// Registers:  a write takes effect on the next token; s_ready is low in the clock after a write. A life that ends because
//             its timer was shortened is reported when the next event enters the row of trackers (s_valid, or a change of next_seq).
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

module cot #(
    parameter X_W      = 9,   // bits of an x address
    parameter Y_W      = 9,   // bits of a y address
    parameter FRAC     = 4,   // fractional bits of a centre and of an average
    parameter TICK_W   = 20,  // bits of the tick input
    parameter RADIX_W  = 8,   // bits of a radius register
    parameter NEV_W    = 10,  // bits of N_ev
    parameter TC_W     = 24,  // bits of a timer
    parameter SUP_W    = 16,  // bits of a support count
    parameter ID_W     = 32,  // bits of a track id
    parameter SEQ_W    = 48,  // bits of an event's sequence number
    parameter TIME_W   = 48,  // bits of the tick count
    parameter ID_FIRST = 0,   // id of the first track
    parameter ID_STEP  = 1    // distance between ids, so that trackers in a chain share no id
) (
    input  wire                clk,
    input  wire                rst,

    // registers: see cot_regs.v
    input  wire                cfg_valid,
    input  wire [`EVCOT_REG_W-1:0] cfg_addr,
    input  wire [31:0]         cfg_data,

    // tokens
    input  wire                s_valid,
    output wire                s_ready,
    input  wire [TICK_W-1:0]   s_tick,
    input  wire                s_event,
    input  wire [X_W-1:0]      s_x,
    input  wire [Y_W-1:0]      s_y,
    input  wire                s_p,
    input  wire [SEQ_W-1:0]    s_seq,   // number of this event, or of the next one where there is none
    input  wire [SEQ_W-1:0]    next_seq,  // at any time: number of the next event to enter the row of trackers

    // centre of mass: one record per birth, move and loss
    output wire                m_cm_valid,
    input  wire                m_cm_ready,
    output wire [1:0]          m_cm_kind,
    output wire [ID_W-1:0]     m_cm_id,
    output wire [X_W+FRAC-1:0] m_cm_x,
    output wire [Y_W+FRAC-1:0] m_cm_y,
    output wire [RADIX_W:0]    m_cm_radius,
    output wire [NEV_W-1:0]    m_cm_n_ev,
    output wire [SUP_W-1:0]    m_cm_support,
    output wire [SEQ_W-1:0]    m_cm_seq,
    output wire [TIME_W-1:0]   m_cm_time,

    // owned events, addressed within the window
    output wire                m_own_valid,
    input  wire                m_own_ready,
    output wire [RADIX_W+1:0]  m_own_x,
    output wire [RADIX_W+1:0]  m_own_y,
    output wire                m_own_p,
    output wire [SEQ_W-1:0]    m_own_seq,

    // pass-through: tokens for the next tracker
    output wire                m_pass_valid,
    input  wire                m_pass_ready,
    output wire [TICK_W-1:0]   m_pass_tick,
    output wire                m_pass_event,
    output wire [X_W-1:0]      m_pass_x,
    output wire [Y_W-1:0]      m_pass_y,
    output wire                m_pass_p,
    output wire [SEQ_W-1:0]    m_pass_seq,

    output wire                idle     // nothing inside, no register write under way
);

    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(RADIX_W >= `EVCOT_RADIX_W_MIN && RADIX_W <= `EVCOT_RADIX_W_MAX)) RADIX_W_must_be_1_to_12 ();
    parameter_check #(.OK(NEV_W >= `EVCOT_NEV_W_MIN && NEV_W <= `EVCOT_NEV_W_MAX)) NEV_W_must_be_1_to_16 ();
    parameter_check #(.OK(TC_W >= `EVCOT_TC_W_MIN && TC_W <= `EVCOT_TC_W_MAX)) TC_W_must_be_1_to_32 ();
    parameter_check #(.OK(SUP_W >= `EVCOT_SUP_W_MIN && SUP_W <= `EVCOT_SUP_W_MAX)) SUP_W_must_be_1_to_32 ();
    parameter_check #(.OK(ID_W >= `EVCOT_ID_W_MIN && ID_W <= `EVCOT_ID_W_MAX)) ID_W_must_be_1_to_32 ();
    parameter_check #(.OK(SEQ_W >= `EVCOT_SEQ_W_MIN && SEQ_W <= `EVCOT_SEQ_W_MAX)) SEQ_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= `EVCOT_TIME_W_MIN && TIME_W <= `EVCOT_TIME_W_MAX)) TIME_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= TC_W + NEV_W)) TIME_W_must_be_at_least_TC_W_plus_NEV_W ();
    parameter_check #(.OK(TIME_W >= TICK_W)) TIME_W_must_be_at_least_TICK_W ();

    localparam SUM_W = (TC_W > TICK_W ? TC_W : TICK_W) + 1;  // a timer plus a tick

    // ---- registers -------------------------------------------------------------------------------------------------

    wire [1:0]         mode;
    wire [X_W-1:0]     init_cm_x;
    wire [Y_W-1:0]     init_cm_y;
    wire [RADIX_W-1:0] init_radix, radix_th, radix_step, radix_min, radix_max;
    wire [3:0]         hist_avg;
    wire [TC_W-1:0]    max_ticks, nev_th, detect_ticks;
    wire [NEV_W-1:0]   clust_nev, nev_min, nev_max;

    cot_regs #(
        .N      (1),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .RADIX_W(RADIX_W),
        .NEV_W  (NEV_W),
        .TC_W   (TC_W),
        .SLOT_W (1)
    ) u_regs (
        .clk         (clk),
        .rst         (rst),
        .cfg_valid   (cfg_valid),
        .cfg_slot    (1'b0),
        .cfg_addr    (cfg_addr),
        .cfg_data    (cfg_data),
        .slot        (1'b0),
        .late_slot   (1'b0),
        .mode        (mode),
        .init_cm_x   (init_cm_x),
        .init_cm_y   (init_cm_y),
        .init_radix  (init_radix),
        .radix_th    (radix_th),
        .radix_step  (radix_step),
        .radix_min   (radix_min),
        .radix_max   (radix_max),
        .hist_avg    (hist_avg),
        .max_ticks   (max_ticks),
        .clust_nev   (clust_nev),
        .nev_min     (nev_min),
        .nev_max     (nev_max),
        .nev_th      (nev_th),
        .detect_ticks(detect_ticks)
    );

    // ---- state -----------------------------------------------------------------------------------------------------

    reg [`EVCOT_ST_W-1:0] state;
    reg                   restart;    // mode was written: INIT_CELL at the next opportunity

    reg                   active;     // visible; else a candidate
    reg                   collecting; // a life has begun: its first event is counted in
    wire [X_W+FRAC-1:0]   cm_x, av_x;
    wire [Y_W+FRAC-1:0]   cm_y, av_y;
    reg [RADIX_W-1:0]     g;
    reg                   ring;
    reg [NEV_W-1:0]       n_ev, count;
    // What these mean for the next event, a clock later.
    reg                   free;       // it starts a life wherever it is
    reg                   has_window; // it may lie inside
    reg                   last;       // it moves the centre
    reg [SUP_W-1:0]       support;
    reg [ID_W-1:0]        id, next_id;

    reg [TIME_W-1:0]      now;        // ticks since reset
    reg [TC_W-1:0]        tc;         // ticks since the last owned event
    reg [TC_W-1:0]        tc2;        // ticks since the window of N_ev events began
    reg [TC_W-1:0]        last_tc2;   // what TC2 reached in the window before

    // the token being decided
    reg                   expired;    // its ticks end the life
    reg                   held;       // until that is over
    reg [TICK_W-1:0]      token_tick;
    reg                   token_event;
    reg [X_W-1:0]         token_x;
    reg [Y_W-1:0]         token_y;
    reg                   token_p;
    reg [SEQ_W-1:0]       token_seq;

    // outputs not yet taken
    reg                   cm_pending, own_pending, pass_pending;
    reg                   pass_event; // the token's event has no owner here
    reg                   updated;    // it has been counted in
    reg [1:0]             cm_kind;
    reg [SEQ_W-1:0]       cm_seq;
    reg [TIME_W-1:0]      cm_time;
    reg [RADIX_W+1:0]     own_x, own_y;

    wire begins = state == `EVCOT_ST_EV_DISCRI && token_event;
    wire takes  = state == `EVCOT_ST_EV_NO_PROC || (state == `EVCOT_ST_EV_PROC && !updated);
    wire moves  = state == `EVCOT_ST_EV_PROC && updated;
    wire waits  = state == `EVCOT_ST_IDLE && !cm_pending && !own_pending && !pass_pending;

    // ---- centre, average and window --------------------------------------------------------------------------------

    wire               hit_x, hit_y, ring_x, ring_y;
    wire [RADIX_W+1:0] rel_x, rel_y;
    wire [RADIX_W:0]   radius = {1'b0, g} + {1'b0, radix_th};
    reg  [RADIX_W:0]   radius_reg;

    wire placed = state == `EVCOT_ST_INIT_CELL && !cm_pending;
    wire seeds  = begins && free;

    cot_axis #(
        .W      (X_W),
        .FRAC   (FRAC),
        .RADIX_W(RADIX_W)
    ) u_x (
        .clk   (clk),
        .place (placed || seeds),
        .at    (seeds ? token_x : init_cm_x),
        .token (token_x),
        .begins(begins),
        .seeds (free),
        .takes (takes),
        .moves (moves),
        .g     (g),
        .radius(radius),
        .k     (hist_avg),
        .cm    (cm_x),
        .av    (av_x),
        .hit   (hit_x),
        .rel   (rel_x),
        .ring  (ring_x)
    );
    cot_axis #(
        .W      (Y_W),
        .FRAC   (FRAC),
        .RADIX_W(RADIX_W)
    ) u_y (
        .clk   (clk),
        .place (placed || seeds),
        .at    (seeds ? token_y : init_cm_y),
        .token (token_y),
        .begins(begins),
        .seeds (free),
        .takes (takes),
        .moves (moves),
        .g     (g),
        .radius(radius),
        .k     (hist_avg),
        .cm    (cm_y),
        .av    (av_y),
        .hit   (hit_y),
        .rel   (rel_y),
        .ring  (ring_y)
    );

    wire inside_window = has_window && hit_x && hit_y;
    wire owned = inside_window || free;  // if there is an event

    // ---- time ------------------------------------------------------------------------------------------------------

    wire [SUM_W-1:0] tc_after  = {{(SUM_W - TC_W) {1'b0}}, tc} + {{(SUM_W - TICK_W) {1'b0}}, token_tick};
    wire [SUM_W-1:0] tc2_after = {{(SUM_W - TC_W) {1'b0}}, tc2} + {{(SUM_W - TICK_W) {1'b0}}, token_tick};

    // How many ticks the life outlasts, formed a clock after what they depend on. A cluster's ends max_ticks after its last event, a
    // candidate's at the tick after detect_ticks. A life is due without a further tick only where a write has shortened it.
    reg  [TC_W:0]    left;       // signed
    reg              written;    // a register, in the clock before
    reg  [SEQ_W-1:0] write_seq;  // the next event then
    reg              entered;    // it has entered the row
    wire [TC_W-1:0]  limit     = active ? max_ticks : detect_ticks;
    wire [TC_W-1:0]  timer     = active ? tc & {TC_W{!takes}} : tc2;
    wire [TC_W+1:0]  left_next = {1'b0, limit, 1'b1} + {1'b1, ~timer, !active};

    wire due     = collecting && left[TC_W];
    wire passes  = {{(SUM_W - TC_W) {1'b0}}, left[TC_W-1:0]} < {{(SUM_W - TICK_W) {1'b0}}, s_tick};

    wire [TIME_W:0] deadline = {now, 1'b1} + {{(TIME_W - TC_W - 1) {left[TC_W]}}, left, 1'b1};

    // ---- arithmetic: sizes are compared by <, which takes the carry chain alone ------------------------------------

    wire [NEV_W:0] next_count = {1'b0, count} + 1'b1;

    wire [RADIX_W:0] grown  = {1'b0, g} + {1'b0, radix_step};
    wire [RADIX_W:0] lowest = {1'b0, radix_min} + {1'b0, radix_step};
    wire [NEV_W:0]   doubled = {n_ev, 1'b0};
    wire [NEV_W-1:0] halved  = n_ev >> 1;

    reg slower, faster;  // than the window before by more than nev_th, whose first has none before it

    wire unused = &{1'b0, av_x, av_y, left_next[0], deadline[0]};

    // ---- outputs ---------------------------------------------------------------------------------------------------

    assign s_ready      = waits && !restart && !written && !held && !due;
    assign idle         = waits && !restart && !written && !held;

    assign m_cm_valid   = cm_pending;
    assign m_cm_kind    = cm_kind;
    assign m_cm_id      = id;
    assign m_cm_x       = cm_x;
    assign m_cm_y       = cm_y;
    assign m_cm_radius  = radius;
    assign m_cm_n_ev    = n_ev;
    assign m_cm_support = support;
    assign m_cm_seq     = cm_seq;
    assign m_cm_time    = cm_time;

    assign m_own_valid  = own_pending;
    assign m_own_x      = own_x;
    assign m_own_y      = own_y;
    assign m_own_p      = token_p;
    assign m_own_seq    = token_seq;

    assign m_pass_valid = pass_pending;
    assign m_pass_tick  = token_tick;
    assign m_pass_event = pass_event;
    assign m_pass_x     = token_x;
    assign m_pass_y     = token_y;
    assign m_pass_p     = token_p;
    assign m_pass_seq   = token_seq;

    // ---- FSM -------------------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        radius_reg <= radius;
        free       <= mode == `EVCOT_MODE_SEEDED && !collecting;
        has_window <= mode == `EVCOT_MODE_FIXED || collecting;
        last       <= !(next_count < {1'b0, n_ev});
        left       <= left_next[TC_W+1:1];
        slower     <= active && {1'b0, last_tc2} + {1'b0, nev_th} < {1'b0, tc2};
        faster     <= active && {1'b0, tc2} + {1'b0, nev_th} < {1'b0, last_tc2};

        if (m_cm_ready) cm_pending <= 1'b0;
        if (m_own_ready) own_pending <= 1'b0;
        if (m_pass_ready) pass_pending <= 1'b0;

        if (takes) begin
            collecting <= 1'b1;
            tc         <= {TC_W{1'b0}};
        end

        case (state)
            // Waits until the record of a life's end has been taken, then loads the registers. What no record holds is cleared at once.
            `EVCOT_ST_INIT_CELL: begin
                active     <= 1'b0;
                collecting <= 1'b0;
                ring       <= 1'b0;
                count      <= {NEV_W{1'b0}};
                tc         <= {TC_W{1'b0}};
                tc2        <= {TC_W{1'b0}};
                if (!cm_pending) begin
                    g       <= init_radix;
                    n_ev    <= clust_nev;
                    support <= {SUP_W{1'b0}};
                    state   <= `EVCOT_ST_IDLE;
                end
            end

            // Offers what the last token has left until it is taken, then waits for the next one.
            `EVCOT_ST_IDLE: begin
                if (s_ready && s_valid) begin
                    expired     <= collecting && passes;
                    token_tick  <= s_tick;
                    token_event <= s_event;
                    token_x     <= s_x;
                    token_y     <= s_y;
                    token_p     <= s_p;
                    token_seq   <= s_seq;
                end
                if (waits && (restart || due)) begin
                    cm_kind <= `EVCOT_KIND_LOST;
                    cm_seq  <= write_seq;
                    cm_time <= restart ? now : deadline[TIME_W:1];
                end
                if (waits && (restart || (due && !written && (s_valid || entered)))) begin
                    restart    <= 1'b0;
                    cm_pending <= active;
                    state      <= `EVCOT_ST_INIT_CELL;
                end else if ((held && !written) || (s_ready && s_valid && (s_event || s_tick != {TICK_W{1'b0}}))) begin
                    state <= `EVCOT_ST_EV_DISCRI;
                end
            end

            // Counts the ticks. If they end a life, holds the token until that is over. Is its event inside or outside? A free seeded
            // tracker starts at the event.
            `EVCOT_ST_EV_DISCRI: begin
                if (!held) now <= now + {{(TIME_W - TICK_W) {1'b0}}, token_tick};
                if (collecting) begin
                    tc  <= (tc_after[SUM_W-1:TC_W] != {(SUM_W - TC_W) {1'b0}}) ? {TC_W{1'b1}} : tc_after[TC_W-1:0];
                    tc2 <= (tc2_after[SUM_W-1:TC_W] != {(SUM_W - TC_W) {1'b0}}) ? {TC_W{1'b1}} : tc2_after[TC_W-1:0];
                end
                expired    <= 1'b0;
                held       <= expired;
                updated    <= 1'b0;
                own_x      <= free ? {1'b0, radius_reg} : rel_x;
                own_y      <= free ? {1'b0, radius_reg} : rel_y;
                pass_event <= token_event && !owned;
                if (expired) begin
                    cm_pending <= active;
                    cm_kind    <= `EVCOT_KIND_LOST;
                    cm_seq     <= token_seq;
                    cm_time    <= deadline[TIME_W:1];
                    state      <= `EVCOT_ST_INIT_CELL;
                end else if (token_event && owned) begin
                    own_pending  <= 1'b1;
                    pass_pending <= token_tick != {TICK_W{1'b0}};  // the ticks travel on, the event does not
                    state        <= last ? `EVCOT_ST_EV_PROC : `EVCOT_ST_EV_NO_PROC;
                end else begin
                    pass_pending <= 1'b1;
                    state        <= `EVCOT_ST_EV_PASS_TH;
                end
            end

            // Offers the token to the next tracker.
            `EVCOT_ST_EV_PASS_TH: state <= `EVCOT_ST_IDLE;

            // Counts the event in.
            `EVCOT_ST_EV_NO_PROC: begin
                ring    <= ring || ring_x || ring_y;
                support <= (&support) ? support : support + 1'b1;
                count   <= next_count[NEV_W-1:0];
                state   <= `EVCOT_ST_IDLE;
            end

            // Counts the event in, then moves the centre.
            `EVCOT_ST_EV_PROC:
            if (!updated) begin
                updated <= 1'b1;
                ring    <= ring || ring_x || ring_y;
                support <= (&support) ? support : support + 1'b1;
            end else begin
                g          <= ring ? (({1'b0, radix_max} < grown) ? radix_max : grown[RADIX_W-1:0])
                                   : (({1'b0, g} < lowest) ? radix_min : g - radix_step);
                n_ev       <= slower ? (({1'b0, nev_max} < doubled) ? nev_max : doubled[NEV_W-1:0])
                            : faster ? ((halved < nev_min) ? nev_min : halved)
                                     : n_ev;
                ring       <= 1'b0;
                count      <= {NEV_W{1'b0}};
                tc2        <= {TC_W{1'b0}};
                last_tc2   <= tc2;
                active     <= 1'b1;
                cm_pending <= 1'b1;
                cm_kind    <= active ? `EVCOT_KIND_MOVED : `EVCOT_KIND_BORN;
                cm_seq     <= token_seq;
                cm_time    <= now;
                if (!active) begin
                    id      <= next_id;
                    next_id <= next_id + ID_STEP[ID_W-1:0];
                end
                state <= `EVCOT_ST_IDLE;
            end

            default: state <= `EVCOT_ST_INIT_CELL;
        endcase

        written <= cfg_valid;
        entered <= !cfg_valid && next_seq != write_seq;
        if (cfg_valid) begin
            write_seq <= next_seq;
            if (cfg_addr == `EVCOT_REG_MODE) restart <= 1'b1;
        end

        if (rst) begin
            state        <= `EVCOT_ST_INIT_CELL;
            restart      <= 1'b0;
            cm_pending   <= 1'b0;
            own_pending  <= 1'b0;
            pass_pending <= 1'b0;
            active       <= 1'b0;
            collecting   <= 1'b0;
            expired      <= 1'b0;
            held         <= 1'b0;
            now          <= {TIME_W{1'b0}};
            next_id      <= ID_FIRST[ID_W-1:0];
            written      <= 1'b0;
            entered      <= 1'b0;
            write_seq    <= {SEQ_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
