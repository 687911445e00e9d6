// SPDX-License-Identifier: Apache-2.0
// N cluster trackers that see every event at once and whose active windows never overlap, as a pipeline. docs/array.md draws it.
//
// Input: tokens in order, as in cot.v; events are numbered here, from 0.
// An event belongs to the active slot whose window contains it, else to the lowest candidate whose window contains it, else it
// starts a life in the lowest free seeded slot, else it passes through. When a window is born, moves or grows and then shares
// a pixel with another active one, the two merge: the first born survives, at the mean of both centres weighted by support
// and with the larger g; the other returns to INIT_CELL. This repeats until no active windows overlap.
//
// Latency:    unstalled, from the clock edge that takes the event: a record after 11, or 12 where N > 16; owned and passed
//             events likewise.
// Throughput: a token every clock. More clocks, where N > 16 those in brackets: 6 (7) after an event that moves a centre or
// starts a life, 2 N + 40 (2 N + 45) for the end of a life, 4 (X_W + FRAC) + 25 (2 (X_W + FRAC) + 22) for a merge, and
// N + 12 every max_ticks or detect_ticks, whichever is less.
// Stall:      every output is held until accepted.
// Reset:      turns all slots off; about 12 N clocks later the array is idle.
// Combinational paths: none; all outputs are registers.
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

    output reg                 idle          // nothing inside, no register write under way; a clock late where it rises
);

    parameter_check #(.OK(N >= `EVCOT_N_SLOTS_MIN && N <= `EVCOT_N_SLOTS_MAX)) N_must_be_1_to_64 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(ID_W >= `EVCOT_ID_W_MIN && ID_W <= `EVCOT_ID_W_MAX)) ID_W_must_be_1_to_32 ();
    parameter_check #(.OK(SEQ_W >= `EVCOT_SEQ_W_MIN && SEQ_W <= `EVCOT_SEQ_W_MAX)) SEQ_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= `EVCOT_TIME_W_MIN && TIME_W <= `EVCOT_TIME_W_MAX)) TIME_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= TC_W + NEV_W)) TIME_W_must_be_at_least_TC_W_plus_NEV_W ();
    parameter_check #(.OK(TIME_W >= TICK_W)) TIME_W_must_be_at_least_TICK_W ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam FAR     = (N > 16) ? 1 : 0;  // many slots lie far apart: one stage more, D, for the way to them
    localparam LIFE_W  = (TC_W > TICK_W ? TC_W : TICK_W) + 2;      // bits of a deadline
    localparam CLOCK_W = TIME_W > LIFE_W ? TIME_W : LIFE_W;        // bits of the time inside
    localparam AT_X    = (X_W > RADIX_W + 1 ? X_W : RADIX_W + 1) + 2;  // bits of a bound of a window
    localparam AT_Y    = (Y_W > RADIX_W + 1 ? Y_W : RADIX_W + 1) + 2;
    localparam STEP_W  = $clog2(N + 9 + FAR);
    localparam [31:0] SLOTS  = N;
    localparam [31:0] WALKED = N + 7 + FAR;  // until the walk has seen the last one
    localparam [31:0] FIRST_AT = 2 + FAR;    // clocks from FETCH on until the context of the first slot is there
    localparam [31:0] OTHER_AT = 3 + FAR;    // that of the other
    localparam [31:0] FETCHED  = 8 + FAR;    // it is known which of them goes
    localparam [N-1:0] NONE  = 0;
    localparam [N-1:0] FIRST = 1;

    // What the array is doing.
    localparam [2:0] RUN    = 3'd0;  // issuing tokens
    localparam [2:0] WALK   = 3'd1;  // looking through all deadlines
    localparam [2:0] FETCH  = 3'd2;  // reading two slots that merge
    localparam [2:0] REPORT = 3'd3;  // reporting the slot that goes, if it is active, when the record before is taken
    localparam [2:0] CLEAR  = 3'd4;  // clearing it
    localparam [2:0] SETTLE = 3'd5;  // waiting until it is cleared
    localparam [2:0] JOIN   = 3'd6;  // waiting for the mean, then placing the slot that stays

    // Why a slot goes.
    localparam [1:0] RESTART = 2'd0;
    localparam [1:0] LIFE    = 2'd1;
    localparam [1:0] MERGE   = 2'd2;

    reg [2:0]        phase;
    reg [1:0]        why;
    reg [STEP_W-1:0] step;       // clocks in WALK or FETCH
    reg [SLOT_W-1:0] slow_slot;  // which slot the phase is about
    reg              surveys;    // a walk looks at a register, after one was written; else at deadlines
    reg              on_detect;  // at detect_ticks, the second such walk; else at max_ticks

    // ---- input -----------------------------------------------------------------------------------------------------

    wire               token_valid, token_counts, token_event, token_p, input_empty;
    wire [CLOCK_W-1:0] token_time;
    wire [X_W-1:0]     token_x;
    wire [Y_W-1:0]     token_y;
    wire               issue, commit, rewind;
    reg                closed;  // no token may be issued

    array_input #(
        .X_W    (X_W),
        .Y_W    (Y_W),
        .TICK_W (TICK_W),
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
        .m_take  (!closed),
        .m_time  (token_time),
        .m_counts(token_counts),
        .m_event (token_event),
        .m_x     (token_x),
        .m_y     (token_y),
        .m_p     (token_p),
        .commit  (commit),
        .rewind  (rewind),
        .empty   (input_empty)
    );

    // ---- the stages' registers -------------------------------------------------------------------------------------

    // D is a stage if FAR, else it is E.
    reg               m_valid, e_valid, d_valid, c_valid, u_valid;  // a token is there
    reg               m_check, e_check;                    // a window is, to be checked
    reg [SLOT_W-1:0]  m_self, e_self;                      // whose
    reg [AT_X-1:0]    m_lo_x_not, m_hi_x;
    reg [AT_Y-1:0]    m_lo_y_not, m_hi_y;
    reg [X_W-1:0]     e_x, d_x, c_x, u_x, v_x;
    reg [Y_W-1:0]     e_y, d_y, c_y, u_y, v_y;
    reg               m_event, e_event, d_event;
    reg               m_counts, e_counts, d_counts, c_counts, u_counts;
    reg               m_p, e_p, d_p, c_p, u_p, v_p;
    reg [CLOCK_W-1:0] m_time, e_time, d_time, c_time, u_time;
    reg               e_due, d_due, c_due;                 // the bound has come
    reg               u_ends;                              // in place of u_valid: lives, before this token
    reg               rewound;                             // the clock before threw tokens out
    reg               d_there;                             // a token is, or was before it was thrown out
    wire [3*SLOT_W-1:0] c_slots;                           // three times the slot, for it goes to every bit of the context
    wire [2*SLOT_W-1:0] c_slots_not;                       // twice its complement
    reg               c_takes, c_passes, c_active, c_seeds, c_busy, c_report, c_clear, c_join, c_looks;
    reg               o_busy, o_report, o_clear, o_join, o_looks;  // an operation, or a look at a slot, on its way to C
    reg               d_busy, d_report, d_clear, d_join, d_looks;
    reg               u_takes, u_passes, u_walks, v_walks, v_decided, v_owned;

    reg               found;              // the window checked overlaps
    reg [SLOT_W-1:0]  moved, found_slot;  // that of this slot, which moved, and that of the other

    reg [N-1:0]       restart;     // mode was written, or reset
    reg               stale;       // a register was written: the bound means nothing
    reg               exempt;      // lives that end before the next token have been ended
    reg               stalled;     // a record was not taken at once: nothing behind it holds until it is

    reg [CLOCK_W-1:0] now;         // time of the last committed token
    reg [SEQ_W-1:0]   seq;         // number of its event, or of the next one where a life ends
    reg [SEQ_W-1:0]   next_seq;

    // ---- M to D: whose is it? ----------------------------------------------------------------------------------------

    wire              m_due, e_other, d_active, d_other, d_free;
    wire [SLOT_W-1:0] e_lowest, d_slot;
    wire [N-1:0]      active;
    wire              w_checks, w_places, w_changes, w_born, w_free, w_window, w_active;
    wire [SLOT_W-1:0] w_slot;
    wire [AT_X-1:0]   w_lo_x_not, w_hi_x;
    wire [AT_Y-1:0]   w_lo_y_not, w_hi_y;

    array_match #(
        .N     (N),
        .FAR   (FAR),
        .X_W   (AT_X),
        .Y_W   (AT_Y),
        .SLOT_W(SLOT_W)
    ) u_match (
        .clk      (clk),
        .rst      (rst),
        .m_valid  (m_check || (m_valid && m_event && !rewound)),
        .m_check  (m_check),
        .m_self   (m_self),
        .m_lo_x_not(m_lo_x_not),
        .m_hi_x   (m_hi_x),
        .m_lo_y_not(m_lo_y_not),
        .m_hi_y   (m_hi_y),
        .names    (phase != RUN),
        .slot     (slow_slot),
        .e_other  (e_other),
        .e_lowest (e_lowest),
        .d_active (d_active),
        .d_other  (d_other),
        .d_free   (d_free),
        .d_slot   (d_slot),
        .w_places (w_places),
        .w_changes(w_changes),
        .w_slot   (w_slot),
        .w_lo_x_not(w_lo_x_not),
        .w_hi_x   (w_hi_x),
        .w_lo_y_not(w_lo_y_not),
        .w_hi_y   (w_hi_y),
        .w_free   (w_free),
        .w_window (w_window),
        .w_active (w_active),
        .active   (active)
    );

    // Where the slots are far, registers that synthesis keeps apart. Where they are few, those that differ in their reset, and
    // complements, stay apart, and as addresses they may go into a memory.
    genvar g;
    generate
        if (FAR != 0) begin : g_copies
            for (g = 0; g < 3; g = g + 1) begin : g_slot
                array_copy #(
                    .W(SLOT_W)
                ) u_slot (
                    .clk(clk),
                    .s  (d_slot),
                    .m  (c_slots[SLOT_W*g+:SLOT_W])
                );
            end
            assign c_slots_not = {2 * SLOT_W{1'b0}};
        end else begin : g_three
            reg [SLOT_W-1:0] slot, slot_rest, slot_regs, not_x, not_y;

            always @(posedge clk) begin
                slot      <= d_slot;
                slot_rest <= rst ? {SLOT_W{1'b0}} : d_slot;
                slot_regs <= rst ? {SLOT_W{1'b1}} : d_slot;
                not_x     <= ~d_slot;
                not_y     <= rst ? {SLOT_W{1'b0}} : ~d_slot;
            end
            assign c_slots = {slot, slot_rest, slot_regs};
            assign c_slots_not = {not_x, not_y};
        end
    endgenerate

    // ---- C to W: what it does to its owner -----------------------------------------------------------------------------

    wire                c_commits, u_special, u_busy, v_timed, v_on, v_busy, w_busy;
    wire [SLOT_W-1:0]   v_slot;
    wire [ID_W-1:0]     v_id, stays_id;
    wire [X_W+FRAC-1:0] u_cm_x, join_x;
    wire [Y_W+FRAC-1:0] u_cm_y, join_y;
    wire [RADIX_W-1:0]  u_g, join_g;
    wire [SUP_W-1:0]    v_support, join_support;
    wire [LIFE_W-1:0]   v_deadline;
    wire [TC_W-1:0]     v_grant;
    wire [RADIX_W+1:0]  v_rel_x, v_rel_y;
    wire [TIME_W-1:0]   ended_time;

    array_update #(
        .N      (N),
        .FAR    (FAR),
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
        .SLOT_W (SLOT_W),
        .AT_X   (AT_X),
        .AT_Y   (AT_Y)
    ) u_update (
        .clk           (clk),
        .rst           (rst),
        .cfg_valid     (cfg_valid),
        .cfg_slot      (cfg_slot),
        .cfg_addr      (cfg_addr),
        .cfg_data      (cfg_data),
        .d_x           (d_x),
        .d_y           (d_y),
        .d_slot        (d_slot),
        .c_slots       (c_slots),
        .c_slots_not   (c_slots_not),
        .c_commits     (c_commits),
        .c_takes       (c_takes),
        .c_active      (c_active),
        .c_seeds       (c_seeds),
        .c_x           (c_x),
        .c_y           (c_y),
        .c_report      (c_report),
        .c_clear       (c_clear),
        .c_join        (c_join),
        .c_looks       (c_looks),
        .looks_max     (!on_detect),
        .join_x        (join_x),
        .join_y        (join_y),
        .join_g        (join_g),
        .join_support  (join_support),
        .u_special     (u_special),
        .u_busy        (u_busy),
        .u_cm_x        (u_cm_x),
        .u_cm_y        (u_cm_y),
        .u_g           (u_g),
        .v_busy        (v_busy),
        .v_slot        (v_slot),
        .v_id          (v_id),
        .v_support     (v_support),
        .v_timed       (v_timed),
        .v_deadline    (v_deadline),
        .v_on          (v_on),
        .v_grant       (v_grant),
        .v_rel_x       (v_rel_x),
        .v_rel_y       (v_rel_y),
        .w_busy        (w_busy),
        .w_checks      (w_checks),
        .w_places      (w_places),
        .w_changes     (w_changes),
        .w_born        (w_born),
        .w_slot        (w_slot),
        .w_lo_x_not    (w_lo_x_not),
        .w_hi_x        (w_hi_x),
        .w_lo_y_not    (w_lo_y_not),
        .w_hi_y        (w_hi_y),
        .w_free        (w_free),
        .w_window      (w_window),
        .w_active      (w_active),
        .lost          (why != MERGE),
        .other         (stays_id),
        .seq           (seq),
        .now           (now),
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

    wire              ended, done;
    reg               walks, reports, goes_active, joinable, survey, start, walked, take_a, take_b;
    wire [SLOT_W-1:0] ended_slot, stays, goes;

    array_lives #(
        .TC_W   (TC_W),
        .TIME_W (TIME_W),
        .LIFE_W (LIFE_W),
        .CLOCK_W(CLOCK_W),
        .SLOT_W (SLOT_W)
    ) u_lives (
        .clk         (clk),
        .rst         (rst),
        .m_time      (m_time[LIFE_W-1:0]),
        .m_due       (m_due),
        .walks       (walks),
        .survey      (survey),
        .surveys     (surveys),
        .start       (start),
        .step        (v_walks),
        .finish      (walked && !surveys && !ended),
        .now         (now),
        .slot        (v_slot),
        .timed       (v_timed),
        .deadline    (v_deadline),
        .on          (v_on),
        .grant       (v_grant),
        .ended       (ended),
        .ended_slot  (ended_slot),
        .ended_time  (ended_time)
    );

    wire second_first;

    array_order #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_order (
        .clk         (clk),
        .rst         (rst),
        .asked       (v_busy || phase == FETCH),
        .slot        (v_slot),
        .born        (w_born),
        .second_first(second_first)
    );

    array_merge #(
        .POS_X  (X_W + FRAC),
        .POS_Y  (Y_W + FRAC),
        .ROUND  (FRAC > 0),
        .RADIX_W(RADIX_W),
        .SUP_W  (SUP_W),
        .ID_W   (ID_W),
        .SLOT_W (SLOT_W),
        .MEANS  (FAR != 0 ? 2 : 1)
    ) u_merge (
        .clk         (clk),
        .take_a      (take_a),
        .take_b      (take_b),
        .slot        (v_slot),
        .id          (v_id),
        .cm_x        (u_cm_x),
        .cm_y        (u_cm_y),
        .g           (u_g),
        .support     (v_support),
        .b_first     (second_first),
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

    array_output #(
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
        .s_seq       (seq),
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

    reg              settled;               // no operation is under way, no window changes
    reg              mode_written;          // a clock ago, of this slot
    reg [SLOT_W-1:0] mode_slot;
    reg              restart_due;           // some slot is to be restarted, or was a clock ago
    reg              restarting, restarts;  // some slot is to be restarted, this one next
    reg [SLOT_W-1:0] restart_slot;

    wire              restart_any;
    wire [SLOT_W-1:0] restart_lowest;

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_restart (
        .asked (1'b1),
        .among (restart),
        .any   (restart_any),
        .lowest(restart_lowest)
    );

    wire operates = o_busy || d_busy || c_busy || u_busy;
    wire checks   = m_check || e_check || found;

    // The first token behind lives that have ended finds nobody in U.
    wire c_early   = stale || (c_due && (!exempt || u_valid));
    assign c_commits = c_valid && !rewind && !c_early;

    assign commit = u_valid;
    assign rewind = u_ends || u_special || found || stalled;
    assign issue  = token_valid && !closed && !rewound;

    // ---- tokens ----------------------------------------------------------------------------------------------------

    wire owned = d_active || d_other || d_free;

    generate
        if (FAR != 0) begin : g_far
            always @(posedge clk) begin
                d_valid  <= e_valid && !rewind;
                d_there  <= e_valid;
                d_due    <= e_due;
                d_event  <= e_event;
                d_counts <= e_counts;
                d_x      <= e_x;
                d_y      <= e_y;
                d_p      <= e_p;
                d_time   <= e_time;
                d_busy   <= o_busy;
                d_report <= o_report;
                d_clear  <= o_clear;
                d_join   <= o_join;
                d_looks  <= o_looks;
                if (rst) {d_valid, d_busy, d_report, d_clear, d_join} <= 5'd0;
            end
        end else begin : g_near
            always @* begin
                d_valid  = e_valid && !rewind;
                d_there  = e_valid;
                d_due    = e_due;
                d_event  = e_event;
                d_counts = e_counts;
                d_x      = e_x;
                d_y      = e_y;
                d_p      = e_p;
                d_time   = e_time;
                d_busy   = o_busy;
                d_report = o_report;
                d_clear  = o_clear;
                d_join   = o_join;
                d_looks  = o_looks;
            end
        end
    endgenerate

    always @(posedge clk) begin
        // A token, or in its place a window that has changed.
        m_valid  <= issue;
        m_check  <= w_checks;
        m_self   <= w_slot;
        m_lo_x_not <= w_checks ? w_lo_x_not : {1'b0, {(AT_X - X_W - 1) {1'b1}}, ~token_x};
        m_hi_x   <= w_checks ? w_hi_x : {1'b1, {(AT_X - X_W - 1) {1'b0}}, token_x};
        m_lo_y_not <= w_checks ? w_lo_y_not : {1'b0, {(AT_Y - Y_W - 1) {1'b1}}, ~token_y};
        m_hi_y   <= w_checks ? w_hi_y : {1'b1, {(AT_Y - Y_W - 1) {1'b0}}, token_y};
        m_time   <= token_time;
        m_counts <= token_counts;
        m_event  <= token_event;
        m_p      <= token_p;

        rewound  <= rewind;
        e_valid  <= m_valid && !rewind && !rewound;
        e_check  <= m_check;
        e_self   <= m_self;
        e_due    <= m_due;
        e_x      <= m_hi_x[X_W-1:0];
        e_y      <= m_hi_y[Y_W-1:0];
        e_time   <= m_time;
        e_counts <= m_counts;
        e_event  <= m_event;
        e_p      <= m_p;

        found <= e_check && e_other;
        if (e_check) begin
            moved      <= e_self;
            found_slot <= e_lowest;
        end

        c_valid  <= d_valid && !rewind;
        c_due    <= d_due;
        c_takes  <= d_there && d_event && owned;
        c_passes <= d_event && !owned;
        c_active <= d_active;
        c_seeds  <= d_there && !d_active && !d_other;
        c_x      <= d_x;
        c_y      <= d_y;
        c_time   <= d_time;
        c_counts <= d_counts;
        c_p      <= d_p;
        c_busy   <= d_busy;
        c_report <= d_report;
        c_clear  <= d_clear;
        c_join   <= d_join;
        c_looks  <= d_looks;

        o_looks  <= phase == FETCH || (phase == WALK && step < SLOTS[STEP_W-1:0]);

        u_valid  <= c_commits;
        u_ends   <= c_valid && !rewind && c_early;
        u_takes  <= c_takes;
        u_passes <= c_passes;
        u_x      <= c_x;
        u_y      <= c_y;
        u_time   <= c_time;
        u_counts <= c_counts;
        u_p      <= c_p;
        u_walks  <= c_looks && phase == WALK;

        v_decided <= commit && (u_takes || u_passes);
        v_owned   <= u_takes;
        v_walks   <= u_walks;
        v_x       <= u_x;
        v_y       <= u_y;
        v_p       <= u_p;

        if (rst) begin
            {m_valid, e_valid, c_valid, u_valid, u_ends, m_check, e_check, found, rewound, v_decided} <= 10'd0;
            {c_busy, c_report, c_clear, c_join} <= 4'd0;
        end
    end

    // ---- control ---------------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        if (u_valid || u_ends) now <= u_time;
        if (commit) exempt <= 1'b0;
        if (commit && u_counts) next_seq <= next_seq + 1'b1;
        if (commit || u_ends || restarts) seq <= next_seq;
        stalled <= m_cm_valid && !m_cm_ready;
        closed  <= phase != RUN || operates || v_busy || !room || restart_due;
        walks   <= phase == WALK;
        reports <= phase == REPORT;
        goes_active <= active[slow_slot];
        joinable <= done;
        walked  <= 1'b0;
        {survey, start, take_a, take_b} <= 4'd0;

        idle <= 1'b0;
        if (input_empty)
            idle <= !s_valid && !cfg_valid && phase == RUN && settled && !checks && !restart_due && !v_decided
                 && output_empty && !m_cm_valid;

        {o_busy, o_report, o_clear, o_join} <= 4'd0;
        settled      <= !(operates || u_special || v_busy || w_busy);
        restart_due  <= restart_any || mode_written || (cfg_valid && cfg_addr == `EVCOT_REG_MODE);
        restarting   <= restart_any;
        restart_slot <= restart_lowest;
        restarts     <= 1'b0;
        if (restarting)
            restarts <= phase == RUN && !restarts && settled && !checks
                     && !m_valid && !e_valid && !d_valid && !c_valid && !u_valid && !u_ends;

        step <= step + 1'b1;
        case (phase)
            RUN: begin
                step <= {STEP_W{1'b0}};
                if (found) begin
                    slow_slot <= moved;
                    phase     <= FETCH;
                end else if (u_ends) begin
                    stale     <= 1'b0;
                    surveys   <= stale;
                    on_detect <= 1'b0;
                    slow_slot <= {SLOT_W{1'b0}};
                    phase     <= WALK;
                end else if (restarts) begin
                    why       <= RESTART;
                    slow_slot <= restart_slot;
                    phase     <= REPORT;
                end
            end
            WALK: begin
                survey <= step == {STEP_W{1'b0}} && surveys && !on_detect;
                start  <= step == {STEP_W{1'b0}} && !surveys;
                walked <= step == WALKED[STEP_W-1:0];
                slow_slot <= slow_slot + 1'b1;
                if (walked && surveys) begin
                    step      <= {STEP_W{1'b0}};
                    slow_slot <= {SLOT_W{1'b0}};
                    on_detect <= 1'b1;
                    surveys   <= !on_detect;
                end else if (walked) begin
                    why       <= LIFE;
                    slow_slot <= ended_slot;
                    exempt    <= !ended;
                    phase     <= ended ? REPORT : RUN;
                end
            end
            FETCH: begin
                take_a    <= step == FIRST_AT[STEP_W-1:0];
                take_b    <= step == OTHER_AT[STEP_W-1:0];
                slow_slot <= found_slot;
                if (step == FETCHED[STEP_W-1:0]) begin
                    why       <= MERGE;
                    slow_slot <= goes;
                    phase     <= REPORT;
                end
            end
            REPORT:
            if (reports && !m_cm_valid) begin
                if (goes_active) begin
                    {o_busy, o_report} <= 2'b11;
                    settled            <= 1'b0;
                end
                phase <= CLEAR;
            end
            CLEAR:
            if (settled) begin
                {o_busy, o_clear} <= 2'b11;
                settled           <= 1'b0;
                phase             <= (why == RESTART) ? RUN : SETTLE;
            end
            SETTLE:
            if (settled) begin
                step      <= {STEP_W{1'b0}};
                slow_slot <= (why == LIFE) ? {SLOT_W{1'b0}} : stays;
                phase     <= (why == LIFE) ? WALK : JOIN;
            end
            JOIN:
            if (joinable && !m_cm_valid) begin
                {o_busy, o_join} <= 2'b11;
                settled          <= 1'b0;
                phase            <= RUN;
            end
            default: phase <= RUN;
        endcase

        mode_written <= cfg_valid && cfg_addr == `EVCOT_REG_MODE;
        mode_slot    <= cfg_slot;
        restart      <= (restart & ~(restarts ? FIRST << restart_slot : NONE)) | (mode_written ? FIRST << mode_slot : NONE);
        if (cfg_valid) stale <= 1'b1;

        if (rst) begin
            phase   <= RUN;
            now     <= {CLOCK_W{1'b0}};
            next_seq <= {SEQ_W{1'b0}};
            mode_written <= 1'b0;
            restart    <= {N{1'b1}};
            restart_due <= 1'b1;
            restarting <= 1'b0;
            restarts   <= 1'b0;
            stale   <= 1'b1;
            exempt  <= 1'b0;
            stalled <= 1'b0;
            closed  <= 1'b1;
            settled <= 1'b1;
            {o_busy, o_report, o_clear, o_join} <= 4'd0;
            idle    <= 1'b0;
        end
    end

endmodule

`default_nettype wire
