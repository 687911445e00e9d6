// SPDX-License-Identifier: Apache-2.0
// N cluster trackers with boxes and velocities, which meet without merging: the array with the rules of docs/motion.md.
//
// Tokens and streams are those of cot_array.v, but for the record. Events are decided in a pipeline, motion_events.v, one a clock. Beside it
// corrections are computed and candidates placed, motion_work.v, one at a time; from a certain event on, motion_waiting.v, they are in
// force. Events wait for one only if it is not ready by then. A motion step of a slot is done while no event is under way.
//
// Registers: `mode` of each slot, off or seeded, and those of motion_regs.v. A write of `mode` restarts the slot before the next
// token; after a change of `step_log2` a period begins at the next multiple of the new length. Others are to be written while the array is idle.
//
// Latency:    unstalled, from the clock edge that takes the event: 15 clocks to the owned or passed event; about 50 to its record.
// Throughput: an event a clock, two more for a correction and 20 for a candidate; where corrections come faster, one in 40 clocks. A
//             motion step of a free slot takes 5 clocks; see motion_step.v.
// Stall:      every output is held until accepted.
// Reset:      turns all slots off, and gives the registers their defaults.
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
    parameter_check #(.OK(SIDE_W == REACH + 16)) SIDE_W_must_be_left_at_its_default ();

    localparam PX_W  = SIDE_W - 12;  // bits of a bound in pixels
    localparam REL_W = RADIX_W + 2;

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

    // ---- tokens ------------------------------------------------------------------------------------------------------

    wire [TIME_W-1:0] now, next_step, paused;
    wire              holds;
    wire              q_valid, q_due, q_runs, q_event, q_skip, q_p, q_empty;
    wire [TIME_W-1:0] q_time;
    wire [X_W-1:0]    q_x;
    wire [Y_W-1:0]    q_y;
    wire              takes_token;

    motion_queue #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .TICK_W(TICK_W),
        .TIME_W(TIME_W)
    ) u_queue (
        .clk      (clk),
        .rst      (rst),
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
        .m_valid  (q_valid),
        .m_ready  (takes_token),
        .m_due    (q_due),
        .m_runs   (q_runs),
        .m_time   (q_time),
        .m_event  (q_event),
        .m_skip   (q_skip),
        .m_x      (q_x),
        .m_y      (q_y),
        .m_p      (q_p),
        .empty    (q_empty)
    );

    wire                d_valid, d_event, d_owned, d_corrects, d_seeds, d_p;
    wire [SLOT_W-1:0]   d_slot;
    wire [REL_W-1:0]    d_rel_x, d_rel_y;
    wire [X_W-1:0]      d_x;
    wire [Y_W-1:0]      d_y;
    wire [SUP_W-1:0]    d_support;
    wire [TIME_W-1:0]   d_time;
    wire [SEQ_W-1:0]    d_seq, seq;
    wire                read_done, store_done;
    wire [4*SIDE_W-1:0] o_sides, r_sides;
    wire [3:0]          o_marks, o_hidden, r_marks;
    wire [SUP_W-1:0]    o_support, r_support;
    wire [9:0]          o_log2, o_n_ev;
    wire [4*PX_W-1:0]   o_box, o_window, ask_for;
    wire                ask, begins;
    wire [N-1:0]        in_box, in_window, in_line, visible, candidate, left;
    wire [SLOT_W-1:0]   begins_slot, bin_slot;
    wire                bin_count, bin_clear, in_bin_x, in_bin_y;
    wire [3:0]          bin_cleared, bin_x, bin_y;

    // ---- what comes next ---------------------------------------------------------------------------------------------

    wire             room, output_empty, quiet;
    wire             active, rests, waits_none, reached, put_valid, put_seed, put_done, steps, ends_life;
    wire             job_valid, job_done, job_seed;
    wire [7:0]       issued, following;
    wire             issues, op_ready, takes_op, takes_put;
    wire [SLOT_W-1:0] job_slot, put_slot, puts_slot, work_slot;
    wire [X_W-1:0]   job_x;
    wire [Y_W-1:0]   job_y;
    wire [SUP_W-1:0] job_support;
    wire [TIME_W-1:0] job_time;
    wire [SEQ_W-1:0] job_seq;
    wire             op_valid, op_beside, op_read, op_store, op_full, op_put, op_clear;
    wire [SLOT_W-1:0] op_slot;
    wire [3:0]       op_bin;
    wire [N-1:0]     seeded;

    motion_turn #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .TIME_W(TIME_W)
    ) u_turn (
        .clk        (clk),
        .rst        (rst),
        .cfg_valid  (cfg_valid),
        .cfg_slot   (cfg_slot),
        .cfg_addr   (cfg_addr),
        .cfg_data   (cfg_data[4:0]),
        .step_log2  (regs[`MOTION_STEP_LOG2]),
        .seeded     (seeded),
        .q_due      (q_due),
        .q_runs     (q_runs),
        .q_event    (q_event),
        .q_counts   (q_event || q_skip),
        .room       (room),
        .takes_token(takes_token),
        .holds      (holds),
        .issues     (issues),
        .issued     (issued),
        .following  (following),
        .d_valid    (d_valid),
        .d_time     (d_time),
        .now        (now),
        .next_step  (next_step),
        .paused     (paused),
        .op_valid   (op_valid),
        .op_beside  (op_beside),
        .op_writes  (op_store || op_put),
        .op_ready   (op_ready),
        .takes_op   (takes_op),
        .reached    (reached),
        .put_valid  (put_valid),
        .put_slot   (put_slot),
        .takes_put  (takes_put),
        .put_done   (put_done),
        .puts_slot  (puts_slot),
        .active     (active),
        .waits_none (waits_none),
        .rests      (rests),
        .steps      (steps),
        .ends_life  (ends_life),
        .work_slot  (work_slot),
        .quiet      (quiet)
    );

    reg calm, still;  // nothing is under way but what comes, or has come in the clock before
    reg comes;
    reg none;   // what `idle` says, a clock earlier but for what comes
    reg waits;  // a slot has begun to wait for work

    always @(posedge clk) begin
        waits <= d_corrects || d_seeds;
        calm  <= quiet && q_empty;
        still <= !active && rests && !waits && !job_valid && !op_valid && output_empty && !m_cm_valid;
        comes <= s_valid || cfg_valid;
        none  <= calm && still && !comes && !s_valid && !cfg_valid;
        idle  <= none && !s_valid && !cfg_valid;
        if (rst) {calm, still, none, idle} <= 4'b0000;
    end

    // ---- events --------------------------------------------------------------------------------------------------------

    // Free slots; of these, without a track that may return.
    reg [N-1:0] empty, fresh;
    always @(posedge clk) begin
        empty <= seeded & ~(visible | candidate);
        fresh <= seeded & ~(visible | candidate | left);
    end

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
        .rst        (rst),
        .s_valid    (takes_token),
        .s_event    (q_event),
        .s_skip     (q_skip),
        .s_x        (q_x),
        .s_y        (q_y),
        .s_p        (q_p),
        .s_time     (q_time),
        .op_read    (takes_op && op_read),
        .op_store   (takes_op && op_store),
        .op_full    (takes_op && op_full),
        .op_put     (takes_put || (takes_op && op_put)),
        .op_left    (takes_put),
        .op_seed    (takes_put && put_seed),
        .op_clear   (takes_op && op_clear),
        .op_slot    (op_valid ? op_slot : put_slot),
        .op_bin     (op_bin),
        .read_done  (read_done),
        .store_done (store_done),
        .put_done   (put_done),
        .active     (active),
        .o_sides    (o_sides),
        .o_marks    (o_marks),
        .o_hidden   (o_hidden),
        .o_support  (o_support),
        .o_log2     (o_log2),
        .o_box      (o_box),
        .o_window   (o_window),
        .o_n_ev     (o_n_ev),
        .r_sides    (r_sides),
        .r_marks    (r_marks),
        .r_support  (r_support),
        .ask        (ask),
        .ask_for    (ask_for),
        .in_box     (in_box),
        .in_window  (in_window),
        .in_line    (in_line),
        .regs       (regs),
        .visible    (visible),
        .candidate  (candidate),
        .fresh      (fresh),
        .empty      (empty),
        .begins     (begins),
        .begins_slot(begins_slot),
        .d_valid    (d_valid),
        .d_event    (d_event),
        .d_owned    (d_owned),
        .d_corrects (d_corrects),
        .d_seeds    (d_seeds),
        .d_slot     (d_slot),
        .d_rel_x    (d_rel_x),
        .d_rel_y    (d_rel_y),
        .d_x        (d_x),
        .d_y        (d_y),
        .d_p        (d_p),
        .d_support  (d_support),
        .d_time     (d_time),
        .d_seq      (d_seq),
        .seq        (seq),
        .bin_count  (bin_count),
        .bin_clear  (bin_clear),
        .bin_slot   (bin_slot),
        .bin_cleared(bin_cleared),
        .in_bin_x   (in_bin_x),
        .in_bin_y   (in_bin_y),
        .bin_x      (bin_x),
        .bin_y      (bin_y)
    );

    motion_waiting #(
        .SLOT_W(SLOT_W),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .SUP_W (SUP_W),
        .SEQ_W (SEQ_W),
        .TIME_W(TIME_W)
    ) u_waiting (
        .clk        (clk),
        .rst        (rst),
        .s_valid    (d_corrects || d_seeds),
        .s_seed     (d_seeds),
        .s_slot     (d_slot),
        .s_x        (d_x),
        .s_y        (d_y),
        .s_support  (d_support),
        .s_time     (d_time),
        .s_seq      (d_seq),
        .job_valid  (job_valid),
        .job_done   (job_done),
        .job_seed   (job_seed),
        .job_slot   (job_slot),
        .job_x      (job_x),
        .job_y      (job_y),
        .job_support(job_support),
        .job_time   (job_time),
        .job_seq    (job_seq),
        .issued     (issued),
        .following  (following),
        .issues     (issues),
        .reached    (reached),
        .put_valid  (put_valid),
        .put_seed   (put_seed),
        .put_slot   (put_slot),
        .put_done   (takes_put),
        .empty      (waits_none)
    );

    // ---- gaps --------------------------------------------------------------------------------------------------------

    wire [SLOT_W-1:0] at;  // the slot that is worked on

    wire            look, look_y, look_done, gap_found, low_stays;
    wire [4:0]      look_log2;
    wire [PX_W-1:0] narrowest;
    wire [3:0]      gap_begins, gap_ends;

    motion_gaps #(
        .PX_W  (PX_W),
        .SLOT_W(SLOT_W)
    ) u_gaps (
        .clk      (clk),
        .rst      (rst),
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
    wire [SEQ_W-1:0]    op_seq;
    wire [TIME_W-1:0]   op_time;

    motion_work #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .SIDE_W(SIDE_W),
        .PX_W  (PX_W),
        .SUP_W (SUP_W),
        .ID_W  (ID_W),
        .SEQ_W (SEQ_W),
        .TIME_W(TIME_W)
    ) u_work (
        .clk            (clk),
        .rst            (rst),
        .job_valid      (job_valid),
        .job_done       (job_done),
        .job_seed       (job_seed),
        .job_slot       (job_slot),
        .job_x          (job_x),
        .job_y          (job_y),
        .job_support    (job_support),
        .job_time       (job_time),
        .job_seq        (job_seq),
        .do_step        (steps),
        .do_end         (ends_life),
        .work_slot      (work_slot),
        .now            (steps ? next_step : now),
        .paused         (paused),
        .seq            (seq),
        .rests          (rests),
        .puts           (!holds),
        .put_slot       (puts_slot),
        .visible        (visible),
        .candidate      (candidate),
        .left           (left),
        .begins         (begins),
        .begins_slot    (begins_slot),
        .op_valid       (op_valid),
        .op_beside      (op_beside),
        .op_ready       (op_ready),
        .op_read        (op_read),
        .op_store       (op_store),
        .op_full        (op_full),
        .op_put         (op_put),
        .op_clear       (op_clear),
        .op_slot        (op_slot),
        .op_bin         (op_bin),
        .read_done      (read_done),
        .store_done     (store_done),
        .o_sides        (o_sides),
        .o_marks        (o_marks),
        .o_hidden       (o_hidden),
        .o_support      (o_support),
        .o_log2         (o_log2),
        .o_box          (o_box),
        .o_window       (o_window),
        .o_n_ev         (o_n_ev),
        .r_sides        (r_sides),
        .r_marks        (r_marks),
        .r_support      (r_support),
        .ask            (ask),
        .ask_for        (ask_for),
        .in_box         (in_box),
        .in_window      (in_window),
        .in_line        (in_line),
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
        .op_seq         (op_seq),
        .op_time        (op_time),
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
        .rst         (rst),
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
        .support     (o_support),
        .seq         (op_seq),
        .now         (op_time),
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

    array_output #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .REL_W (REL_W),
        .SEQ_W (SEQ_W),
        .SLOT_W(SLOT_W)
    ) u_output (
        .clk         (clk),
        .rst         (rst),
        .s_valid     (d_valid && d_event),
        .s_owned     (d_owned),
        .s_slot      (d_slot),
        .s_rel_x     (d_rel_x),
        .s_rel_y     (d_rel_y),
        .s_x         (d_x),
        .s_y         (d_y),
        .s_p         (d_p),
        .s_seq       (d_seq),
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

    wire unused = &{1'b0, q_valid};  // what is there is due, or runs

endmodule

`default_nettype wire
