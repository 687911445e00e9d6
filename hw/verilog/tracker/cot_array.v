// SPDX-License-Identifier: Apache-2.0
// N cluster trackers that see every event at once and whose active windows never overlap: the specification, in Verilog.
//
// Input: tokens in order, as in cot.v; events are numbered here, from 0.
// An event belongs to the active slot whose window contains it, else to the lowest candidate whose window contains it, else it
// starts a life in the lowest free seeded slot, else it passes through. When a window is born, moves or grows and then shares
// a pixel with another active one, the two merge: the first born survives, at the mean of both centres weighted by support
// and with the larger g; the other returns to INIT_CELL. This repeats until no active windows overlap.
//
// That no two active windows overlap is proven: hw/formal.
//
// Latency, unstalled, from the clock edge that takes the event: every output after 2, for any N.
// Throughput: a token every clock. More clocks only for the end of a life (1 each) and for a merge (divider + 4).
// Every output is held until accepted; the array stalls while one is not. Reset turns all slots off.
// s_ready is a register; the m_*_ready inputs gate the core combinationally.
`default_nettype none
`include "evcot_defs.vh"

module cot_array #(
    parameter N       = 8,   // tracker slots
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter FRAC    = 4,   // fractional bits of a centre and of an average
    parameter TICK_W  = 20,  // bits of the tick input
    parameter RADIX_W = 8,   // bits of a radius register
    parameter NEV_W   = 10,  // bits of N_ev
    parameter TC_W    = 24,  // bits of a timer
    parameter SUP_W   = 16,  // bits of a support count
    parameter ID_W    = 32,  // bits of a track id
    parameter SEQ_W   = 48,  // bits of an event's sequence number
    parameter TIME_W  = 48,  // bits of the tick count
    parameter SLOT_W  = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire                clk,
    input  wire                rst,

    // registers: see cot_regs.v
    input  wire                cfg_valid,
    input  wire [SLOT_W-1:0]   cfg_slot,
    input  wire [`EVCOT_REG_W-1:0] cfg_addr,
    input  wire [31:0]         cfg_data,

    // tokens: s_tick ticks have passed, then an event if s_event; s_skip: one that a filter took out, only counted
    input  wire                s_valid,
    output wire                s_ready,
    input  wire [TICK_W-1:0]   s_tick,
    input  wire                s_event,
    input  wire                s_skip,
    input  wire [X_W-1:0]      s_x,
    input  wire [Y_W-1:0]      s_y,
    input  wire                s_p,

    // centre of mass: one record per birth, move, merge and loss
    output reg                 m_cm_valid,
    input  wire                m_cm_ready,
    output reg  [1:0]          m_cm_kind,
    output reg  [SLOT_W-1:0]   m_cm_slot,
    output reg  [ID_W-1:0]     m_cm_id,
    output reg  [ID_W-1:0]     m_cm_other,   // MERGED: the track that stays; else 0
    output reg  [X_W+FRAC-1:0] m_cm_x,
    output reg  [Y_W+FRAC-1:0] m_cm_y,
    output reg  [RADIX_W:0]    m_cm_radius,
    output reg  [NEV_W-1:0]    m_cm_n_ev,
    output reg  [SUP_W-1:0]    m_cm_support,
    output reg  [SEQ_W-1:0]    m_cm_seq,
    output reg  [TIME_W-1:0]   m_cm_time,

    // owned events, addressed within the owner's window
    output reg                 m_own_valid,
    input  wire                m_own_ready,
    output reg  [SLOT_W-1:0]   m_own_slot,
    output reg  [RADIX_W+1:0]  m_own_x,
    output reg  [RADIX_W+1:0]  m_own_y,
    output reg                 m_own_p,
    output reg  [SEQ_W-1:0]    m_own_seq,

    // events that no slot took
    output reg                 m_pass_valid,
    input  wire                m_pass_ready,
    output reg  [X_W-1:0]      m_pass_x,
    output reg  [Y_W-1:0]      m_pass_y,
    output reg                 m_pass_p,
    output reg  [SEQ_W-1:0]    m_pass_seq,

    output wire                idle          // nothing inside, no register write under way
);

    parameter_check #(.OK(N >= `EVCOT_N_SLOTS_MIN && N <= `EVCOT_N_SLOTS_MAX)) N_must_be_1_to_64 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(ID_W >= `EVCOT_ID_W_MIN && ID_W <= `EVCOT_ID_W_MAX)) ID_W_must_be_1_to_32 ();
    parameter_check #(.OK(SEQ_W >= `EVCOT_SEQ_W_MIN && SEQ_W <= `EVCOT_SEQ_W_MAX)) SEQ_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= `EVCOT_TIME_W_MIN && TIME_W <= `EVCOT_TIME_W_MAX)) TIME_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= TC_W + NEV_W)) TIME_W_must_be_at_least_TC_W_plus_NEV_W ();
    parameter_check #(.OK(TIME_W >= TICK_W)) TIME_W_must_be_at_least_TICK_W ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam POS_X  = X_W + FRAC;
    localparam POS_Y  = Y_W + FRAC;
    localparam LEFT_W = TC_W + 1;                                   // ticks left to a deadline
    localparam DUE_W  = (LEFT_W > TICK_W ? LEFT_W : TICK_W) + 1;    // room to compare them with a tick
    localparam REL_X  = (X_W > RADIX_W + 2 ? X_W : RADIX_W + 2) + 1;
    localparam REL_Y  = (Y_W > RADIX_W + 2 ? Y_W : RADIX_W + 2) + 1;

    // What the core is doing. Slot by slot: each phase reads and writes the context of one.
    localparam [2:0] RUN    = 3'd0;  // deciding one token per clock
    localparam [2:0] CHECK  = 3'd1;  // does the moved window overlap another?
    localparam [2:0] ABSORB = 3'd2;  // reporting and clearing the slot that goes
    localparam [2:0] DIVIDE = 3'd3;  // waiting for the weighted centre of the slot that stays
    localparam [2:0] REPORT = 3'd4;  // reporting its new centre

    reg [2:0] phase;

    // ---- input -----------------------------------------------------------------------------------------------------

    localparam TOKEN_W = TICK_W + 2 + X_W + Y_W + 1;

    wire              token_valid, token_taken, token_event, token_skip, p;
    wire [TICK_W-1:0] tick;
    wire [X_W-1:0]    x;
    wire [Y_W-1:0]    y;

    skid_buffer #(
        .W(TOKEN_W)
    ) u_input (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_valid),
        .s_ready(s_ready),
        .s_data ({s_tick, s_event, s_skip, s_x, s_y, s_p}),
        .m_valid(token_valid),
        .m_ready(token_taken),
        .m_data ({tick, token_event, token_skip, x, y, p})
    );

    // ---- state -----------------------------------------------------------------------------------------------------

    reg [TIME_W-1:0] now;     // ticks since reset
    reg [SEQ_W-1:0]  seq;     // number of the next event
    reg [ID_W-1:0]   births;  // id of the next track

    // All slots, the first born first: a birth moves its slot to the end. Ids wrap; this does not.
    reg [N*SLOT_W-1:0] order;

    // Per slot, compared all at once.
    reg [N-1:0]        restart;   // mode was written
    reg [N-1:0]        free;      // seeded, and no life has started
    reg [N-1:0]        window;    // has a window: a candidate, waiting or collecting, or active
    reg [N-1:0]        active;    // visible
    reg [N-1:0]        timed;     // has a deadline: active, or a candidate that has begun to collect
    reg [N*X_W-1:0]    lo_x, hi_x;
    reg [N*Y_W-1:0]    lo_y, hi_y;
    reg [N*LEFT_W-1:0] deadline;  // low bits of the tick at which the life ends

    // Per slot, read and written one at a time.
    reg [POS_X-1:0]    cm_x     [0:N-1];
    reg [POS_Y-1:0]    cm_y     [0:N-1];
    reg [X_W-1:0]      pixel_x  [0:N-1];  // the pixel of cm_x
    reg [Y_W-1:0]      pixel_y  [0:N-1];
    reg [POS_X-1:0]    av_x     [0:N-1];
    reg [POS_Y-1:0]    av_y     [0:N-1];
    reg [RADIX_W-1:0]  g        [0:N-1];
    reg                ring     [0:N-1];
    reg [NEV_W-1:0]    n_ev     [0:N-1];
    reg [NEV_W-1:0]    count    [0:N-1];
    reg [SUP_W-1:0]    support  [0:N-1];
    reg [ID_W-1:0]     id       [0:N-1];
    reg [TIME_W-1:0]   start    [0:N-1];  // tick at which the window of N_ev events began
    reg [TC_W-1:0]     last_tc2 [0:N-1];

    // ---- which slot? -----------------------------------------------------------------------------------------------

    // The owner, among all slots at once; loops run downwards so that the lowest slot wins.
    reg in_active, in_candidate, any_free;
    reg [SLOT_W-1:0] active_slot, candidate_slot, free_slot;

    always @* begin : find_owner
        integer i;
        i              = 0;  // on every path, or it would be a latch
        in_active      = 1'b0;
        in_candidate   = 1'b0;
        any_free       = 1'b0;
        active_slot    = {SLOT_W{1'b0}};
        candidate_slot = {SLOT_W{1'b0}};
        free_slot      = {SLOT_W{1'b0}};
        if (token_valid && token_event)
            for (i = N - 1; i >= 0; i = i - 1) begin
                if (window[i] && x >= lo_x[i*X_W +: X_W] && x <= hi_x[i*X_W +: X_W]
                              && y >= lo_y[i*Y_W +: Y_W] && y <= hi_y[i*Y_W +: Y_W]) begin
                    if (active[i]) begin
                        in_active   = 1'b1;
                        active_slot = i[SLOT_W-1:0];
                    end else begin
                        in_candidate   = 1'b1;
                        candidate_slot = i[SLOT_W-1:0];
                    end
                end
                if (free[i]) begin
                    any_free  = 1'b1;
                    free_slot = i[SLOT_W-1:0];
                end
            end
    end

    wire seeds = !in_active && !in_candidate && any_free;
    wire owned = in_active || in_candidate || any_free;
    wire [SLOT_W-1:0] owner = in_active ? active_slot : in_candidate ? candidate_slot : free_slot;

    // The life that ends next within this token's ticks: the earliest deadline, then the lowest slot.
    reg due;
    reg [SLOT_W-1:0] due_slot;
    reg [LEFT_W-1:0] due_left;

    always @* begin : find_due
        integer i;
        reg [LEFT_W-1:0] left;
        i        = 0;  // on every path, or it would be a latch
        due      = 1'b0;
        due_slot = {SLOT_W{1'b0}};
        due_left = {LEFT_W{1'b1}};
        left     = {LEFT_W{1'b0}};
        if (token_valid)
            for (i = 0; i < N; i = i + 1)
                if (timed[i]) begin
                    left = deadline[i*LEFT_W +: LEFT_W] - now[LEFT_W-1:0];
                    if ({{(DUE_W - LEFT_W) {1'b0}}, left} <= {{(DUE_W - TICK_W) {1'b0}}, tick} && left < due_left) begin
                        due      = 1'b1;
                        due_slot = i[SLOT_W-1:0];
                        due_left = left;
                    end
                end
    end

    // A slot whose mode was written starts anew before the next token.
    reg [SLOT_W-1:0] restart_slot;

    always @* begin : find_restart
        integer i;
        restart_slot = {SLOT_W{1'b0}};
        for (i = N - 1; i >= 0; i = i - 1) if (restart[i]) restart_slot = i[SLOT_W-1:0];
    end

    wire restarting = |restart;

    reg [SLOT_W-1:0] moved, stays, goes;  // CHECK and REPORT, then the two that merge

    wire [SLOT_W-1:0] slot = (phase == ABSORB) ? goes
                           : (phase == DIVIDE) ? stays
                           : (phase != RUN)    ? moved
                           : restarting        ? restart_slot
                           : due               ? due_slot
                                               : owner;

    // ---- what happens in this clock, if there is space for what it puts out? ---------------------------------------

    wire space = (m_cm_ready || !m_cm_valid) && (m_own_ready || !m_own_valid) && (m_pass_ready || !m_pass_valid);

    wire ends    = phase == RUN && (restarting || due);                 // a life, before the token is decided
    wire decides = phase == RUN && !restarting && !due && token_valid;  // the token
    wire takes   = decides && token_event && owned;                     // its event, into a slot
    wire passes  = decides && token_event && !owned;                    // its event, to nobody
    wire absorbs = phase == ABSORB;

    assign token_taken = decides && space;
    assign idle        = phase == RUN && !restarting && !token_valid && !m_cm_valid && !m_own_valid && !m_pass_valid;

    // ---- registers -------------------------------------------------------------------------------------------------

    wire [1:0]         mode;
    wire [X_W-1:0]     init_cm_x;
    wire [Y_W-1:0]     init_cm_y;
    wire [RADIX_W-1:0] init_radix, radix_th, radix_step, radix_min, radix_max;
    wire [3:0]         hist_avg;
    wire [TC_W-1:0]    max_ticks, nev_th, detect_ticks;
    wire [NEV_W-1:0]   clust_nev, nev_min, nev_max;

    cot_regs #(
        .N      (N),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .RADIX_W(RADIX_W),
        .NEV_W  (NEV_W),
        .TC_W   (TC_W),
        .SLOT_W (SLOT_W)
    ) u_regs (
        .clk         (clk),
        .rst         (rst),
        .cfg_valid   (cfg_valid),
        .cfg_slot    (cfg_slot),
        .cfg_addr    (cfg_addr),
        .cfg_data    (cfg_data),
        .slot        (slot),
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

    // ---- the slot before: as stored, or as a seed makes it ---------------------------------------------------------

    wire [POS_X-1:0]   seed_x = {x, {FRAC{1'b0}}};
    wire [POS_Y-1:0]   seed_y = {y, {FRAC{1'b0}}};
    wire [POS_X-1:0]   cur_cm_x    = seeds ? seed_x : cm_x[slot];
    wire [POS_Y-1:0]   cur_cm_y    = seeds ? seed_y : cm_y[slot];
    wire [X_W-1:0]     cur_pixel_x = seeds ? x : pixel_x[slot];
    wire [Y_W-1:0]     cur_pixel_y = seeds ? y : pixel_y[slot];
    wire [POS_X-1:0]   cur_av_x    = seeds ? seed_x : av_x[slot];
    wire [POS_Y-1:0]   cur_av_y    = seeds ? seed_y : av_y[slot];
    wire [RADIX_W-1:0] cur_g       = g[slot];
    wire [NEV_W-1:0]   cur_n_ev    = n_ev[slot];
    wire [NEV_W-1:0]   cur_count   = count[slot];
    wire [SUP_W-1:0]   cur_support = support[slot];
    wire               cur_active  = active[slot];
    wire [RADIX_W:0]   cur_radius  = {1'b0, cur_g} + {1'b0, radix_th};

    // ---- what the event does to it ---------------------------------------------------------------------------------

    wire [TIME_W-1:0] then  = now + {{(TIME_W - TICK_W) {1'b0}}, tick};  // when the event happens
    wire [TIME_W-1:0] span  = (cur_count == {NEV_W{1'b0}} && !cur_active) ? {TIME_W{1'b0}} : then - start[slot];
    wire [TC_W-1:0]   tc2   = (span > {{(TIME_W - TC_W) {1'b0}}, {TC_W{1'b1}}}) ? {TC_W{1'b1}} : span[TC_W-1:0];

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
        .x          (x),
        .y          (y),
        .active     (cur_active),
        .cm_x       (cur_cm_x),
        .cm_y       (cur_cm_y),
        .pixel_x    (cur_pixel_x),
        .pixel_y    (cur_pixel_y),
        .av_x       (cur_av_x),
        .av_y       (cur_av_y),
        .g          (cur_g),
        .ring       (ring[slot]),
        .n_ev       (cur_n_ev),
        .count      (cur_count),
        .support    (cur_support),
        .tc2        (tc2),
        .last_tc2   (last_tc2[slot]),
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

    wire updates = takes && last;  // the centre moves

    wire [REL_X-1:0] rel_x = {{(REL_X - X_W) {1'b0}}, x} + {{(REL_X - RADIX_W - 1) {1'b0}}, cur_radius}
                           - {{(REL_X - X_W) {1'b0}}, cur_pixel_x};
    wire [REL_Y-1:0] rel_y = {{(REL_Y - Y_W) {1'b0}}, y} + {{(REL_Y - RADIX_W - 1) {1'b0}}, cur_radius}
                           - {{(REL_Y - Y_W) {1'b0}}, cur_pixel_y};

    // ---- merge: centres weighted by support ------------------------------------------------------------------------

    wire [POS_X-1:0] mean_x;
    wire [POS_Y-1:0] mean_y;
    wire ready_x, ready_y, done_x, done_y;
    wire merges = phase == DIVIDE && done_x && done_y;

    weighted_mean #(
        .W       (POS_X),
        .WEIGHT_W(SUP_W),
        .ROUND   (FRAC > 0)
    ) u_mean_x (
        .clk       (clk),
        .rst       (rst),
        .s_valid   (absorbs && space),
        .s_ready   (ready_x),
        .s_a       (cm_x[stays]),
        .s_weight_a(support[stays]),
        .s_b       (cm_x[goes]),
        .s_weight_b(support[goes]),
        .m_valid   (done_x),
        .m_ready   (merges && space),
        .m_mean    (mean_x)
    );
    weighted_mean #(
        .W       (POS_Y),
        .WEIGHT_W(SUP_W),
        .ROUND   (FRAC > 0)
    ) u_mean_y (
        .clk       (clk),
        .rst       (rst),
        .s_valid   (absorbs && space),
        .s_ready   (ready_y),
        .s_a       (cm_y[stays]),
        .s_weight_a(support[stays]),
        .s_b       (cm_y[goes]),
        .s_weight_b(support[goes]),
        .m_valid   (done_y),
        .m_ready   (merges && space),
        .m_mean    (mean_y)
    );

    reg  [RADIX_W-1:0] gone_g;  // what the slot that went leaves behind
    reg  [SUP_W-1:0]   gone_support;
    wire [RADIX_W-1:0] larger_g = (gone_g > cur_g) ? gone_g : cur_g;
    wire [SUP_W:0]     both_support = {1'b0, cur_support} + {1'b0, gone_support};

    // ---- the slot after --------------------------------------------------------------------------------------------

    wire clears = ends || absorbs;                               // back to INIT_CELL
    wire places = clears || merges || (takes && (last || seeds));  // the window changes

    wire [POS_X-1:0]   next_cm_x = clears ? {init_cm_x, {FRAC{1'b0}}} : merges ? mean_x : last ? new_cm_x : cur_cm_x;
    wire [POS_Y-1:0]   next_cm_y = clears ? {init_cm_y, {FRAC{1'b0}}} : merges ? mean_y : last ? new_cm_y : cur_cm_y;
    wire [RADIX_W-1:0] next_g    = clears ? init_radix
                                 : merges ? ((larger_g > radix_max) ? radix_max : larger_g)
                                 : last   ? new_g : cur_g;
    wire [RADIX_W:0]   next_radius = {1'b0, next_g} + {1'b0, radix_th};

    wire [X_W-1:0] next_pixel_x, next_lo_x, next_hi_x;
    wire [Y_W-1:0] next_pixel_y, next_lo_y, next_hi_y;

    cot_window #(
        .W   (X_W),
        .FRAC(FRAC),
        .R_W (RADIX_W + 1)
    ) u_window_x (
        .centre(next_cm_x),
        .radius(next_radius),
        .pixel (next_pixel_x),
        .lo    (next_lo_x),
        .hi    (next_hi_x)
    );
    cot_window #(
        .W   (Y_W),
        .FRAC(FRAC),
        .R_W (RADIX_W + 1)
    ) u_window_y (
        .centre(next_cm_y),
        .radius(next_radius),
        .pixel (next_pixel_y),
        .lo    (next_lo_y),
        .hi    (next_hi_y)
    );

    // Does the window overlap that of another active slot? Asked of the new window while events are decided, of the stored
    // one in CHECK, where it is the same.
    wire checking = phase == CHECK;
    wire [X_W-1:0] probe_lo_x = checking ? lo_x[slot*X_W +: X_W] : next_lo_x;
    wire [X_W-1:0] probe_hi_x = checking ? hi_x[slot*X_W +: X_W] : next_hi_x;
    wire [Y_W-1:0] probe_lo_y = checking ? lo_y[slot*Y_W +: Y_W] : next_lo_y;
    wire [Y_W-1:0] probe_hi_y = checking ? hi_y[slot*Y_W +: Y_W] : next_hi_y;

    reg overlaps;
    reg [SLOT_W-1:0] overlap_slot;

    always @* begin : find_overlap
        integer i;
        i            = 0;  // on every path, or it would be a latch
        overlaps     = 1'b0;
        overlap_slot = {SLOT_W{1'b0}};
        if (checking || updates)
            for (i = N - 1; i >= 0; i = i - 1)
                if (active[i] && i[SLOT_W-1:0] != slot
                              && lo_x[i*X_W +: X_W] <= probe_hi_x && hi_x[i*X_W +: X_W] >= probe_lo_x
                              && lo_y[i*Y_W +: Y_W] <= probe_hi_y && hi_y[i*Y_W +: Y_W] >= probe_lo_y) begin
                    overlaps     = 1'b1;
                    overlap_slot = i[SLOT_W-1:0];
                end
    end

    wire births_here = updates && !cur_active;
    reg         older;   // the other was born first
    reg [N-1:0] behind;  // the places in the order from this slot's on

    wire [(N+1)*SLOT_W-1:0] onward = {slot, order};

    always @* begin : find_order
        integer i;
        i      = 0;  // on every path, or it would be a latch
        older  = 1'b0;
        behind = {N{1'b0}};
        if (checking || births_here)
            for (i = 0; i < N; i = i + 1) begin
                if (order[i*SLOT_W +: SLOT_W] == overlap_slot && !(|behind)) older = 1'b1;
                if (order[i*SLOT_W +: SLOT_W] == slot) behind = {N{1'b1}} << i;
            end
    end

    // ---- next deadline ---------------------------------------------------------------------------------------------

    wire lives = cur_active || updates || merges;
    wire [LEFT_W-1:0] next_deadline = (merges ? now[LEFT_W-1:0] : then[LEFT_W-1:0])
                                    + (lives ? {1'b0, max_ticks} : {1'b0, detect_ticks} + {{TC_W{1'b0}}, 1'b1});
    wire starts_timer = lives || cur_count == {NEV_W{1'b0}};  // a candidate's runs from its first event

    // ---- outputs ---------------------------------------------------------------------------------------------------

    wire reports = updates || (ends && cur_active) || absorbs || phase == REPORT;

    always @(posedge clk) begin
        if (m_cm_ready) m_cm_valid <= 1'b0;
        if (m_own_ready) m_own_valid <= 1'b0;
        if (m_pass_ready) m_pass_valid <= 1'b0;

        if (reports && space) begin
            m_cm_valid   <= 1'b1;
            m_cm_kind    <= ends ? `EVCOT_KIND_LOST
                          : absorbs ? `EVCOT_KIND_MERGED
                          : (updates && !cur_active) ? `EVCOT_KIND_BORN : `EVCOT_KIND_MOVED;
            m_cm_slot    <= slot;
            m_cm_id      <= (updates && !cur_active) ? births : id[slot];
            m_cm_other   <= absorbs ? id[stays] : {ID_W{1'b0}};
            m_cm_x       <= updates ? new_cm_x : cm_x[slot];
            m_cm_y       <= updates ? new_cm_y : cm_y[slot];
            m_cm_radius  <= updates ? next_radius : cur_radius;
            m_cm_n_ev    <= updates ? new_n_ev : cur_n_ev;
            m_cm_support <= updates ? new_support : cur_support;
            m_cm_seq     <= (phase == RUN) ? seq : seq - 1'b1;  // merging, the event has been counted
            m_cm_time    <= updates ? then
                          : (ends && !restarting) ? now + {{(TIME_W - LEFT_W) {1'b0}}, due_left} : now;
        end
        if (takes && space) begin
            m_own_valid <= 1'b1;
            m_own_slot  <= slot;
            m_own_x     <= rel_x[RADIX_W+1:0];
            m_own_y     <= rel_y[RADIX_W+1:0];
            m_own_p     <= p;
            m_own_seq   <= seq;
        end
        if (passes && space) begin
            m_pass_valid <= 1'b1;
            m_pass_x     <= x;
            m_pass_y     <= y;
            m_pass_p     <= p;
            m_pass_seq   <= seq;
        end
        if (rst) begin
            m_cm_valid   <= 1'b0;
            m_own_valid  <= 1'b0;
            m_pass_valid <= 1'b0;
        end
    end

    // ---- next state ------------------------------------------------------------------------------------------------

    always @(posedge clk) begin : next_state
        integer place;
        if (space) begin
            if (decides) begin
                now <= then;
                if (token_event || token_skip) seq <= seq + 1'b1;
            end

            if (places) begin
                cm_x[slot]            <= next_cm_x;
                cm_y[slot]            <= next_cm_y;
                pixel_x[slot]         <= next_pixel_x;
                pixel_y[slot]         <= next_pixel_y;
                g[slot]               <= next_g;
                lo_x[slot*X_W +: X_W] <= next_lo_x;
                hi_x[slot*X_W +: X_W] <= next_hi_x;
                lo_y[slot*Y_W +: Y_W] <= next_lo_y;
                hi_y[slot*Y_W +: Y_W] <= next_hi_y;
            end
            if (places || takes) begin
                av_x[slot]    <= takes ? new_av_x : next_cm_x;
                av_y[slot]    <= takes ? new_av_y : next_cm_y;
                support[slot] <= clears ? {SUP_W{1'b0}}
                               : merges ? (both_support[SUP_W] ? {SUP_W{1'b1}} : both_support[SUP_W-1:0])
                                        : new_support;
                if (starts_timer) deadline[slot*LEFT_W +: LEFT_W] <= next_deadline;
            end
            if (clears) begin
                restart[slot] <= 1'b0;
                free[slot]    <= mode == `EVCOT_MODE_SEEDED;
                window[slot]  <= mode == `EVCOT_MODE_FIXED;
                active[slot]  <= 1'b0;
                timed[slot]   <= 1'b0;
                n_ev[slot]    <= clust_nev;
            end
            if (takes) begin
                free[slot]   <= 1'b0;
                window[slot] <= 1'b1;
                timed[slot]  <= 1'b1;
            end
            if (clears || takes) begin
                count[slot] <= (clears || last) ? {NEV_W{1'b0}} : cur_count + 1'b1;
                ring[slot]  <= !clears && !last && new_ring;
            end
            if (takes && (last || (cur_count == {NEV_W{1'b0}} && !cur_active))) start[slot] <= then;
            if (updates) begin
                n_ev[slot]     <= new_n_ev;
                last_tc2[slot] <= tc2;
                active[slot]   <= 1'b1;
                if (births_here) begin
                    id[slot] <= births;
                    births   <= births + 1'b1;
                    for (place = 0; place < N; place = place + 1)
                        if (behind[place]) order[place*SLOT_W +: SLOT_W] <= onward[(place+1)*SLOT_W +: SLOT_W];
                end
            end

            case (phase)
                RUN:
                if (updates && overlaps) begin
                    moved <= slot;
                    phase <= CHECK;
                end
                CHECK: begin
                    stays <= older ? overlap_slot : slot;
                    goes  <= older ? slot : overlap_slot;
                    phase <= overlaps ? ABSORB : RUN;
                end
                ABSORB: begin
                    gone_g       <= cur_g;
                    gone_support <= cur_support;
                    phase        <= DIVIDE;
                end
                DIVIDE:
                if (merges) begin
                    moved <= stays;
                    phase <= REPORT;
                end
                REPORT:  phase <= CHECK;
                default: phase <= RUN;
            endcase
        end

        if (cfg_valid && cfg_addr == `EVCOT_REG_MODE) restart[cfg_slot] <= 1'b1;

        if (rst) begin
            phase   <= RUN;
            now     <= {TIME_W{1'b0}};
            seq     <= {SEQ_W{1'b0}};
            births  <= {ID_W{1'b0}};
            restart <= {N{1'b0}};
            free    <= {N{1'b0}};
            window  <= {N{1'b0}};
            active  <= {N{1'b0}};
            timed   <= {N{1'b0}};
            for (place = 0; place < N; place = place + 1) order[place*SLOT_W +: SLOT_W] <= place[SLOT_W-1:0];
        end
    end

    wire unused = &{1'b0, rel_x[REL_X-1:RADIX_W+2], rel_y[REL_Y-1:RADIX_W+2], ready_x, ready_y};

`ifdef FORMAL
`include "cot_array_rules.vh"
`endif

endmodule

`default_nettype wire
