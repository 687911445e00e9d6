// SPDX-License-Identifier: Apache-2.0
// N cluster trackers with boxes and velocities, which meet without merging: the array with the rules of docs/motion.md.
//
// Tokens and streams are those of cot_array.v, but for the record. Events are decided in a pipeline, motion_events.v, one a clock. They and
// the motion steps of slots cause jobs, motion_jobs.v, which are computed beside it, motion_work.v, one after the other. What has been
// computed takes effect later: tokens wait only for a job that is not done by then.
//
// Registers: `mode` of each slot, off or seeded, and those of motion_regs.v. A write of `mode` restarts the slot before the next
// token; after a change of `step_log2` a period begins at the next multiple of the new length. Others are to be written while the array
// is idle.
//
// Latency:    unstalled, from the clock edge that takes the event: 15 clocks to the owned or passed event; about 50 to its record.
// Throughput: an event a clock; 5 clocks more where a slot takes effect, and 13 for a motion step, before which the pipeline runs empty.
//             Jobs: see motion_correct.v and motion_step.v.
// Stall:      every output is held until accepted.
// Reset:      turns all slots off, and gives the registers their defaults; then memories are cleared, for 2^(W + 1) clocks of the larger
//             address width W, in which no token is accepted. If an upset has stopped the streams, a watchdog resets all but the registers.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"
`include "motion_fields.vh"

module cot_motion #(
    parameter N       = 8,   // tracker slots
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter TICK_W  = 20,  // bits of the tick input
    parameter RADIX_W = 8,   // two less than the bits of a recentred address
    parameter SUP_W   = 16,  // bits of a support count
    parameter ID_W    = 32,  // bits of a track id
    parameter SEQ_W   = 48,  // bits of an event's sequence number
    parameter TIME_W  = 48,  // bits of the tick count
    parameter OWNERS  = 0,   // 1: owned events leave with m_own_visible and m_own_id; else both are 0
    parameter SLOT_W  = (N > 1) ? $clog2(N) : 1,  // derived: leave it alone
    parameter REACH   = (X_W > Y_W) ? (X_W > 9 ? X_W : 9) : (Y_W > 9 ? Y_W : 9),  // derived: leave it alone
    parameter SIDE_W  = REACH + 16                // derived: leave it alone
) (
    input  wire                clk,
    input  wire                rst,

    // registers
    input  wire                cfg_valid,
    input  wire [SLOT_W-1:0]   cfg_slot,     // of `mode`
    input  wire [`EVCOT_MREG_W-1:0] cfg_addr,
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

    // boxes: one record per birth, move, merge and loss
    output wire                m_cm_valid,
    input  wire                m_cm_ready,
    output wire [1:0]          m_cm_kind,
    output wire [SLOT_W-1:0]   m_cm_slot,
    output wire [ID_W-1:0]     m_cm_id,
    output wire [ID_W-1:0]     m_cm_other,   // MERGED: the track that stays; else 0
    output wire [SIDE_W-1:0]   m_cm_x,       // middle, 2^-12 px, signed
    output wire [SIDE_W-1:0]   m_cm_y,
    output wire [SIDE_W-1:0]   m_cm_width,   // 2^-12 px
    output wire [SIDE_W-1:0]   m_cm_height,
    output wire [15:0]         m_cm_v_x,     // 2^-12 px per motion step, signed
    output wire [15:0]         m_cm_v_y,
    output wire [9:0]          m_cm_n_ev,
    output wire [SUP_W-1:0]    m_cm_support,
    output wire [SEQ_W-1:0]    m_cm_seq,
    output wire [TIME_W-1:0]   m_cm_time,

    // owned events, addressed from the middle of the owner's box, half pixels, signed
    output wire                m_own_valid,
    input  wire                m_own_ready,
    output wire [SLOT_W-1:0]   m_own_slot,
    output wire [RADIX_W+1:0]  m_own_x,
    output wire [RADIX_W+1:0]  m_own_y,
    output wire                m_own_p,
    output wire [SEQ_W-1:0]    m_own_seq,
    output wire                m_own_visible,  // the owner is a track, not a candidate
    output wire [ID_W-1:0]     m_own_id,       // that track, if visible

    // events that no slot took
    output wire                m_pass_valid,
    input  wire                m_pass_ready,
    output wire [X_W-1:0]      m_pass_x,
    output wire [Y_W-1:0]      m_pass_y,
    output wire                m_pass_p,
    output wire [SEQ_W-1:0]    m_pass_seq,

    output reg                 idle          // nothing inside, no register write under way; two clocks late where it rises
);

    parameter_check #(.OK(N >= `EVCOT_N_SLOTS_MIN && N <= `EVCOT_N_SLOTS_MAX)) N_must_be_1_to_64 ();
    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(RADIX_W >= `EVCOT_RADIX_W_MIN && RADIX_W <= `EVCOT_RADIX_W_MAX)) RADIX_W_must_be_1_to_12 ();
    parameter_check #(.OK(SUP_W >= `EVCOT_SUP_W_MIN && SUP_W <= `EVCOT_SUP_W_MAX)) SUP_W_must_be_1_to_32 ();
    parameter_check #(.OK(ID_W >= `EVCOT_ID_W_MIN && ID_W <= `EVCOT_ID_W_MAX)) ID_W_must_be_1_to_32 ();
    parameter_check #(.OK(SEQ_W >= `EVCOT_SEQ_W_MIN && SEQ_W <= `EVCOT_SEQ_W_MAX)) SEQ_W_must_be_8_to_48 ();
    parameter_check #(.OK(TIME_W >= 32 && TIME_W <= `EVCOT_TIME_W_MAX)) TIME_W_must_be_32_to_48 ();
    parameter_check #(.OK(TIME_W > TICK_W)) TIME_W_must_be_more_than_TICK_W ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();
    parameter_check #(.OK(OWNERS == 0 || OWNERS == 1)) OWNERS_must_be_0_or_1 ();
    parameter_check #(.OK(SIDE_W == REACH + 16)) SIDE_W_must_be_left_at_its_default ();

    localparam PX_W  = SIDE_W - 12;  // bits of a bound in pixels
    localparam REL_W = RADIX_W + 2;

    // A step is at most 2^20 ticks after the token before, a token at most 2^TICK_W - 1: more bits do not count between them.
    localparam AHEAD_W = (TICK_W > 20 ? TICK_W : 20) + 2;
    localparam DUE_W   = AHEAD_W < TIME_W ? AHEAD_W : TIME_W;

    // ---- registers -------------------------------------------------------------------------------------------------

    wire [`MOTION_REGS_W-1:0] regs;

    motion_regs u_regs (
        .clk            (clk),
        .rst            (rst),
        .cfg_valid      (cfg_valid),
        .cfg_addr       (cfg_addr),
        .cfg_data       (cfg_data),
        .regs           (regs)
    );

    // ---- watchdog ----------------------------------------------------------------------------------------------------

    // Clocks in which nothing moves: more than any job takes, and more than the memories are cleared for.
    localparam WORST_W = (X_W > Y_W ? X_W : Y_W) + 2;
    localparam STUCK_W = WORST_W > 14 ? WORST_W : 14;

    reg [STUCK_W-1:0] still_clocks;
    reg               stuck, held;
    wire              holds, job_done;
    wire              restart = rst || stuck;

    // A motion step moves time. An output that is not accepted waits for its user.
    always @(posedge clk) begin
        held         <= holds;
        still_clocks <= still_clocks + {{(STUCK_W - 1) {1'b0}}, 1'b1};
        if (idle || job_done || (holds && !held) || (s_valid && s_ready) || m_cm_valid || m_own_valid || m_pass_valid) begin
            still_clocks <= {STUCK_W{1'b0}};
        end
        stuck <= &still_clocks;
        if (restart) {still_clocks, stuck, held} <= {(STUCK_W + 2) {1'b0}};
    end

    // ---- tokens ------------------------------------------------------------------------------------------------------

    wire [TIME_W-1:0] now, next_step;
    wire              q_valid, q_due, q_runs, q_late, q_far, q_event, q_skip, q_p, q_burst, q_empty;
    wire [TIME_W-1:0] q_time;
    wire [X_W-1:0]    q_x;
    wire [Y_W-1:0]    q_y;
    wire              takes_token;
    wire [DUE_W-1:0]  due_tick;
    wire              masks_ready;
    wire [X_W-1:0]    next_x;
    wire [Y_W-1:0]    next_y;

    motion_queue #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .TICK_W(TICK_W),
        .TIME_W(TIME_W),
        .DUE_W (DUE_W)
    ) u_queue (
        .clk      (clk),
        .rst      (restart),
        .opens    (masks_ready),
        .s_valid  (s_valid),
        .s_ready  (s_ready),
        .s_tick   (s_tick),
        .s_event  (s_event),
        .s_skip   (s_skip),
        .s_x      (s_x),
        .s_y      (s_y),
        .s_p      (s_p),
        .next_step(next_step),
        .holds    (holds),
        .due_tick (due_tick),
        .now      (now),
        .m_valid  (q_valid),
        .m_ready  (takes_token),
        .m_due    (q_due),
        .m_runs   (q_runs),
        .m_late   (q_late),
        .m_far    (q_far),
        .m_time   (q_time),
        .m_event  (q_event),
        .m_skip   (q_skip),
        .m_x      (q_x),
        .m_y      (q_y),
        .m_p      (q_p),
        .m_burst  (q_burst),
        .next_x   (next_x),
        .next_y   (next_y),
        .empty    (q_empty)
    );

    // ---- what comes next ---------------------------------------------------------------------------------------------

    wire              room, output_empty, quiet, active;
    wire              d_valid, d_event, d_owned, d_p, d_visible;
    wire [SLOT_W-1:0] d_slot;
    wire [REL_W-1:0]  d_rel_x, d_rel_y;
    wire [X_W-1:0]    d_x;
    wire [Y_W-1:0]    d_y;
    wire [TIME_W-1:0] d_time, work_time;
    wire [SEQ_W-1:0]  d_seq;
    wire [N-1:0]      seeded, alive, corrects, e_ended, due_ended;
    wire              works, op_step, op_effect, op_clear, effect_done, effects, e_own;
    wire              step_real, step_pauses, step_ends, ready, j_valid;
    wire              due_valid, due_any, due_own, job_room, collides;
    wire [SLOT_W-1:0] e_slot, work_slot, due_slot;
    wire [7:0]        due_event;

    motion_turn #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .TIME_W(TIME_W),
        .DUE_W (DUE_W)
    ) u_turn (
        .clk        (clk),
        .rst        (restart),
        .cfg_rst    (rst),
        .cfg_valid  (cfg_valid),
        .cfg_slot   (cfg_slot),
        .cfg_addr   (cfg_addr),
        .cfg_data   (cfg_data[4:0]),
        .step_log2  (regs[`MOTION_STEP_LOG2]),
        .seeded     (seeded),
        .q_due      (q_due),
        .q_runs     (q_runs),
        .q_late     (q_late),
        .q_far      (q_far),
        .q_event    (q_event),
        .q_counts   (q_event || q_skip),
        .room       (room && job_room && !collides),
        .takes_token(takes_token),
        .holds      (holds),
        .d_valid    (d_valid),
        .d_time     (d_time),
        .now        (now),
        .next_step  (next_step),
        .op_clear   (op_clear),
        .active     (active || j_valid),
        .op_step    (op_step),
        .op_effect  (op_effect),
        .effect_done(effect_done),
        .effects    (effects),
        .e_slot     (e_slot),
        .e_own      (e_own),
        .e_ended    (e_ended),
        .alive      (alive),
        .corrects   (corrects),
        .work_slot  (work_slot),
        .work_time  (work_time),
        .works      (works),
        .job_real   (step_real),
        .job_pauses (step_pauses),
        .job_ends   (step_ends),
        .due_valid  (due_valid),
        .due_any    (due_any),
        .due_slot   (due_slot),
        .due_event  (due_event),
        .due_tick   (due_tick),
        .ready      (ready),
        .due_own    (due_own),
        .due_ended  (due_ended),
        .quiet      (quiet)
    );

    reg calm, still;  // nothing is under way but what comes, or has come in the clock before
    reg comes;
    reg none;   // what `idle` says, a clock earlier but for what comes
    wire jobs_idle;

    always @(posedge clk) begin
        calm  <= quiet && q_empty;
        still <= !active && !j_valid && jobs_idle && output_empty && !m_cm_valid;
        comes <= s_valid || cfg_valid;
        none  <= calm && still && !comes && !s_valid && !cfg_valid;
        idle  <= none && !s_valid && !cfg_valid;
        if (restart) {calm, still, none, idle} <= 4'b0000;
    end

    // ---- events --------------------------------------------------------------------------------------------------------

    wire [1:0]          j_kind;
    wire [4*SIDE_W-1:0] j_sides;
    wire [3:0]          j_marks;
    wire [SUP_W-1:0]    j_owned;
    wire                j_burst;
    wire [1:0]          e_state;
    wire [4*SIDE_W-1:0] e_moves;
    wire [3:0]          e_marks, e_hidden;
    wire [2*REL_W-1:0]  e_middle;
    wire                mask, mask_busy;
    wire [SLOT_W-1:0]   job_slot;
    reg  [SLOT_W-1:0]   mask_slot;  // the same a clock later: a job has been there for longer before it is asked for
    wire [4*PX_W-1:0]   box, window;
    wire [9:0]          e_n_ev, bin_log2;
    wire [SLOT_W-1:0]   at, bin_slot;  // the slot that is worked on
    wire                bin_count, bin_clear, in_bin_x, in_bin_y;
    wire [3:0]          op_bin, bin_cleared, bin_x, bin_y;

    always @(posedge clk) mask_slot <= job_slot;

    motion_events #(
        .N      (N),
        .SLOT_W (SLOT_W),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .SIDE_W (SIDE_W),
        .PX_W   (PX_W),
        .RADIX_W(RADIX_W),
        .SUP_W  (SUP_W),
        .SEQ_W  (SEQ_W),
        .TIME_W (TIME_W)
    ) u_events (
        .clk        (clk),
        .rst        (restart),
        .ready      (masks_ready),
        .s_valid    (takes_token),
        .s_event    (q_event),
        .s_skip     (q_skip),
        .s_x        (q_x),
        .s_y        (q_y),
        .s_p        (q_p),
        .s_burst    (q_burst),
        .s_time     (works ? work_time : q_time),
        .next_x     (next_x),
        .next_y     (next_y),
        .collides   (collides),
        .mask       (mask),
        .mask_slot  (mask_slot),
        .mask_box   (box),
        .mask_window(window),
        .mask_busy  (mask_busy),
        .op_step    (op_step),
        .op_effect  (op_effect),
        .op_clear   (op_clear),
        .op_slot    (op_clear ? at : op_effect ? due_slot : work_slot),
        .op_bin     (op_bin),
        .effect_done(effect_done),
        .active     (active),
        .e_own      (e_own),
        .e_ended    (e_ended),
        .e_state    (e_state),
        .e_moves    (e_moves),
        .e_marks    (e_marks),
        .e_hidden   (e_hidden),
        .e_middle   (e_middle),
        .e_n_ev     (e_n_ev),
        .bin_log2   (bin_log2),
        .regs       (regs),
        .seeded     (seeded),
        .corrects   (corrects),
        .alive      (alive),
        .d_valid    (d_valid),
        .d_event    (d_event),
        .d_owned    (d_owned),
        .d_slot     (d_slot),
        .d_rel_x    (d_rel_x),
        .d_rel_y    (d_rel_y),
        .d_x        (d_x),
        .d_y        (d_y),
        .d_p        (d_p),
        .d_time     (d_time),
        .d_seq      (d_seq),
        .d_visible  (d_visible),
        .j_valid    (j_valid),
        .j_kind     (j_kind),
        .j_sides    (j_sides),
        .j_marks    (j_marks),
        .j_owned    (j_owned),
        .j_burst    (j_burst),
        .bin_count  (bin_count),
        .bin_clear  (bin_clear),
        .bin_slot   (bin_slot),
        .bin_cleared(bin_cleared),
        .in_bin_x   (in_bin_x),
        .in_bin_y   (in_bin_y),
        .bin_x      (bin_x),
        .bin_y      (bin_y)
    );

    // ---- jobs ----------------------------------------------------------------------------------------------------------

    wire                job_valid, job_real, job_flag, job_waits, finish, ends;
    wire [1:0]          job_kind;
    wire [X_W-1:0]      job_x;
    wire [Y_W-1:0]      job_y;
    wire [4*SIDE_W-1:0] job_sides;
    wire [3:0]          job_marks;
    wire [SUP_W-1:0]    job_owned, support;
    wire [SEQ_W-1:0]    job_seq;
    wire [TIME_W-1:0]   job_time;

    motion_jobs #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .SIDE_W(SIDE_W),
        .SUP_W (SUP_W),
        .SEQ_W (SEQ_W),
        .TIME_W(TIME_W),
        .DUE_W (DUE_W)
    ) u_jobs (
        .clk       (clk),
        .rst       (restart),
        .j_valid   (j_valid),
        .j_real    (!j_kind[1] || step_real),
        .j_flag    (j_kind[1] ? step_pauses : j_burst),
        .j_kind    (j_kind | {1'b0, j_kind[1] && step_ends}),
        .j_slot    (d_slot),
        .j_x       (d_x),
        .j_y       (d_y),
        .j_sides   (j_sides),
        .j_marks   (j_marks),
        .j_owned   (j_owned),
        .j_seq     (d_seq),
        .j_time    (d_time),
        .room      (job_room),
        .job_valid (job_valid),
        .job_done  (job_done),
        .job_real  (job_real),
        .job_flag  (job_flag),
        .job_kind  (job_kind),
        .job_slot  (job_slot),
        .job_waits (job_waits),
        .job_x     (job_x),
        .job_y     (job_y),
        .job_sides (job_sides),
        .job_marks (job_marks),
        .job_owned (job_owned),
        .job_seq   (job_seq),
        .job_time  (job_time),
        .finish    (finish),
        .ends      (ends),
        .ends_slot (at),
        .mask      (mask),
        .mask_busy (mask_busy),
        .idle      (jobs_idle),
        .due_valid (due_valid),
        .due_any   (due_any),
        .due_slot  (due_slot),
        .due_event (due_event),
        .due_tick  (due_tick),
        .ready     (ready),
        .due_own   (due_own),
        .due_ended (due_ended),
        .due_taken (op_effect)
    );

    // ---- gaps --------------------------------------------------------------------------------------------------------

    wire            look, look_y, look_done, gap_found, low_stays;
    wire [4:0]      look_log2;
    wire [PX_W-1:0] narrowest;
    wire [3:0]      gap_begins, gap_ends;

    motion_gaps #(
        .PX_W  (PX_W),
        .SLOT_W(SLOT_W)
    ) u_gaps (
        .clk      (clk),
        .rst      (restart),
        .slot     (bin_slot),
        .count    (bin_count),
        .in_x     (in_bin_x),
        .in_y     (in_bin_y),
        .bin_x    (bin_x),
        .bin_y    (bin_y),
        .clear    (bin_clear),
        .cleared  (bin_cleared),
        .look     (look),
        .look_slot(at),
        .on_y     (look_y),
        .bin_log2 (look_log2),
        .narrowest(narrowest),
        .gap_share(regs[`MOTION_GAP_SHARE]),
        .done     (look_done),
        .found    (gap_found),
        .low_stays(low_stays),
        .begins   (gap_begins),
        .ends     (gap_ends)
    );

    // ---- work, and its records -----------------------------------------------------------------------------------------

    wire                say, record_free;
    wire [1:0]          kind;
    wire [ID_W-1:0]     id, stays_id;
    wire [SIDE_W:0]     sum_x, sum_y;
    wire [SIDE_W-1:0]   side_x, side_y;
    wire [15:0]         v_x, v_y;
    wire [9:0]          n_ev;

    motion_work #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .SIDE_W(SIDE_W),
        .PX_W  (PX_W),
        .REL_W (REL_W),
        .SUP_W (SUP_W),
        .ID_W  (ID_W),
        .TIME_W(TIME_W)
    ) u_work (
        .clk            (clk),
        .rst            (restart),
        .job_valid      (job_valid),
        .job_done       (job_done),
        .job_real       (job_real),
        .job_flag       (job_flag),
        .job_kind       (job_kind),
        .job_slot       (job_slot),
        .job_waits      (job_waits),
        .job_x          (job_x),
        .job_y          (job_y),
        .job_sides      (job_sides),
        .job_marks      (job_marks),
        .job_owned      (job_owned),
        .job_time       (job_time),
        .finish         (finish),
        .ends           (ends),
        .mask           (mask),
        .box            (box),
        .window         (window),
        .mask_busy      (mask_busy),
        .e_slot         (effects ? e_slot : due_slot),
        .e_state        (e_state),
        .e_moves        (e_moves),
        .e_marks        (e_marks),
        .e_hidden       (e_hidden),
        .e_middle       (e_middle),
        .e_n_ev         (e_n_ev),
        .op_clear       (op_clear),
        .op_bin         (op_bin),
        .bin_log2       (bin_log2),
        .look           (look),
        .look_y         (look_y),
        .look_log2      (look_log2),
        .narrowest      (narrowest),
        .look_done      (look_done),
        .gap_found      (gap_found),
        .low_stays      (low_stays),
        .gap_begins     (gap_begins),
        .gap_ends       (gap_ends),
        .say            (say),
        .record_free    (record_free),
        .kind           (kind),
        .at             (at),
        .id             (id),
        .stays_id       (stays_id),
        .sum_x          (sum_x),
        .sum_y          (sum_y),
        .side_x         (side_x),
        .side_y         (side_y),
        .v_x            (v_x),
        .v_y            (v_y),
        .n_ev           (n_ev),
        .support        (support),
        .regs           (regs)
    );

    motion_record #(
        .SLOT_W(SLOT_W),
        .SIDE_W(SIDE_W),
        .SUP_W (SUP_W),
        .ID_W  (ID_W),
        .SEQ_W (SEQ_W),
        .TIME_W(TIME_W)
    ) u_record (
        .clk         (clk),
        .rst         (restart),
        .say         (say),
        .free        (record_free),
        .kind        (kind),
        .slot        (at),
        .id          (id),
        .stays_id    (stays_id),
        .sum_x       (sum_x),
        .sum_y       (sum_y),
        .side_x      (side_x),
        .side_y      (side_y),
        .v_x         (v_x),
        .v_y         (v_y),
        .n_ev        (n_ev),
        .support     (support),
        .seq         (job_seq),
        .now         (job_time),
        .m_cm_valid  (m_cm_valid),
        .m_cm_ready  (m_cm_ready),
        .m_cm_kind   (m_cm_kind),
        .m_cm_slot   (m_cm_slot),
        .m_cm_id     (m_cm_id),
        .m_cm_other  (m_cm_other),
        .m_cm_x      (m_cm_x),
        .m_cm_y      (m_cm_y),
        .m_cm_width  (m_cm_width),
        .m_cm_height (m_cm_height),
        .m_cm_v_x    (m_cm_v_x),
        .m_cm_v_y    (m_cm_v_y),
        .m_cm_n_ev   (m_cm_n_ev),
        .m_cm_support(m_cm_support),
        .m_cm_seq    (m_cm_seq),
        .m_cm_time   (m_cm_time)
    );

    // ---- output ------------------------------------------------------------------------------------------------------

    // What is known of the owner of an event. A track says its id in a record before the first event that it owns, and the next one in
    // its slot after the last event.
    localparam OWNER_W = (OWNERS != 0) ? SLOT_W + ID_W + 1 : SLOT_W;

    wire [OWNER_W-1:0] d_owner, own_owner;

    generate
        if (OWNERS != 0) begin : g_owners
            reg [ID_W-1:0] ids [0:N-1];

            always @(posedge clk) if (say) ids[at] <= id;

            assign d_owner = {ids[d_slot], d_visible, d_slot};
            assign {m_own_id, m_own_visible} = own_owner[OWNER_W-1:SLOT_W];
        end else begin : g_slots
            assign d_owner = d_slot;
            assign {m_own_id, m_own_visible} = {(ID_W + 1) {1'b0}};

            wire unused_visible = &{1'b0, d_visible};
        end
    endgenerate

    assign m_own_slot = own_owner[SLOT_W-1:0];

    array_output #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .REL_W (REL_W),
        .SEQ_W (SEQ_W),
        .SLOT_W(OWNER_W)
    ) u_output (
        .clk         (clk),
        .rst         (restart),
        .s_valid     (d_valid && d_event),
        .s_owned     (d_owned),
        .s_slot      (d_owner),
        .s_rel_x     (d_rel_x),
        .s_rel_y     (d_rel_y),
        .s_x         (d_x),
        .s_y         (d_y),
        .s_p         (d_p),
        .s_seq       (d_seq),
        .m_own_valid (m_own_valid),
        .m_own_ready (m_own_ready),
        .m_own_slot  (own_owner),
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

    wire unused = &{1'b0, q_valid};  // what is there is due, or runs

endmodule

`default_nettype wire
