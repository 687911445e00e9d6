// SPDX-License-Identifier: Apache-2.0
// All that is done to a slot, one slot at a time: a candidate is placed, a correction computed, a motion step gone through.
//
// Three parts say what is done and when, one of them at a time: motion_correct.v, motion_step.v and, within a step, motion_merge.v. The
// others do it: the slot that is worked on is in motion_sides.v, motion_times.v and motion_slot.v. What events have changed of it comes
// with the job.
//
// Latency:    from job_valid to job_done: see motion_correct.v.
// Throughput: a job at a time; a step: see motion_step.v.
// Stall:      a job waits for its records to be accepted.
// Reset:      waits for a job.
// Combinational paths: job_slot -> ends.
`default_nettype none
`include "evcot_defs.vh"
`include "motion_fields.vh"

module motion_work #(
    parameter N      = 8,
    parameter SLOT_W = 3,
    parameter X_W    = 9,
    parameter Y_W    = 9,
    parameter SIDE_W = 25,
    parameter PX_W   = 13,
    parameter REL_W  = 10,  // bits of a recentred address, at most PX_W + 1
    parameter SUP_W  = 16,
    parameter ID_W   = 32,
    parameter TIME_W = 48
) (
    input  wire                clk,
    input  wire                rst,

    // a job, which stays until it is done: see motion_jobs.v
    input  wire                job_valid,
    output wire                job_done,
    input  wire                job_real,
    input  wire                job_flag,      // of a correction: its event is within a burst; of a step: a period was empty
    input  wire [1:0]          job_kind,
    input  wire [SLOT_W-1:0]   job_slot,
    input  wire                job_waits,
    input  wire [X_W-1:0]      job_x,         // of a seed,
    input  wire [Y_W-1:0]      job_y,
    input  wire [4*SIDE_W-1:0] job_sides,     // else: of that 0
    input  wire [3:0]          job_marks,
    input  wire [SUP_W-1:0]    job_owned,
    input  wire [TIME_W-1:0]   job_time,
    output wire                finish,        // it is, and something was computed
    output wire                ends,          // it ends `at`, another slot

    // masks of job_slot: see motion_match.v
    output wire                mask,
    output wire [4*PX_W-1:0]   box,
    output wire [4*PX_W-1:0]   window,
    input  wire                mask_busy,

    // what takes effect of e_slot, two clocks later
    input  wire [SLOT_W-1:0]   e_slot,
    output wire [1:0]          e_state,
    output wire [4*SIDE_W-1:0] e_moves,
    output wire [3:0]          e_marks,
    output wire [3:0]          e_hidden,
    output wire [2*REL_W-1:0]  e_middle,
    output wire [9:0]          e_n_ev,

    // a bin of `at` is cleared
    output wire                op_clear,
    output wire [3:0]          op_bin,
    output wire [9:0]          bin_log2,      // of its bins, y and x

    // the search for a gap: see motion_gaps.v
    output wire                look,
    output wire                look_y,
    output wire [4:0]          look_log2,
    output wire [PX_W-1:0]     narrowest,
    input  wire                look_done,
    input  wire                gap_found,
    input  wire                low_stays,
    input  wire [3:0]          gap_begins,
    input  wire [3:0]          gap_ends,

    // records: see motion_record.v
    output wire                say,
    input  wire                record_free,
    output wire [1:0]          kind,
    output wire [SLOT_W-1:0]   at,            // the slot that is worked on, or compared
    output wire [ID_W-1:0]     id,
    output wire [ID_W-1:0]     stays_id,
    output wire [SIDE_W:0]     sum_x,
    output wire [SIDE_W:0]     sum_y,
    output wire [SIDE_W-1:0]   side_x,
    output wire [SIDE_W-1:0]   side_y,
    output wire [15:0]         v_x,           // stated
    output wire [15:0]         v_y,
    output wire [9:0]          n_ev,
    output wire [SUP_W-1:0]    support,

    input  wire [`MOTION_REGS_W-1:0] regs  // registers: motion_fields.vh
);

    // ---- what is done, in order ----------------------------------------------------------------------------------------

    wire              begun, lane, q_meets, look_due, merged, fetch, of_job, looks, inverse_goes_on, too_long, window_soon, window_done;
    wire              silent, ended, older, later, dividing, enough, overdue, pair_done, alike, weaker, meet_done, held, touches, appears, meets;
    wire [5:0]        corrections;
    wire [SLOT_W-1:0] touched, returned, this_slot;
    wire [N-1:0]      nearby;
    wire [14:0]       speed_x, speed_y;
    wire [1:0]        since;
    wire              c_loads, c_load, c_begin_job, c_unite, c_seed, c_shrink, c_cut_high, c_cut_low, c_order, c_offset;
    wire              c_reflect, c_settle, c_cover_both, c_move, c_rub, c_shorten, c_invert, c_speed, c_correct, c_count;
    wire              c_begin_bins, c_place, c_note, c_compare, c_pair, c_part, c_ask, c_touch, c_meet, c_take, c_hold;
    wire              c_divide, c_by_life, c_keep, c_keep_window, c_keep_now, c_keep_until, c_keep_id, c_keep_start, c_ask_start;
    wire              c_resume, c_leaves, returns, ran, widest, c_follow, c_united;

    wire [31:0] v;         // velocity of the slot that is worked on: y, x
    reg [3:1] fetches;
    wire      read_done = fetches[3];
    reg was_read;          // what was read counts
    reg keeps_start;       // of the second axis
    reg may_return;
    reg resting;           // the velocity is 0
    localparam UNTIL_W = 32;    // bits of a deadline: as many as the shortest time has
    reg [UNTIL_W-1:0] paused;   // the length of all empty periods that do not count for deadlines
    reg [19:0] step_mask;       // the length of a period, less a tick
    wire [UNTIL_W:0] paused_next = {paused, 1'b1} + {{(UNTIL_W - 20) {1'b0}}, step_mask, 1'b1};
    reg [UNTIL_W-1:0] counted;  // job_time, as it counts for deadlines
    wire instant;          // no more than a tick since the last correction
    wire [1:0] state;
    wire [N-1:0] visible, candidate, left;

    always @(posedge clk) begin
        fetches    <= {fetches[2:1], fetch};
        keeps_start <= c_keep_start;
        may_return <= regs[`MOTION_RETURN_TICKS] != 24'd0;
        resting    <= v == 32'd0;
        step_mask  <= ~(20'hfffff << regs[`MOTION_STEP_LOG2]);  // as in motion_turn.v
        if (begun && job_flag && job_kind[1]) paused <= paused_next[UNTIL_W:1];
        counted    <= job_time[UNTIL_W-1:0] - paused;
        if (rst) begin
            paused  <= {UNTIL_W{1'b0}};
            fetches <= 3'd0;
        end
    end

    motion_order #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .ID_W  (ID_W)
    ) u_order (
        .clk         (clk),
        .rst         (rst),
        .job_valid   (job_valid),
        .job_done    (job_done),
        .job_real    (job_real),
        .job_kind    (job_kind),
        .job_slot    (job_slot),
        .begun       (begun),
        .ends        (ends),
        .finish      (finish),
        .state       (state),
        .visible     (visible),
        .candidate   (candidate),
        .left        (left),
        .at          (at),
        .this_slot   (this_slot),
        .fetch       (fetch),
        .read_next   (read_done),
        .read_done   (was_read),
        .op_clear    (op_clear),
        .op_bin      (op_bin),
        .say         (say),
        .record_free (record_free),
        .kind        (kind),
        .id          (id),
        .stays_id    (stays_id),
        .lane        (lane),
        .shrinks     (regs[`MOTION_SIDE_SHRINK] != 4'd0),
        .q_meets     (q_meets),
        .look_due    (look_due),
        .merged      (merged),
        .instant     (instant),
        .resting     (resting),
        .looks       (looks),
        .look_done   (look_done),
        .gap_found   (gap_found),
        .low_stays   (low_stays),
        .inverse_goes_on(inverse_goes_on),
        .too_long    (too_long),
        .window_soon (window_soon),
        .window_done (window_done),
        .mask_busy   (mask_busy),
        .meets       (meets),
        .silent      (silent),
        .ended       (ended),
        .older       (older),
        .later       (later),
        .dividing    (dividing),
        .enough      (enough),
        .overdue     (overdue),
        .pair_done   (pair_done),
        .alike       (alike),
        .weaker      (weaker),
        .keep_older  (regs[`MOTION_KEEP_OLDER]),
        .meet_done   (meet_done),
        .nearby      (nearby),
        .held        (held),
        .touches     (touches),
        .appears     (appears),
        .returns     (returns),
        .returned    (returned),
        .may_return  (may_return),
        .touched     (touched),
        .corrections (corrections),
        .loads       (c_loads),
        .load        (c_load),
        .begin_job   (c_begin_job),
        .of_job      (of_job),
        .unite       (c_unite),
        .seed        (c_seed),
        .shrink      (c_shrink),
        .cut_high    (c_cut_high),
        .cut_low     (c_cut_low),
        .order       (c_order),
        .offset      (c_offset),
        .reflect     (c_reflect),
        .settle      (c_settle),
        .cover_both  (c_cover_both),
        .move        (c_move),
        .rub         (c_rub),
        .shorten     (c_shorten),
        .invert      (c_invert),
        .speed       (c_speed),
        .correct     (c_correct),
        .leaves      (c_leaves),
        .count       (c_count),
        .begin_bins  (c_begin_bins),
        .place       (c_place),
        .widest      (widest),
        .note        (c_note),
        .compare     (c_compare),
        .pair        (c_pair),
        .part        (c_part),
        .ask         (c_ask),
        .touch       (c_touch),
        .meet        (c_meet),
        .take        (c_take),
        .hold        (c_hold),
        .divide      (c_divide),
        .by_life     (c_by_life),
        .keep        (c_keep),
        .keep_window (c_keep_window),
        .keep_now    (c_keep_now),
        .keep_until  (c_keep_until),
        .keep_id     (c_keep_id),
        .resume      (c_resume),
        .keep_start  (c_keep_start),
        .ask_start   (c_ask_start),
        .follow      (c_follow),
        .united      (c_united),
        .look        (look),
        .look_y      (look_y),
        .since       (since)
    );

    // ---- the slot that is worked on --------------------------------------------------------------------------------------

    // What was read, and what counts, a clock later. A job begins with the sides in effect, as far as its last job moves them. Axes come
    // one after the other: x with read_done, y with was_read.
    localparam [1:0]    VISIBLE = 2'd2;
    reg                 known;  // the velocity of the slot counts
    reg  [2*SIDE_W-1:0] read_begun, read_kept;  // of the job, or of another slot: the other is 0
    reg  [2*SIDE_W-1:0] read_refs, moves;
    reg                 moves_y;
    reg  [SUP_W-1:0]    other_support;
    wire [4*SIDE_W-1:0] o_sides;
    wire                f_y;
    wire [2*SIDE_W-1:0] f_sides, f_refs, q_sides, q_refs, q_moves;
    wire [SUP_W-1:0]    q_support;
    wire [3:0]          o_marks;
    wire                job_on_y = was_read || (f_y && !read_done);
    wire [2*SIDE_W-1:0] job_axis = job_on_y ? job_sides[0+:2*SIDE_W] : job_sides[2*SIDE_W+:2*SIDE_W];
    wire [2*SIDE_W-1:0] begun_sides;  // those with which the job begins
    integer             k;

    genvar i;
    generate
        for (i = 0; i < 2; i = i + 1) begin : g_side
            array_sum #(
                .W    (SIDE_W),
                .ROUND(0)
            ) u_begun (
                .a     (job_axis[i*SIDE_W+:SIDE_W]),
                .choice(job_waits),
                .one   ({q_moves[i*SIDE_W+:SIDE_W], 1'b0}),
                .other ({(SIDE_W + 1) {1'b0}}),
                .y     (begun_sides[i*SIDE_W+:SIDE_W])
            );
        end
    endgenerate

    always @(posedge clk) begin
        was_read   <= read_done;
        known      <= state == VISIBLE || corrections >= 6'd4;
        read_begun <= of_job ? begun_sides : {(2 * SIDE_W) {1'b0}};
        read_kept  <= of_job ? {(2 * SIDE_W) {1'b0}} : q_sides;
        read_refs  <= q_refs;
        moves_y    <= f_y;
        for (k = 0; k < 2; k = k + 1) moves[k*SIDE_W+:SIDE_W] <= f_sides[k*SIDE_W+:SIDE_W] - job_axis[k*SIDE_W+:SIDE_W];
        if (was_read) other_support <= q_support;
        if (rst) was_read <= 1'b0;
    end

    wire                turn, crossed_x, crossed_y;
    wire [31:0]         q_v;
    wire [SIDE_W:0]     q_start;
    wire [23:0]         usual, q_usual, ticks;
    wire                beyond;
    wire [TIME_W-1:0]   age;
    wire [SIDE_W:0]     sum_lane, ref_lo, ref_hi;
    wire [15:0]         v_lane, v_next, together;
    wire [3:0]          gain, room, run_next, hidden_now, hidden;
    wire [7:0]          runs;
    wire                meets_now;
    wire [4*PX_W-1:0]   other_box, other_window;
    reg  [PX_W:0]       middle_x, middle_y;  // of the box, half pixels
    wire                asks;
    wire [SLOT_W-1:0]   asked;
    wire [PX_W-1:0]     cut_px;
    wire                is_long_x, is_long_y;
    wire [PX_W-1:0]     length_x = side_x[SIDE_W-1:12];
    wire [PX_W-1:0]     length_y = side_y[SIDE_W-1:12];
    wire [SIDE_W-1:0]   shorter;   // of both sides

    function [PX_W:0] wide;
        input [PX_W-1:0] bound;
        wide = {bound[PX_W-1], bound};
    endfunction

    always @(posedge clk) begin
        middle_x <= wide(box[3*PX_W+:PX_W]) + wide(box[2*PX_W+:PX_W]);
        middle_y <= wide(box[PX_W+:PX_W]) + wide(box[0+:PX_W]);
    end

    assign mask       = window_soon && !widest;
    assign look_log2  = look_y ? bin_log2[9:5] : bin_log2[4:0];

    motion_sides #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .SIDE_W(SIDE_W)
    ) u_sides (
        .clk        (clk),
        .rst        (rst),
        .load       (c_loads),
        .load_refs  (c_load),
        .seed       (c_seed),
        .shrink     (c_shrink),
        .cut_high   (c_cut_high),
        .cut_low    (c_cut_low),
        .order      (c_order),
        .on_y       (look_y),
        .unite      (c_cover_both),
        .move       (c_move),
        .shorten    (c_shorten),
        .reflect    (c_reflect),
        .settle     (c_settle),
        .turn       (turn),
        .rub        (c_rub),
        .x          (job_x),
        .y          (job_y),
        .r_sides    (read_begun | read_kept),
        .r_refs     (read_refs),
        .m_v        (q_v),
        .v_next     (v_next),
        .marks      (o_marks),
        .cut_px     (cut_px),
        .seed_px    (regs[`MOTION_SEED_PX]),
        .side_shrink(regs[`MOTION_SIDE_SHRINK]),
        .side_max   (regs[`MOTION_SIDE_MAX]),
        .friction   (regs[`MOTION_FRICTION]),
        .coast_slow (regs[`MOTION_COAST_SLOW]),
        .lane       (lane),
        .ref_lo     (ref_lo),
        .ref_hi     (ref_hi),
        .v          (v_lane),
        .sum        (sum_lane),
        .f_y        (f_y),
        .f_sides    (f_sides),
        .f_refs     (f_refs),
        .o_sides    (o_sides),
        .o_v        (v),
        .speed_x    (speed_x),
        .speed_y    (speed_y),
        .side_x     (side_x),
        .side_y     (side_y),
        .sum_x      (sum_x),
        .sum_y      (sum_y),
        .crossed_x  (crossed_x),
        .crossed_y  (crossed_y),
        .shortened  (too_long)
    );

    motion_pace #(
        .SLOT_W(SLOT_W),
        .SIDE_W(SIDE_W)
    ) u_pace (
        .clk   (clk),
        .rst   (rst),
        .at    (at),
        .begins(c_keep_start),
        .settle(c_united),
        .follow(c_follow),
        .v     (v),
        .sum_x (sum_x),
        .sum_y (sum_y),
        .side_x(side_x),
        .side_y(side_y),
        .shorter(shorter),
        .v_x   (v_x),
        .v_y   (v_y)
    );

    motion_slot #(
        .SLOT_W(SLOT_W),
        .SIDE_W(SIDE_W),
        .PX_W  (PX_W),
        .REL_W (REL_W),
        .SUP_W (SUP_W),
        .ID_W  (ID_W)
    ) u_slot (
        .clk            (clk),
        .rst            (rst),
        .at             (at),
        .from           (asks ? asked : at),
        .e_slot         (e_slot),
        .load           (c_loads),
        .begin_job      (c_begin_job),
        .unite          (c_unite),
        .seed           (c_seed),
        .offset         (c_offset),
        .count          (c_count),
        .begin_bins     (c_begin_bins),
        .pair           (c_pair),
        .part           (c_part),
        .meet           (c_meet),
        .keep           (c_keep),
        .keep_window    (c_keep_window),
        .keep_id        (c_keep_id),
        .resume         (c_resume),
        .ask_start      (c_ask_start),
        .on_y           (lane),
        .read_y         (fetches[2]),
        .keep_start     (c_keep_start || keeps_start),
        .finish         (finish),
        .job_owned      (job_owned),
        .job_marks      (job_kind[1] ? 4'd0 : job_marks),
        .sides_y        (f_y),
        .sides          (f_sides),
        .refs           (f_refs),
        .moves_y        (moves_y),
        .moves          (moves),
        .state          (state),
        .length_x       (length_x),
        .length_y       (length_y),
        .meets_now      (meets_now),
        .hidden_now     (hidden_now),
        .v              (v),
        .usual          (usual),
        .box            (box),
        .window         (window),
        .middle         ({middle_y[REL_W-1:0], middle_x[REL_W-1:0]}),
        .ran            (ran),
        .run_next       (run_next),
        .start          (sum_lane),
        .nev_low        (regs[`MOTION_NEV_LOW]),
        .nev_high       (regs[`MOTION_NEV_HIGH]),
        .burst          (job_flag),
        .gain_log2      (regs[`MOTION_GAIN_LOG2]),
        .gain_slow      (regs[`MOTION_GAIN_SLOW]),
        .gain_fast      (regs[`MOTION_GAIN_FAST]),
        .gap_corrections(regs[`MOTION_GAP_CORRECTIONS]),
        .support        (support),
        .corrections    (corrections),
        .gain           (gain),
        .room           (room),
        .runs           (runs),
        .look_due       (look_due),
        .merged         (merged),
        .meets          (meets),
        .hidden         (hidden),
        .marks          (o_marks),
        .n_ev           (n_ev),
        .together       (together),
        .log2           (bin_log2),
        .q_sides        (q_sides),
        .q_refs         (q_refs),
        .q_moves        (q_moves),
        .q_support      (q_support),
        .q_meets        (q_meets),
        .q_v            (q_v),
        .q_usual        (q_usual),
        .q_id           (id),
        .q_start        (q_start),
        .p_box          (other_box),
        .p_window       (other_window),
        .e_state        (e_state),
        .e_moves        (e_moves),
        .e_marks        (e_marks),
        .e_hidden       (e_hidden),
        .e_middle       (e_middle),
        .e_n_ev         (e_n_ev)
    );

    motion_times #(
        .SLOT_W (SLOT_W),
        .TIME_W (TIME_W),
        .UNTIL_W(UNTIL_W)
    ) u_times (
        .clk         (clk),
        .rst         (rst),
        .at          (at),
        .since       (since),
        .keep_now    (c_keep_now),
        .keep_until  (c_keep_until),
        .now         (job_time),
        .counted     (counted),
        .age         (age),
        .ended       (ended),
        .ticks       (ticks),
        .beyond      (beyond),
        .instant     (instant),
        .silent      (silent),
        .load        (c_loads),
        .loaded      (q_usual),
        .seed        (c_seed),
        .leave       (c_leaves),
        .correct     (c_correct),
        .first       (corrections == 6'd0),
        .usual       (usual),
        .detect_ticks(regs[`MOTION_DETECT_TICKS]),
        .life_log2   (regs[`MOTION_LIFE_LOG2]),
        .life_ticks  (regs[`MOTION_LIFE_TICKS]),
        .coast_ticks (regs[`MOTION_COAST_TICKS]),
        .return_ticks(regs[`MOTION_RETURN_TICKS]),
        .hold        (c_hold),
        .later       (later),
        .take        (c_take),
        .divide      (c_divide),
        .down        ({1'b0, regs[`MOTION_STEP_LOG2]} + (c_by_life ? {2'b00, regs[`MOTION_JOIN_LIFE]} : 6'd0)),
        .dividing    (dividing),
        .older       (older),
        .together    (together),
        .join_steps  (regs[`MOTION_JOIN_STEPS]),
        .enough      (enough),
        .report_steps(regs[`MOTION_REPORT_STEPS]),
        .overdue     (overdue)
    );

    // ---- corrections -----------------------------------------------------------------------------------------------------

    wire [4:0] leading;
    wire [6:0] inverse;

    motion_look #(
        .PX_W(PX_W)
    ) u_look (
        .clk       (clk),
        .note      (c_note),
        .length_x  (length_x),
        .length_y  (length_y),
        .is_long_x (is_long_x),
        .is_long_y (is_long_y),
        .speed_x   (speed_x),
        .speed_y   (speed_y),
        .on_y      (look_y),
        .looks     (looks),
        .narrowest (narrowest),
        .low_stays (low_stays),
        .begins    (gap_begins),
        .ends      (gap_ends),
        .bin_log2  (look_log2),
        .cut_px    (cut_px),
        .gap_px    (regs[`MOTION_GAP_PX])
    );

    motion_inverse u_inverse (
        .clk    (clk),
        .rst    (rst),
        .start  (c_invert),
        .number (ticks),
        .beyond (beyond),
        .goes_on(inverse_goes_on),
        .leading(leading),
        .inverse(inverse)
    );

    motion_velocity #(
        .OFF_W(SIDE_W + 1)
    ) u_velocity (
        .clk      (clk),
        .rst      (rst),
        .start    (c_speed),
        .low      (ref_lo),
        .high     (ref_hi),
        .slower   (corrections < regs[`MOTION_SETTLE] && !job_flag),
        .leading  (leading),
        .inverse  (inverse),
        .gain     (gain),
        .room     (room),
        .run_x    (runs[3:0]),
        .run_y    (runs[7:4]),
        .step_log2(regs[`MOTION_STEP_LOG2]),
        .speed_max(regs[`MOTION_SPEED_MAX]),
        .v        (v_lane),
        .ran      (ran),
        .run_next (run_next),
        .turn     (turn),
        .v_next   (v_next)
    );

    motion_window #(
        .SIDE_W(SIDE_W)
    ) u_window (
        .clk        (clk),
        .rst        (rst),
        .start      (c_place),
        .lo_x       (o_sides[3*SIDE_W+:SIDE_W]),
        .hi_x       (o_sides[2*SIDE_W+:SIDE_W]),
        .lo_y       (o_sides[SIDE_W+:SIDE_W]),
        .hi_y       (o_sides[0+:SIDE_W]),
        .length_x   (length_x),
        .length_y   (length_y),
        .speed_x    (speed_x),
        .speed_y    (speed_y),
        .known      (known),
        .widest     (widest),
        .elongation (regs[`MOTION_ELONGATION]),
        .ring_across(regs[`MOTION_RING_ACROSS]),
        .ring_along (regs[`MOTION_RING_ALONG]),
        .ring_any   (regs[`MOTION_RING_ANY]),
        .ring_px    (regs[`MOTION_RING_PX]),
        .ring_max   (regs[`MOTION_RING_MAX]),
        .soon       (window_soon),
        .done       (window_done),
        .is_long_x  (is_long_x),
        .is_long_y  (is_long_y),
        .box        (box),
        .window     (window)
    );

    // ---- the slot and others -------------------------------------------------------------------------------------------

    motion_pair #(
        .PX_W (PX_W),
        .SUP_W(SUP_W)
    ) u_pair (
        .clk          (clk),
        .rst          (rst),
        .start        (c_compare),
        .one_box      (box),
        .one_v_x      (v[15:0]),
        .one_v_y      (v[31:16]),
        .one_support  (support),
        .other_box    (other_box),
        .other_v_x    (q_v[15:0]),
        .other_v_y    (q_v[31:16]),
        .other_support(other_support),
        .join_speed   (regs[`MOTION_JOIN_SPEED]),
        .join_reach   (regs[`MOTION_JOIN_REACH]),
        .join_px      (regs[`MOTION_JOIN_PX]),
        .done         (pair_done),
        .alike        (alike),
        .weaker       (weaker)
    );

    motion_meeting #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .PX_W  (PX_W)
    ) u_meeting (
        .clk      (clk),
        .rst      (rst),
        .start    (c_ask),
        .begins   (c_touch),
        .slot     (this_slot),
        .visible  (visible),
        .candidate(candidate),
        .left     (left),
        .box      (box),
        .window   (window),
        .middle   ({middle_y, middle_x}),
        .join_reach(regs[`MOTION_JOIN_REACH]),
        .join_px  (regs[`MOTION_JOIN_PX]),
        .asks     (asks),
        .asked    (asked),
        .other_box(other_box),
        .other_window(other_window),
        .done     (meet_done),
        .nearby   (nearby),
        .meets    (meets_now),
        .hidden   (hidden_now),
        .held     (held),
        .touches  (touches),
        .touched  (touched),
        .returns  (returns),
        .returned (returned)
    );

    motion_birth #(
        .SIDE_W(SIDE_W),
        .SUP_W (SUP_W),
        .TIME_W(TIME_W)
    ) u_birth (
        .clk          (clk),
        .measure      (c_ask),
        .sum          (sum_lane),
        .start        (q_start),
        .side_x       (side_x),
        .side_y       (side_y),
        .shorter      (shorter[SIDE_W-1:12]),
        .young        (crossed_x || crossed_y || corrections < 6'd4),
        .support      (support),
        .age          (age),
        .birth_support(regs[`MOTION_BIRTH_SUPPORT]),
        .birth_px     (regs[`MOTION_BIRTH_PX]),
        .birth_ticks  (regs[`MOTION_BIRTH_TICKS]),
        .birth_travel (regs[`MOTION_BIRTH_TRAVEL]),
        .appears      (appears)
    );

    wire unused = &{1'b0, regs[`MOTION_SIDE_STEP], regs[`MOTION_SIDE_SHARE], regs[`MOTION_GAP_SHARE], hidden, shorter, paused_next[0]};

endmodule

`default_nettype wire
