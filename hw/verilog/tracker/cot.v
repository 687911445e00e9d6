// SPDX-License-Identifier: Apache-2.0
// Cluster Object Tracker: follows one cluster of events with the six-state FSM of the paper.
//
// Input: tokens in order. A token first advances the time by s_tick ticks and then, if s_event is 1, carries an event. The
// output depends on the order of tokens alone, never on when they are accepted.
// Outputs: the centre-of-mass stream (births, moves, losses), the owned events with their address in the window, and the
// pass-through of everything else. Time travels down the pass-through port in order with the events: an event that is owned
// here leaves its ticks there as a token without event.
//
// Latency, unstalled, counted from the clock edge that takes the event: passed or owned event out after 2, centre out after 3.
// Throughput: an event every 3 clocks, every 4 at a centre update, a token without event every 2.
// Every output is held until accepted, and the FSM waits for all of them. Reset turns the tracker off.
// s_ready depends combinationally on s_tick: put a skid_buffer in front where that path is too long.
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
    parameter_check #(.OK(ID_W >= `EVCOT_ID_W_MIN && ID_W <= `EVCOT_ID_W_MAX)) ID_W_must_be_1_to_32 ();
    parameter_check #(.OK(SEQ_W >= `EVCOT_SEQ_W_MIN && SEQ_W <= `EVCOT_SEQ_W_MAX)) SEQ_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= `EVCOT_TIME_W_MIN && TIME_W <= `EVCOT_TIME_W_MAX)) TIME_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= TC_W + NEV_W)) TIME_W_must_be_at_least_TC_W_plus_NEV_W ();
    parameter_check #(.OK(TIME_W >= TICK_W)) TIME_W_must_be_at_least_TICK_W ();

    localparam SUM_W = (TC_W > TICK_W ? TC_W : TICK_W) + 1;  // a timer plus a tick
    localparam POS_X = X_W + FRAC;
    localparam POS_Y = Y_W + FRAC;
    localparam AT_X  = (X_W > RADIX_W + 1 ? X_W : RADIX_W + 1) + 2;  // bits of a bound of a window: see cot_window.v
    localparam AT_Y  = (Y_W > RADIX_W + 1 ? Y_W : RADIX_W + 1) + 2;
    localparam REL_X = (X_W > RADIX_W + 2 ? X_W : RADIX_W + 2) + 1;
    localparam REL_Y = (Y_W > RADIX_W + 2 ? Y_W : RADIX_W + 2) + 1;

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
    reg [POS_X-1:0]       cm_x, av_x;
    reg [POS_Y-1:0]       cm_y, av_y;
    reg [RADIX_W-1:0]     g;
    reg                   ring;
    reg [NEV_W-1:0]       n_ev, count;
    reg [SUP_W-1:0]       support;
    reg [ID_W-1:0]        id, next_id;

    reg [TIME_W-1:0]      now;        // ticks since reset
    reg [TC_W-1:0]        tc;         // ticks since the last owned event
    reg [TC_W-1:0]        tc2;        // ticks since the window of N_ev events began
    reg [TC_W-1:0]        last_tc2;   // what TC2 reached in the window before
    reg                   tick_used;  // the waiting token's ticks have been counted already

    // the token being decided
    reg [TICK_W-1:0]      token_tick;
    reg                   token_event;
    reg [X_W-1:0]         token_x;
    reg [Y_W-1:0]         token_y;
    reg                   token_p;
    reg [SEQ_W-1:0]       token_seq;
    reg                   had_event;  // token_event, before the event was taken from it

    // outputs not yet taken
    reg                   cm_pending, own_pending, pass_pending;
    reg                   updated;    // the token's event has been counted in
    reg [1:0]             cm_kind;
    reg [SEQ_W-1:0]       cm_seq;
    reg [TIME_W-1:0]      cm_time;
    reg [RADIX_W+1:0]     own_x, own_y;

    wire collecting = active || count != {NEV_W{1'b0}};
    wire free       = mode == `EVCOT_MODE_SEEDED && !collecting;  // any event starts a life
    wire busy       = (cm_pending && !m_cm_ready) || (own_pending && !m_own_ready) || (pass_pending && !m_pass_ready);

    // ---- window ----------------------------------------------------------------------------------------------------

    wire [RADIX_W:0] radius = {1'b0, g} + {1'b0, radix_th};
    wire [RADIX_W+1:0] inset = {1'b0, radius} - 1'b1;
    wire [X_W-1:0]   pixel_x;
    wire [Y_W-1:0]   pixel_y;
    wire [AT_X-1:0]  lo_x_not, hi_x;
    wire [AT_Y-1:0]  lo_y_not, hi_y;

    cot_window #(
        .W   (X_W),
        .FRAC(FRAC),
        .R_W (RADIX_W + 1)
    ) u_window_x (
        .asked (1'b1),
        .centre(cm_x),
        .radius(radius),
        .inset (inset),
        .pixel (pixel_x),
        .lo_not(lo_x_not),
        .hi    (hi_x)
    );
    cot_window #(
        .W   (Y_W),
        .FRAC(FRAC),
        .R_W (RADIX_W + 1)
    ) u_window_y (
        .asked (1'b1),
        .centre(cm_y),
        .radius(radius),
        .inset (inset),
        .pixel (pixel_y),
        .lo_not(lo_y_not),
        .hi    (hi_y)
    );

    wire has_window = collecting || mode == `EVCOT_MODE_FIXED;
    wire [AT_X-1:0] at_x = {1'b1, {(AT_X - X_W - 1) {1'b0}}, token_x};  // as the bounds are
    wire [AT_Y-1:0] at_y = {1'b1, {(AT_Y - Y_W - 1) {1'b0}}, token_y};
    wire inside_window = has_window && at_x >= ~lo_x_not && at_x <= hi_x && at_y >= ~lo_y_not && at_y <= hi_y;

    // Address within the window: x - centre + R, from 0 to 2R. A seed lies in the middle.
    wire [REL_X-1:0] rel_x = {{(REL_X - X_W) {1'b0}}, token_x} + {{(REL_X - RADIX_W - 1) {1'b0}}, radius}
                           - {{(REL_X - X_W) {1'b0}}, pixel_x};
    wire [REL_Y-1:0] rel_y = {{(REL_Y - Y_W) {1'b0}}, token_y} + {{(REL_Y - RADIX_W - 1) {1'b0}}, radius}
                           - {{(REL_Y - Y_W) {1'b0}}, pixel_y};
    wire unused_rel = &{1'b0, rel_x[REL_X-1:RADIX_W+2], rel_y[REL_Y-1:RADIX_W+2]};

    // ---- time ------------------------------------------------------------------------------------------------------

    wire [TICK_W-1:0] tick = tick_used ? {TICK_W{1'b0}} : s_tick;
    wire [SUM_W-1:0] tc_after  = {{(SUM_W - TC_W) {1'b0}}, tc} + {{(SUM_W - TICK_W) {1'b0}}, tick};
    wire [SUM_W-1:0] tc2_after = {{(SUM_W - TC_W) {1'b0}}, tc2} + {{(SUM_W - TICK_W) {1'b0}}, tick};
    wire [SUM_W-1:0] tc_top    = {{(SUM_W - TC_W) {1'b0}}, {TC_W{1'b1}}};

    wire lifetime_over = active && tc_after >= {{(SUM_W - TC_W) {1'b0}}, max_ticks};
    wire detect_over   = !active && collecting && tc2_after > {{(SUM_W - TC_W) {1'b0}}, detect_ticks};
    wire expired       = lifetime_over || detect_over;

    // ---- arithmetic ------------------------------------------------------------------------------------------------

    wire               last, new_ring;
    wire [POS_X-1:0]   new_av_x, new_cm_x;
    wire [POS_Y-1:0]   new_av_y, new_cm_y;
    wire [SUP_W-1:0]   new_support;
    wire [RADIX_W-1:0] new_g;
    wire [NEV_W-1:0]   new_n_ev;

    cot_update #(
        .X_W    (X_W),
        .Y_W    (Y_W),
        .FRAC   (FRAC),
        .RADIX_W(RADIX_W),
        .NEV_W  (NEV_W),
        .TC_W   (TC_W),
        .SUP_W  (SUP_W)
    ) u_update (
        .x          (token_x),
        .y          (token_y),
        .active     (active),
        .cm_x       (cm_x),
        .cm_y       (cm_y),
        .pixel_x    (pixel_x),
        .pixel_y    (pixel_y),
        .av_x       (av_x),
        .av_y       (av_y),
        .g          (g),
        .ring       (ring),
        .n_ev       (n_ev),
        .count      (count),
        .support    (support),
        .tc2        (tc2),
        .last_tc2   (last_tc2),
        .radix_step (radix_step),
        .radix_min  (radix_min),
        .radix_max  (radix_max),
        .hist_avg   (hist_avg),
        .nev_min    (nev_min),
        .nev_max    (nev_max),
        .nev_th     (nev_th),
        .last       (last),
        .new_av_x   (new_av_x),
        .new_av_y   (new_av_y),
        .new_ring   (new_ring),
        .new_support(new_support),
        .new_cm_x   (new_cm_x),
        .new_cm_y   (new_cm_y),
        .new_g      (new_g),
        .new_n_ev   (new_n_ev)
    );

    // ---- outputs ---------------------------------------------------------------------------------------------------

    assign s_ready      = state == `EVCOT_ST_IDLE && !restart && !expired;
    assign idle         = state == `EVCOT_ST_IDLE && !restart;

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
    assign m_pass_event = token_event;
    assign m_pass_x     = token_x;
    assign m_pass_y     = token_y;
    assign m_pass_p     = token_p;
    assign m_pass_seq   = token_seq;

    // ---- FSM -------------------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        if (m_cm_ready) cm_pending <= 1'b0;
        if (m_own_ready) own_pending <= 1'b0;
        if (m_pass_ready) pass_pending <= 1'b0;

        case (state)
            // Waits for the record of a life's end to be taken, then loads the registers.
            `EVCOT_ST_INIT_CELL:
            if (!busy) begin
                active  <= 1'b0;
                cm_x    <= {init_cm_x, {FRAC{1'b0}}};
                cm_y    <= {init_cm_y, {FRAC{1'b0}}};
                av_x    <= {init_cm_x, {FRAC{1'b0}}};
                av_y    <= {init_cm_y, {FRAC{1'b0}}};
                g       <= init_radix;
                ring    <= 1'b0;
                n_ev    <= clust_nev;
                count   <= {NEV_W{1'b0}};
                support <= {SUP_W{1'b0}};
                tc      <= {TC_W{1'b0}};
                tc2     <= {TC_W{1'b0}};
                state   <= `EVCOT_ST_IDLE;
            end

            // Waits for a token. The end of a life comes first: the token stays waiting, its ticks are counted once.
            `EVCOT_ST_IDLE:
            if (restart) begin
                restart    <= 1'b0;
                cm_pending <= active;
                cm_kind    <= `EVCOT_KIND_LOST;
                cm_seq     <= token_seq + {{(SEQ_W - 1) {1'b0}}, had_event};
                cm_time    <= now;
                state      <= `EVCOT_ST_INIT_CELL;
            end else if (s_valid && expired) begin
                tick_used  <= 1'b1;
                now        <= now + {{(TIME_W - TICK_W) {1'b0}}, tick};
                cm_pending <= active;
                cm_kind    <= `EVCOT_KIND_LOST;
                cm_seq     <= s_seq;
                cm_time    <= now + {{(TIME_W - TC_W) {1'b0}}, max_ticks} - {{(TIME_W - TC_W) {1'b0}}, tc};
                state      <= `EVCOT_ST_INIT_CELL;
            end else if (s_valid) begin
                tick_used   <= 1'b0;
                now         <= now + {{(TIME_W - TICK_W) {1'b0}}, tick};
                token_tick  <= s_tick;
                token_event <= s_event;
                had_event   <= s_event;
                token_x     <= s_x;
                token_y     <= s_y;
                token_p     <= s_p;
                token_seq   <= s_seq;
                if (collecting) begin
                    tc  <= (tc_after > tc_top) ? {TC_W{1'b1}} : tc_after[TC_W-1:0];
                    tc2 <= (tc2_after > tc_top) ? {TC_W{1'b1}} : tc2_after[TC_W-1:0];
                end
                if (s_event) state <= `EVCOT_ST_EV_DISCRI;
                else if (s_tick != {TICK_W{1'b0}}) begin
                    pass_pending <= 1'b1;
                    state        <= `EVCOT_ST_EV_PASS_TH;
                end
            end

            // Inside or outside? A free seeded tracker starts at the event.
            `EVCOT_ST_EV_DISCRI:
            if (inside_window || free) begin
                updated      <= 1'b0;
                tc           <= {TC_W{1'b0}};
                own_pending  <= 1'b1;
                own_x        <= free ? {1'b0, radius} : rel_x[RADIX_W+1:0];
                own_y        <= free ? {1'b0, radius} : rel_y[RADIX_W+1:0];
                pass_pending <= token_tick != {TICK_W{1'b0}};  // the ticks travel on, the event does not
                token_event  <= 1'b0;
                if (free) begin
                    cm_x <= {token_x, {FRAC{1'b0}}};
                    cm_y <= {token_y, {FRAC{1'b0}}};
                    av_x <= {token_x, {FRAC{1'b0}}};
                    av_y <= {token_y, {FRAC{1'b0}}};
                end
                state <= last ? `EVCOT_ST_EV_PROC : `EVCOT_ST_EV_NO_PROC;
            end else begin
                pass_pending <= 1'b1;
                state        <= `EVCOT_ST_EV_PASS_TH;
            end

            // Offers the token to the next tracker until it is taken.
            `EVCOT_ST_EV_PASS_TH: if (!busy) state <= `EVCOT_ST_IDLE;

            // Counts the event in, then waits until it is taken.
            `EVCOT_ST_EV_NO_PROC: begin
                if (!updated) begin
                    updated <= 1'b1;
                    av_x    <= new_av_x;
                    av_y    <= new_av_y;
                    ring    <= new_ring;
                    support <= new_support;
                    count   <= count + 1'b1;
                end
                if (!busy) state <= `EVCOT_ST_IDLE;
            end

            // Counts the event in, moves the centre, then offers the new centre until it is taken.
            `EVCOT_ST_EV_PROC:
            if (!updated) begin
                updated    <= 1'b1;
                av_x       <= new_av_x;
                av_y       <= new_av_y;
                cm_x       <= new_cm_x;
                cm_y       <= new_cm_y;
                g          <= new_g;
                n_ev       <= new_n_ev;
                support    <= new_support;
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
            end else if (!busy) state <= `EVCOT_ST_IDLE;

            default: state <= `EVCOT_ST_INIT_CELL;
        endcase

        if (cfg_valid && cfg_addr == `EVCOT_REG_MODE) restart <= 1'b1;

        if (rst) begin
            state        <= `EVCOT_ST_INIT_CELL;
            restart      <= 1'b0;
            cm_pending   <= 1'b0;
            own_pending  <= 1'b0;
            pass_pending <= 1'b0;
            active       <= 1'b0;
            tick_used    <= 1'b0;
            now          <= {TIME_W{1'b0}};
            next_id      <= ID_FIRST[ID_W-1:0];
            had_event    <= 1'b0;
            token_seq    <= {SEQ_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
