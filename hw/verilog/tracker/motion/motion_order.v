// SPDX-License-Identifier: Apache-2.0
// What is done in motion_work.v, and when: corrections and candidates, motion_correct.v, steps, motion_step.v, and within them two slots
// that become one, motion_merge.v. One of them is at work at a time, and the commands of all go to the same parts.
//
// Latency:    see there; 2 clocks for a job of a slot that is free.
// Throughput: one job at a time.
// Stall:      see there.
// Reset:      nothing is being done, and every slot is free.
// Combinational paths: job_valid -> begun, fetch; job_kind -> fetch, since; job_slot -> ends.
`default_nettype none
`include "evcot_defs.vh"

module motion_order #(
    parameter N      = 8,
    parameter SLOT_W = 3,
    parameter ID_W   = 32
) (
    input  wire                    clk,
    input  wire                    rst,

    // what is to be done
    input  wire                    job_valid,
    output wire                    job_done,
    input  wire                    job_real,
    input  wire [1:0]              job_kind,   // 0 a correction, 1 a seed, 2 a step, 3 the end of a life
    input  wire [SLOT_W-1:0]       job_slot,
    output wire                    begun,      // a job begins
    output wire                    ends,       // it ends `at`, not its own slot
    output wire                    finish,     // what it has computed is there
    output reg  [1:0]              state,      // of `at`: free, candidate, visible, left

    // slots
    output wire [N-1:0]            visible,
    output wire [N-1:0]            candidate,
    output wire [N-1:0]            left,       // lost, but it may return
    output reg  [SLOT_W-1:0]       at,         // a clock late
    output wire [SLOT_W-1:0]       this_slot,  // whose step it is

    // what is read of `at`, and bins that are cleared
    output wire                    fetch,
    input  wire                    read_next,  // read_done in the next clock
    input  wire                    read_done,
    output wire                    op_clear,
    output wire [3:0]              op_bin,

    // records
    output wire                    say,
    input  wire                    record_free,
    output wire [1:0]              kind,
    input  wire [ID_W-1:0]         id,
    output wire [ID_W-1:0]         stays_id,

    // what decides: see motion_correct.v, motion_step.v
    input  wire                    lane,
    input  wire                    shrinks,
    input  wire                    q_meets,
    input  wire                    look_due,
    input  wire                    merged,
    input  wire                    instant,
    input  wire                    resting,
    input  wire                    looks,
    input  wire                    look_done,
    input  wire                    gap_found,
    input  wire                    low_stays,
    input  wire                    inverse_goes_on,
    input  wire                    too_long,
    input  wire                    window_soon,
    input  wire                    window_done,
    input  wire                    mask_busy,
    input  wire                    meets,
    input  wire                    silent,
    input  wire                    ended,
    input  wire                    older,
    input  wire                    later,
    input  wire                    dividing,
    input  wire                    enough,
    input  wire                    overdue,
    input  wire                    pair_done,
    input  wire                    alike,
    input  wire                    weaker,
    input  wire                    keep_older,
    input  wire                    meet_done,
    input  wire [N-1:0]            nearby,
    input  wire                    held,
    input  wire                    touches,
    input  wire                    appears,
    input  wire                    returns,
    input  wire [SLOT_W-1:0]       returned,
    input  wire                    may_return,
    input  wire [SLOT_W-1:0]       touched,
    input  wire [5:0]              corrections,

    // commands
    output reg                     loads,      // load, or unite
    output reg                     load,
    output reg                     begin_job,  // with it: of the job
    output wire                    of_job,     // what is being read is
    output reg                     unite,
    output wire                    seed,
    output wire                    shrink,
    output wire                    cut_high,
    output wire                    cut_low,
    output wire                    order,
    output wire                    offset,
    output wire                    reflect,
    output wire                    settle,
    output wire                    cover_both,
    output wire                    move,
    output wire                    rub,
    output wire                    shorten,
    output wire                    invert,
    output wire                    speed,
    output wire                    correct,
    output wire                    leaves,
    output wire                    count,
    output wire                    begin_bins,
    output wire                    place,
    output wire                    widest,     // what is placed may return
    output wire                    note,
    output wire                    compare,
    output wire                    pair,
    output wire                    part,
    output wire                    ask,
    output wire                    touch,
    output wire                    meet,
    output wire                    take,
    output wire                    hold,
    output wire                    divide,
    output wire                    by_life,
    output wire                    keep,
    output wire                    keep_window,
    output wire                    keep_now,
    output wire                    keep_until,
    output wire                    keep_id,
    output wire                    resume,
    output wire                    keep_start,
    output wire                    ask_start,
    output wire                    follow,
    output wire                    united,        // with place: the sides cover those of another slot
    output wire                    look,
    output wire                    look_y,
    output wire [1:0]              since
);

    localparam [1:0] VISIBLE  = 2'd2;  // state of a slot
    localparam [1:0] REPORTED = 2'd2;  // of the times of a slot: see motion_times.v

    // Names of motion_correct.v begin with k_, of motion_step.v with s_, of motion_merge.v with m_.
    wire              k_rests, k_done, k_load, k_seed, k_shrink, k_cut_high, k_cut_low, k_order;
    wire              k_offset, k_reflect, k_settle, k_inverse, k_speed, k_times, k_count, k_bins, k_window, k_note, k_say;
    wire              k_keep, k_keep_now, k_keep_until, k_keep_window, k_keep_start;
    wire              s_rests, s_done, s_fetch, s_merge, s_load, s_reflect, s_move, s_rub, s_shorten, s_window, s_compare, s_pair, s_part;
    wire              s_take, s_divide, s_by_life, s_ask, s_touch, s_meet, s_appear, s_lapse, s_say, s_keep, s_keep_now, s_keep_window;
    wire              m_rests, m_done, m_fetch, m_load, m_unite, m_settle, m_reflect, m_cover;
    wire              s_resume, s_leave, s_leaves, s_keep_until, s_widest;
    wire              m_window, m_hold, m_lapse, m_say, m_keep, m_keep_now, m_keep_until, m_keep_window;
    wire [SLOT_W-1:0] k_at, s_at, m_at, goes;
    wire [1:0]        s_kind, m_kind, k_since, s_since;
    reg               k_was;        // and what it has written last is being written
    reg               passes;       // of the job that is there nothing is computed: it is empty
    reg               at_work;      // it has begun
    wire              correcting = !k_rests || k_was;
    wire              merging    = !m_rests;
    reg               waits;        // the job was there a clock before,
    reg               empty;        // and its slot is free, or what it would correct has left
    wire              starts     = begun && !empty && job_kind != 2'd1;  // it begins with what is read of its slot

    wire [N-1:0]      settled;

    assign begun    = waits && job_valid && !at_work && k_rests && s_rests;
    assign job_done = k_done || s_done || passes;
    assign finish   = k_done || s_done;
    assign ends     = m_lapse || (s_lapse && at != job_slot);
    assign fetch    = starts || s_fetch || m_fetch;
    assign of_job   = m_rests;
    assign say      = k_say || s_say || m_say;
    assign kind     = correcting ? `EVCOT_KIND_MOVED : merging ? m_kind : s_kind;
    assign since    = !job_kind[1] ? k_since : merging ? REPORTED : s_since;

    assign seed         = k_seed;
    assign shrink       = k_shrink;
    assign cut_high     = k_cut_high;
    assign cut_low      = k_cut_low;
    assign order        = k_order;
    assign offset       = k_offset;
    assign reflect      = k_offset || k_reflect || s_reflect || m_reflect;
    assign settle       = k_settle || m_settle;
    assign cover_both   = m_cover;
    assign move         = s_move;
    assign rub          = s_rub;
    assign shorten      = s_shorten;
    assign invert       = k_inverse;
    assign speed        = k_speed;
    assign correct      = k_times;
    assign leaves       = s_leaves;
    assign count        = k_count;
    assign begin_bins   = k_bins;
    assign place        = k_window || s_window || m_window;
    assign widest       = s_widest && !correcting && !merging;
    assign note         = k_note;
    assign compare      = s_compare;
    assign pair         = s_pair;
    assign part         = s_part;
    assign ask          = s_ask;
    assign touch        = s_touch;
    assign meet         = s_meet;
    assign take         = s_take;
    assign hold         = m_hold;
    assign divide       = s_divide;
    assign by_life      = s_by_life;
    assign keep         = k_keep || s_keep || m_keep;
    assign keep_window  = k_keep_window || s_keep_window || m_keep_window;
    assign keep_now     = k_keep_now || s_keep_now || m_keep_now;
    assign keep_until   = k_keep_until || s_keep_until || m_keep_until;
    assign keep_id      = s_appear;
    assign resume       = s_resume;
    assign keep_start   = k_keep_start;
    assign united       = m_window;

    always @(posedge clk) begin
        at        <= !k_rests ? k_at : merging ? m_at : !s_rests ? s_at : job_slot;
        state     <= {visible[at] || left[at], candidate[at] || left[at]};
        k_was     <= !k_rests;
        loads     <= read_next && (k_load || s_load || m_load || m_unite);
        load      <= read_next && (k_load || s_load || m_load);
        begin_job <= read_next && (k_load || s_load);
        unite     <= read_next && m_unite;
        waits     <= job_valid && !job_done;
        empty     <= !job_real || (job_kind != 2'd1 && !visible[job_slot] && !candidate[job_slot] && !(job_kind[1] && left[job_slot]));
        passes    <= begun && empty;
        if (begun) at_work <= 1'b1;
        if (job_done) at_work <= 1'b0;
        if (rst) {waits, passes, at_work} <= 3'b000;
    end

    motion_correct #(
        .SLOT_W(SLOT_W)
    ) u_correct (
        .clk         (clk),
        .rst         (rst),
        .start       (begun && !empty && !job_kind[1]),
        .seed        (job_kind[0]),
        .slot        (job_slot),
        .done        (k_done),
        .rests       (k_rests),
        .at          (k_at),
        .read_done   (read_done),
        .op_clear    (op_clear),
        .op_bin      (op_bin),
        .lane        (lane),
        .visible     (state == VISIBLE),
        .shrinks     (shrinks),
        .q_meets     (q_meets),
        .corrections (corrections),
        .look_due    (look_due),
        .merged      (merged),
        .instant     (instant),
        .resting     (resting),
        .looks       (looks),
        .look_done   (look_done),
        .gap_found   (gap_found),
        .low_stays   (low_stays),
        .inverse_goes_on(inverse_goes_on),
        .window_done (window_done),
        .mask_busy   (mask_busy),
        .record_free (record_free),
        .load        (k_load),
        .c_seed      (k_seed),
        .c_shrink    (k_shrink),
        .c_cut_high  (k_cut_high),
        .c_cut_low   (k_cut_low),
        .c_order     (k_order),
        .c_offset    (k_offset),
        .c_reflect   (k_reflect),
        .c_settle    (k_settle),
        .c_inverse   (k_inverse),
        .c_speed     (k_speed),
        .c_times     (k_times),
        .c_count     (k_count),
        .c_bins      (k_bins),
        .c_window    (k_window),
        .c_note      (k_note),
        .look        (look),
        .look_y      (look_y),
        .say         (k_say),
        .since       (k_since),
        .keep        (k_keep),
        .keep_now    (k_keep_now),
        .keep_until  (k_keep_until),
        .keep_window (k_keep_window),
        .keep_start  (k_keep_start)
    );

    motion_step #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_step (
        .clk        (clk),
        .rst        (rst),
        .start      (begun && !empty && job_kind[1]),
        .end_life   (job_kind[0]),
        .work_slot  (job_slot),
        .rests      (s_rests),
        .done       (s_done),
        .at         (s_at),
        .this_slot  (this_slot),
        .fetch      (s_fetch),
        .read_done  (read_done),
        .merge      (s_merge),
        .goes       (goes),
        .merged     (m_done),
        .at_state   (state),
        .left       (left),
        .settled    (settled),
        .corrections(corrections),
        .meets      (meets),
        .silent     (silent),
        .ended      (ended),
        .older      (older),
        .dividing   (dividing),
        .enough     (enough),
        .overdue    (overdue),
        .too_long   (too_long),
        .window_soon(window_soon),
        .window_done(window_done),
        .mask_busy  (mask_busy),
        .pair_done  (pair_done),
        .alike      (alike),
        .weaker     (weaker),
        .keep_older (keep_older),
        .meet_done  (meet_done),
        .nearby     (nearby),
        .held       (held),
        .touches    (touches),
        .touched    (touched),
        .appears    (appears),
        .returns    (returns),
        .returned   (returned),
        .may_return (may_return),
        .record_free(record_free),
        .load       (s_load),
        .c_reflect  (s_reflect),
        .c_move     (s_move),
        .c_rub      (s_rub),
        .c_shorten  (s_shorten),
        .c_window   (s_window),
        .c_follow   (follow),
        .widest     (s_widest),
        .c_compare  (s_compare),
        .c_pair     (s_pair),
        .c_part     (s_part),
        .c_take     (s_take),
        .c_divide   (s_divide),
        .by_life    (s_by_life),
        .c_ask      (s_ask),
        .c_touch    (s_touch),
        .c_meet     (s_meet),
        .appear     (s_appear),
        .resume     (s_resume),
        .lapse      (s_lapse),
        .leave      (s_leave),
        .c_leave    (s_leaves),
        .ask_start  (ask_start),
        .say        (s_say),
        .kind       (s_kind),
        .since      (s_since),
        .keep       (s_keep),
        .keep_now   (s_keep_now),
        .keep_until (s_keep_until),
        .keep_window(s_keep_window)
    );

    motion_merge #(
        .SLOT_W(SLOT_W),
        .ID_W  (ID_W)
    ) u_merge (
        .clk        (clk),
        .rst        (rst),
        .start      (s_merge),
        .stays      (this_slot),
        .goes       (goes),
        .rests      (m_rests),
        .done       (m_done),
        .at         (m_at),
        .fetch      (m_fetch),
        .read_done  (read_done),
        .lane       (lane),
        .at_state   (state),
        .later      (later),
        .window_done(window_done),
        .mask_busy  (mask_busy),
        .record_free(record_free),
        .id         (id),
        .load       (m_load),
        .unite      (m_unite),
        .c_settle   (m_settle),
        .c_reflect  (m_reflect),
        .c_cover    (m_cover),
        .c_window   (m_window),
        .c_hold     (m_hold),
        .lapse      (m_lapse),
        .say        (m_say),
        .kind       (m_kind),
        .stays_id   (stays_id),
        .keep       (m_keep),
        .keep_now   (m_keep_now),
        .keep_until (m_keep_until),
        .keep_window(m_keep_window)
    );

    motion_lives #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_lives (
        .clk        (clk),
        .rst        (rst),
        .at         (at),
        .seed       (k_seed),
        .settle     (k_keep_start),
        .appear     (s_appear),
        .lapse      (s_lapse || m_lapse),
        .leave      (s_leave),
        .visible    (visible),
        .candidate  (candidate),
        .left       (left),
        .settled    (settled)
    );

endmodule

`default_nettype wire
