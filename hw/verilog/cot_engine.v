// SPDX-License-Identifier: Apache-2.0
// cot_array as a pipeline: the same ports, registers and records, the same three streams bit for bit. docs/engine.md draws it.
//
// Latency, unstalled, from the clock edge that takes the event: a record after 8, for any N.
// Throughput: a token every clock. 6 clocks more after an event that moves a centre, 5 after one that starts a life, about
// 2 N + 25 for the end of a life, about 4 (X_W + FRAC) + 40 for a merge, and N + 9 every max_ticks or detect_ticks, whichever
// is less.
// Every output holds its value until taken. Reset turns all slots off; about 6 N clocks later the engine is idle.
// All outputs are registers but `idle`; no path leads from an input to an output.
`default_nettype none
`include "evcot_defs.vh"

module cot_engine #(
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
    input  wire [3:0]          cfg_addr,
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
    output wire                m_cm_valid,
    input  wire                m_cm_ready,
    output wire [1:0]          m_cm_kind,
    output wire [SLOT_W-1:0]   m_cm_slot,
    output wire [ID_W-1:0]     m_cm_id,
    output wire [ID_W-1:0]     m_cm_other,   // MERGED: the track that stays; else 0
    output wire [X_W+FRAC-1:0] m_cm_x,
    output wire [Y_W+FRAC-1:0] m_cm_y,
    output wire [RADIX_W:0]    m_cm_radius,
    output wire [NEV_W-1:0]    m_cm_n_ev,
    output wire [SUP_W-1:0]    m_cm_support,
    output wire [SEQ_W-1:0]    m_cm_seq,
    output wire [TIME_W-1:0]   m_cm_time,

    // owned events, addressed within the owner's window
    output wire                m_own_valid,
    input  wire                m_own_ready,
    output wire [SLOT_W-1:0]   m_own_slot,
    output wire [RADIX_W+1:0]  m_own_x,
    output wire [RADIX_W+1:0]  m_own_y,
    output wire                m_own_p,
    output wire [SEQ_W-1:0]    m_own_seq,

    // events that no slot took
    output wire                m_pass_valid,
    input  wire                m_pass_ready,
    output wire [X_W-1:0]      m_pass_x,
    output wire [Y_W-1:0]      m_pass_y,
    output wire                m_pass_p,
    output wire [SEQ_W-1:0]    m_pass_seq,

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

    localparam LIFE_W  = (TC_W > TICK_W ? TC_W : TICK_W) + 2;      // bits of a deadline
    localparam CLOCK_W = TIME_W > LIFE_W ? TIME_W : LIFE_W;        // bits of the time inside
    localparam STEP_W  = $clog2(N + 4);
    localparam [31:0] SLOTS  = N;
    localparam [31:0] WALKED = N + 3;

    // What the engine is doing.
    localparam [2:0] RUN    = 3'd0;  // issuing tokens
    localparam [2:0] WALK   = 3'd1;  // looking through all deadlines
    localparam [2:0] FETCH  = 3'd2;  // reading two slots that merge
    localparam [2:0] REPORT = 3'd3;  // reporting the slot that goes, when the record before is taken
    localparam [2:0] CLEAR  = 3'd4;  // clearing it
    localparam [2:0] SETTLE = 3'd5;  // waiting until it is cleared
    localparam [2:0] JOIN   = 3'd6;  // waiting for the mean, then placing the slot that stays

    // Why a slot goes.
    localparam [1:0] RESTART = 2'd0;
    localparam [1:0] LIFE    = 2'd1;
    localparam [1:0] MERGE   = 2'd2;

    // What a walk over all slots looks at, one after the other: the first two only after registers were written.
    localparam [1:0] MAX_TICKS    = 2'd0;
    localparam [1:0] DETECT_TICKS = 2'd1;
    localparam [1:0] DEADLINES    = 2'd2;

    reg [2:0]        phase;
    reg [1:0]        why;
    reg [STEP_W-1:0] step;       // clocks in WALK or FETCH
    reg [SLOT_W-1:0] slow_slot;  // which slot the phase is about
    reg [1:0]        walk;       // what a walk looks at

    // ---- input -----------------------------------------------------------------------------------------------------

    wire               token_valid, token_event, token_p, input_empty;
    wire [CLOCK_W-1:0] token_time;
    wire [SEQ_W-1:0]   token_seq;
    wire [X_W-1:0]     token_x;
    wire [Y_W-1:0]     token_y;
    wire               issue, commit, rewind;

    engine_input #(
        .X_W    (X_W),
        .Y_W    (Y_W),
        .TICK_W (TICK_W),
        .SEQ_W  (SEQ_W),
        .CLOCK_W(CLOCK_W)
    ) u_input (
        .clk     (clk),
        .rst     (rst),
        .s_valid (s_valid),
        .s_ready (s_ready),
        .s_tick  (s_tick),
        .s_event (s_event),
        .s_skip  (s_skip),
        .s_x     (s_x),
        .s_y     (s_y),
        .s_p     (s_p),
        .m_valid (token_valid),
        .m_take  (issue),
        .m_time  (token_time),
        .m_seq   (token_seq),
        .m_event (token_event),
        .m_x     (token_x),
        .m_y     (token_y),
        .m_p     (token_p),
        .commit  (commit),
        .rewind  (rewind),
        .empty   (input_empty)
    );

    // ---- the stages' registers -------------------------------------------------------------------------------------

    reg               m_valid, e_valid, c_valid, u_valid;  // a token is there
    reg               m_check, e_check;                    // a window is, to be checked
    reg [SLOT_W-1:0]  m_self, e_self;                      // whose
    reg [X_W-1:0]     m_lo_x, m_hi_x, e_x, c_x, u_x, v_x;
    reg [Y_W-1:0]     m_lo_y, m_hi_y, e_y, c_y, u_y, v_y;
    reg               m_event, e_event;
    reg               m_p, e_p, c_p, u_p, v_p;
    reg [CLOCK_W-1:0] m_time, e_time, c_time, u_time;
    reg [SEQ_W-1:0]   m_seq, e_seq, c_seq, u_seq, v_seq;
    reg               e_due, c_due, u_due;                 // the bound has come
    reg [SLOT_W-1:0]  c_slot, v_slot;
    (* keep *) reg [SLOT_W-1:0] c_slot_too;                // c_slot again: it goes to every bit of the context
    reg               c_takes, c_passes, c_active, c_seeds, c_report, c_clear, c_join, c_walks;
    reg               u_takes, u_passes, u_walks, v_decided, v_owned;

    reg               found;              // the window checked overlaps
    reg [SLOT_W-1:0]  moved, found_slot;  // that of this slot, which moved, and that of the other

    reg [N-1:0]       restart;     // mode was written, or reset
    reg               stale;       // a register was written: the bound means nothing
    reg               exempt;      // lives that end before the next token have been ended
    reg               blocked;     // the next token waits for a record to be taken

    reg [CLOCK_W-1:0] now;         // time of the last committed token
    reg [SEQ_W-1:0]   seq;         // number of its event, or of the next one where a life ends

    // ---- M and E: whose is it? ---------------------------------------------------------------------------------------

    wire              e_active, e_other, e_free, m_due;
    wire [SLOT_W-1:0] e_slot, e_lowest;
    wire [N-1:0]      active;
    wire              w_busy, w_checks, w_places, w_changes, w_free, w_window, w_active;
    wire [SLOT_W-1:0] w_slot;
    wire [X_W-1:0]    w_lo_x, w_hi_x;
    wire [Y_W-1:0]    w_lo_y, w_hi_y;

    engine_match #(
        .N     (N),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .SLOT_W(SLOT_W)
    ) u_match (
        .clk      (clk),
        .rst      (rst),
        .m_valid  (m_check || (m_valid && m_event)),
        .m_check  (m_check),
        .m_self   (m_self),
        .m_lo_x   (m_lo_x),
        .m_hi_x   (m_hi_x),
        .m_lo_y   (m_lo_y),
        .m_hi_y   (m_hi_y),
        .e_active (e_active),
        .e_other  (e_other),
        .e_free   (e_free),
        .e_slot   (e_slot),
        .e_lowest (e_lowest),
        .w_places (w_places),
        .w_changes(w_changes),
        .w_slot   (w_slot),
        .w_lo_x   (w_lo_x),
        .w_hi_x   (w_hi_x),
        .w_lo_y   (w_lo_y),
        .w_hi_y   (w_hi_y),
        .w_free   (w_free),
        .w_window (w_window),
        .w_active (w_active),
        .active   (active)
    );

    // ---- C to W: what it does to its owner -----------------------------------------------------------------------------

    wire                u_last, u_special, u_busy, u_timed, u_on, v_busy;
    wire [SLOT_W-1:0]   u_slot;
    wire [ID_W-1:0]     u_id, stays_id;
    wire [X_W+FRAC-1:0] u_cm_x, join_x;
    wire [Y_W+FRAC-1:0] u_cm_y, join_y;
    wire [RADIX_W-1:0]  u_g, join_g;
    wire [SUP_W-1:0]    v_support, join_support;
    wire [LIFE_W-1:0]   u_deadline;
    wire [TC_W-1:0]     u_max_ticks, u_detect_ticks;
    wire [RADIX_W+1:0]  v_rel_x, v_rel_y;
    wire [TIME_W-1:0]   ended_time;

    engine_update #(
        .N      (N),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .FRAC   (FRAC),
        .RADIX_W(RADIX_W),
        .NEV_W  (NEV_W),
        .TC_W   (TC_W),
        .SUP_W  (SUP_W),
        .ID_W   (ID_W),
        .SEQ_W  (SEQ_W),
        .TIME_W (TIME_W),
        .LIFE_W (LIFE_W),
        .CLOCK_W(CLOCK_W),
        .SLOT_W (SLOT_W)
    ) u_update (
        .clk           (clk),
        .rst           (rst),
        .cfg_valid     (cfg_valid),
        .cfg_slot      (cfg_slot),
        .cfg_addr      (cfg_addr),
        .cfg_data      (cfg_data),
        .c_slot        (c_slot),
        .c_slot_too    (c_slot_too),
        .c_takes       (c_takes),
        .c_active      (c_active),
        .c_seeds       (c_seeds),
        .c_x           (c_x),
        .c_y           (c_y),
        .c_time        (c_time),
        .c_report      (c_report),
        .c_clear       (c_clear),
        .c_join        (c_join),
        .join_x        (join_x),
        .join_y        (join_y),
        .join_g        (join_g),
        .join_support  (join_support),
        .u_commits     (commit && u_takes),
        .u_last        (u_last),
        .u_special     (u_special),
        .u_slot        (u_slot),
        .u_busy        (u_busy),
        .u_id          (u_id),
        .u_cm_x        (u_cm_x),
        .u_cm_y        (u_cm_y),
        .u_g           (u_g),
        .v_support     (v_support),
        .u_timed       (u_timed),
        .u_deadline    (u_deadline),
        .u_on          (u_on),
        .u_max_ticks   (u_max_ticks),
        .u_detect_ticks(u_detect_ticks),
        .v_busy        (v_busy),
        .v_rel_x       (v_rel_x),
        .v_rel_y       (v_rel_y),
        .w_busy        (w_busy),
        .w_checks      (w_checks),
        .w_places      (w_places),
        .w_changes     (w_changes),
        .w_slot        (w_slot),
        .w_lo_x        (w_lo_x),
        .w_hi_x        (w_hi_x),
        .w_lo_y        (w_lo_y),
        .w_hi_y        (w_hi_y),
        .w_free        (w_free),
        .w_window      (w_window),
        .w_active      (w_active),
        .lost          (why != MERGE),
        .other         (stays_id),
        .seq           (seq),
        .now           (now[TIME_W-1:0]),
        .ended         (why == LIFE ? ended_time : now[TIME_W-1:0]),
        .m_cm_valid    (m_cm_valid),
        .m_cm_ready    (m_cm_ready),
        .m_cm_kind     (m_cm_kind),
        .m_cm_slot     (m_cm_slot),
        .m_cm_id       (m_cm_id),
        .m_cm_other    (m_cm_other),
        .m_cm_x        (m_cm_x),
        .m_cm_y        (m_cm_y),
        .m_cm_radius   (m_cm_radius),
        .m_cm_n_ev     (m_cm_n_ev),
        .m_cm_support  (m_cm_support),
        .m_cm_seq      (m_cm_seq),
        .m_cm_time     (m_cm_time)
    );

    // ---- lives that end, tracks that merge -----------------------------------------------------------------------------

    wire              ended, walked, done;
    wire [SLOT_W-1:0] ended_slot, stays, goes;

    engine_lives #(
        .TC_W   (TC_W),
        .TIME_W (TIME_W),
        .LIFE_W (LIFE_W),
        .CLOCK_W(CLOCK_W),
        .SLOT_W (SLOT_W)
    ) u_lives (
        .clk         (clk),
        .m_time      (m_time[LIFE_W-1:0]),
        .m_due       (m_due),
        .survey      (phase == WALK && walk == MAX_TICKS && step == {STEP_W{1'b0}}),
        .on_detect   (walk == DETECT_TICKS),
        .surveys     (walk != DEADLINES),
        .start       (phase == WALK && walk == DEADLINES && step == {STEP_W{1'b0}}),
        .step        (u_walks),
        .finish      (walked && walk == DEADLINES && !ended),
        .now         (now),
        .slot        (u_slot),
        .timed       (u_timed),
        .deadline    (u_deadline),
        .on          (u_on),
        .max_ticks   (u_max_ticks),
        .detect_ticks(u_detect_ticks),
        .ended       (ended),
        .ended_slot  (ended_slot),
        .ended_time  (ended_time)
    );

    engine_merge #(
        .POS_X  (X_W + FRAC),
        .POS_Y  (Y_W + FRAC),
        .ROUND  (FRAC > 0),
        .RADIX_W(RADIX_W),
        .SUP_W  (SUP_W),
        .ID_W   (ID_W),
        .SLOT_W (SLOT_W)
    ) u_merge (
        .clk         (clk),
        .take_a      (phase == FETCH && step == TWO),
        .take_b      (phase == FETCH && step == THREE),
        .slot        (u_slot),
        .id          (u_id),
        .cm_x        (u_cm_x),
        .cm_y        (u_cm_y),
        .g           (u_g),
        .support     (v_support),
        .stays       (stays),
        .goes        (goes),
        .stays_id    (stays_id),
        .done        (done),
        .join_x      (join_x),
        .join_y      (join_y),
        .join_g      (join_g),
        .join_support(join_support)
    );

    // ---- output ----------------------------------------------------------------------------------------------------

    wire room, output_empty;

    engine_output #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .REL_W (RADIX_W + 2),
        .SEQ_W (SEQ_W),
        .SLOT_W(SLOT_W)
    ) u_output (
        .clk         (clk),
        .rst         (rst),
        .s_valid     (v_decided),
        .s_owned     (v_owned),
        .s_slot      (v_slot),
        .s_rel_x     (v_rel_x),
        .s_rel_y     (v_rel_y),
        .s_x         (v_x),
        .s_y         (v_y),
        .s_p         (v_p),
        .s_seq       (v_seq),
        .m_own_valid (m_own_valid),
        .m_own_ready (m_own_ready),
        .m_own_slot  (m_own_slot),
        .m_own_x     (m_own_x),
        .m_own_y     (m_own_y),
        .m_own_p     (m_own_p),
        .m_own_seq   (m_own_seq),
        .m_pass_valid(m_pass_valid),
        .m_pass_ready(m_pass_ready),
        .m_pass_x    (m_pass_x),
        .m_pass_y    (m_pass_y),
        .m_pass_p    (m_pass_p),
        .m_pass_seq  (m_pass_seq),
        .room        (room),
        .empty       (output_empty)
    );

    // ---- what happens in this clock ----------------------------------------------------------------------------------

    localparam [STEP_W-1:0] TWO   = 2;
    localparam [STEP_W-1:0] THREE = 3;
    localparam [STEP_W-1:0] SIX   = 6;

    wire u_waits   = u_last && m_cm_valid;                             // for the record before to be taken
    wire u_ends    = u_valid && (stale || (u_due && !exempt));         // lives, before this token
    wire u_refused = u_valid && (stale || (u_due && !exempt) || u_waits);
    wire u_closes  = u_valid && u_special;                             // windows change: nothing behind it holds

    wire in_flight = c_report || c_clear || c_join || u_busy || u_closes || v_busy;
    wire settled   = !in_flight && !w_busy;
    wire restarts  = phase == RUN && |restart && settled && !m_check && !e_check && !found && !u_valid;

    assign walked  = phase == WALK && step == WALKED[STEP_W-1:0];
    assign commit  = u_valid && !u_refused;
    assign rewind  = u_refused || u_closes || found || restarts;
    assign issue   = token_valid && room && phase == RUN && !rewind && !in_flight && !(w_busy && w_checks) && !blocked
                 && restart == {N{1'b0}};

    assign idle = input_empty && phase == RUN && settled && !m_check && !e_check && !found && restart == {N{1'b0}}
               && !v_decided && output_empty && !m_cm_valid;

    reg [SLOT_W-1:0] restart_slot;

    always @* begin : find_restart
        integer i;
        restart_slot = {SLOT_W{1'b0}};
        for (i = N - 1; i >= 0; i = i - 1) if (restart[i]) restart_slot = i[SLOT_W-1:0];
    end

    // ---- tokens ----------------------------------------------------------------------------------------------------

    // By then the number of the next event has come down to U.
    wire reports = !m_cm_valid && |step[STEP_W-1:2];
    wire running = phase == RUN;
    wire owned   = e_active || e_other || e_free;

    always @(posedge clk) begin
        // A token, or in its place a window that has changed.
        m_valid  <= issue;
        m_check  <= w_busy && w_checks;
        m_self   <= w_slot;
        m_lo_x   <= (w_busy && w_checks) ? w_lo_x : token_x;
        m_hi_x   <= (w_busy && w_checks) ? w_hi_x : token_x;
        m_lo_y   <= (w_busy && w_checks) ? w_lo_y : token_y;
        m_hi_y   <= (w_busy && w_checks) ? w_hi_y : token_y;
        m_time   <= token_time;
        m_seq    <= token_seq;
        m_event  <= token_event;
        m_p      <= token_p;

        e_valid  <= m_valid && !rewind;
        e_check  <= m_check;
        e_self   <= m_self;
        e_due    <= m_due;
        e_x      <= m_lo_x;
        e_y      <= m_lo_y;
        e_time   <= m_time;
        e_seq    <= m_seq;
        e_event  <= m_event;
        e_p      <= m_p;

        found <= e_check && e_other;
        if (e_check) begin
            moved      <= e_self;
            found_slot <= e_lowest;
        end

        c_valid  <= e_valid && !rewind;
        c_due    <= e_due;
        c_slot   <= running ? e_slot : slow_slot;
        c_slot_too <= running ? e_slot : slow_slot;
        c_takes  <= e_valid && e_event && owned;
        c_passes <= e_event && !owned;
        c_active <= e_active;
        c_seeds  <= e_valid && !e_active && !e_other;
        c_x      <= e_x;
        c_y      <= e_y;
        c_time   <= e_time;
        if (!running) c_time[LIFE_W-1:0] <= now[LIFE_W-1:0];
        c_seq    <= e_seq;
        c_p      <= e_p;
        c_report <= phase == REPORT && reports;
        c_clear  <= phase == CLEAR && settled;
        c_join   <= phase == JOIN && done && !m_cm_valid;
        c_walks  <= phase == WALK && step < SLOTS[STEP_W-1:0];

        u_valid  <= c_valid && !rewind;
        u_due    <= c_due;
        u_takes  <= c_takes;
        u_passes <= c_passes;
        u_x      <= c_x;
        u_y      <= c_y;
        u_time   <= c_time;
        u_seq    <= c_seq;
        u_p      <= c_p;
        u_walks  <= c_walks;

        v_decided <= commit && (u_takes || u_passes);
        v_owned   <= u_takes;
        v_slot    <= u_slot;
        v_x       <= u_x;
        v_y       <= u_y;
        v_seq     <= u_seq;
        v_p       <= u_p;

        if (rst) begin
            {m_valid, e_valid, c_valid, u_valid, m_check, e_check, found, v_decided} <= 8'd0;
            {c_report, c_clear, c_join} <= 3'd0;
        end
    end

    // ---- control ---------------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        if (commit) begin
            now    <= u_time;
            exempt <= 1'b0;
        end
        if (commit || u_ends || (u_busy && why == RESTART)) seq <= u_seq;
        if (u_refused && u_waits) blocked <= 1'b1;
        if (!m_cm_valid) blocked <= 1'b0;

        step <= step + 1'b1;
        case (phase)
            RUN: begin
                step <= {STEP_W{1'b0}};
                if (found) begin
                    slow_slot <= moved;
                    phase     <= FETCH;
                end else if (u_ends) begin
                    stale     <= 1'b0;
                    walk      <= stale ? MAX_TICKS : DEADLINES;
                    now       <= u_time;
                    slow_slot <= {SLOT_W{1'b0}};
                    phase     <= WALK;
                end else if (restarts) begin
                    restart[restart_slot] <= 1'b0;
                    why       <= RESTART;
                    slow_slot <= restart_slot;
                    phase     <= active[restart_slot] ? REPORT : CLEAR;
                end
            end
            WALK: begin
                slow_slot <= slow_slot + 1'b1;
                if (walked && walk != DEADLINES) begin
                    step      <= {STEP_W{1'b0}};
                    slow_slot <= {SLOT_W{1'b0}};
                    walk      <= walk + 1'b1;
                end else if (walked) begin
                    why       <= LIFE;
                    slow_slot <= ended_slot;
                    exempt    <= !ended;
                    phase     <= !ended ? RUN : active[ended_slot] ? REPORT : CLEAR;
                end
            end
            FETCH: begin
                slow_slot <= found_slot;
                if (step == SIX) begin
                    why       <= MERGE;
                    slow_slot <= goes;
                    phase     <= REPORT;
                end
            end
            REPORT:  if (reports) phase <= CLEAR;
            CLEAR:   if (settled) phase <= (why == RESTART) ? RUN : SETTLE;
            SETTLE:
            if (settled) begin
                step      <= {STEP_W{1'b0}};
                slow_slot <= (why == LIFE) ? {SLOT_W{1'b0}} : stays;
                phase     <= (why == LIFE) ? WALK : JOIN;
            end
            JOIN:    if (done && !m_cm_valid) phase <= RUN;
            default: phase <= RUN;
        endcase

        if (cfg_valid) stale <= 1'b1;
        if (cfg_valid && cfg_addr == `EVCOT_REG_MODE) restart[cfg_slot] <= 1'b1;

        if (rst) begin
            phase   <= RUN;
            now     <= {CLOCK_W{1'b0}};
            seq     <= {SEQ_W{1'b0}};
            restart <= {N{1'b1}};
            stale   <= 1'b1;
            exempt  <= 1'b0;
            blocked <= 1'b0;
        end
    end

endmodule

`default_nettype wire
