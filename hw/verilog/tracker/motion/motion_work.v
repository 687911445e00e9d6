// SPDX-License-Identifier: Apache-2.0
// All that is done to a slot, one slot at a time: a candidate is placed, a correction computed, a motion step gone through.
//
// The slot that is worked on is in registers: its sides and velocity in motion_sides.v, the rest here. What events change of it is read
// and written by operations in their pipeline, motion_events.v; the rest lies in motion_context.v.
//
// Latency:    from job_valid to job_done about 40 clocks for a correction, more with a look for gaps; 45 for a candidate that begins.
// Throughput: a job at a time. A step: 2 clocks and one for each free slot; for each one that lives about 50, and 16 for each other
//             one that it is compared with.
// Stall:      a job waits for its operations and for its record to be accepted.
// Reset:      waits for a job.
// Combinational paths: record_free and op_ready -> op_*.
`default_nettype none
`include "evcot_defs.vh"

module motion_work #(
    parameter N      = 8,
    parameter SLOT_W = 3,
    parameter X_W    = 9,
    parameter Y_W    = 9,
    parameter SIDE_W = 25,
    parameter PX_W   = 13,
    parameter SUP_W  = 16,
    parameter ID_W   = 32,
    parameter SEQ_W  = 48,
    parameter TIME_W = 48
) (
    input  wire                clk,
    input  wire                rst,

    // what is to be done
    input  wire                job_valid,     // a slot waits for a correction, or a candidate begins
    output wire                job_done,
    input  wire                job_seed,
    input  wire [SLOT_W-1:0]   job_slot,
    input  wire [X_W-1:0]      job_x,
    input  wire [Y_W-1:0]      job_y,
    input  wire [SUP_W-1:0]    job_support,
    input  wire [TIME_W-1:0]   job_time,
    input  wire [SEQ_W-1:0]    job_seq,
    input  wire                do_step,       // a motion step, while nothing is under way
    input  wire                do_end,        // the life of end_slot ends at once
    input  wire [SLOT_W-1:0]   end_slot,
    input  wire [TIME_W-1:0]   now,
    input  wire [SEQ_W-1:0]    seq,
    output wire                rests,         // nothing is being done
    input  wire                puts,          // box and window of put_slot are being put in force
    input  wire [SLOT_W-1:0]   put_slot,

    // slots
    output reg  [N-1:0]        visible,
    output reg  [N-1:0]        candidate,
    input  wire                begins,        // a candidate is in force
    input  wire [SLOT_W-1:0]   begins_slot,

    // operations: see motion_events.v
    output wire                op_valid,
    input  wire                op_ready,
    output wire                op_read,
    output wire                op_store,
    output wire                op_full,
    output wire                op_put,
    output wire                op_clear,
    output wire [SLOT_W-1:0]   op_slot,
    output wire [3:0]          op_bin,
    input  wire                read_done,
    input  wire                store_done,
    output wire [4*SIDE_W-1:0] o_sides,
    output reg  [3:0]          o_marks,
    output reg  [3:0]          o_hidden,
    output wire [SUP_W-1:0]    o_support,
    output wire [9:0]          o_log2,
    output wire [4*PX_W-1:0]   o_box,
    output wire [4*PX_W-1:0]   o_window,
    output wire [9:0]          o_n_ev,
    input  wire [4*SIDE_W-1:0] r_sides,
    input  wire [3:0]          r_marks,
    input  wire [SUP_W-1:0]    r_support,
    output wire                ask,
    output wire [4*PX_W-1:0]   ask_for,
    input  wire [N-1:0]        in_box,
    input  wire [N-1:0]        in_window,

    // the search for a gap: see motion_gaps.v
    output reg                 look,
    output reg                 look_y,
    output wire [4:0]          look_log2,
    output reg  [PX_W-1:0]     narrowest,
    input  wire                look_done,
    input  wire                gap_found,
    input  wire                low_stays,
    input  wire [3:0]          gap_begins,
    input  wire [3:0]          gap_ends,

    // records: see motion_record.v
    output wire                say,
    input  wire                record_free,
    output reg  [1:0]          kind,
    output reg  [SLOT_W-1:0]   at,            // the slot that is worked on, or compared
    output wire [ID_W-1:0]     id,
    output reg  [ID_W-1:0]     stays_id,
    output wire [SIDE_W:0]     sum_x,
    output wire [SIDE_W:0]     sum_y,
    output wire [SIDE_W-1:0]   side_x,
    output wire [SIDE_W-1:0]   side_y,
    output wire [15:0]         v_x,
    output wire [15:0]         v_y,
    output reg  [9:0]          n_ev,
    output reg  [SEQ_W-1:0]    op_seq,
    output reg  [TIME_W-1:0]   op_time,

    // registers
    input  wire [4:0]          step_log2,
    input  wire [3:0]          side_shrink,
    input  wire [11:0]         side_max,
    input  wire [3:0]          gain_log2,
    input  wire [2:0]          gain_slow,
    input  wire [5:0]          settle_count,
    input  wire [14:0]         speed_max,
    input  wire [3:0]          friction,
    input  wire [9:0]          nev_low,
    input  wire [9:0]          nev_high,
    input  wire [7:0]          seed_px,
    input  wire [7:0]          ring_px,
    input  wire [7:0]          ring_max,
    input  wire [3:0]          ring_across,
    input  wire [3:0]          ring_along,
    input  wire [3:0]          ring_any,
    input  wire [3:0]          elongation,
    input  wire [23:0]         detect_ticks,
    input  wire [3:0]          life_log2,
    input  wire [23:0]         life_ticks,
    input  wire [23:0]         coast_ticks,
    input  wire [15:0]         birth_support,
    input  wire [7:0]          birth_px,
    input  wire [23:0]         birth_ticks,
    input  wire [3:0]          birth_travel,
    input  wire [7:0]          gap_corrections,
    input  wire [7:0]          gap_px,
    input  wire [9:0]          join_steps,
    input  wire [3:0]          join_life,
    input  wire [3:0]          join_speed,
    input  wire [3:0]          join_reach,
    input  wire [7:0]          join_px,
    input  wire                keep_older,
    input  wire [9:0]          report_steps
);

    localparam [31:0] SLOTS = N;

    // What it does.
    localparam [6:0] REST    = 7'd0;  // waits for a job
    localparam [6:0] SEED    = 7'd1;  // a candidate begins
    localparam [6:0] SEED_1  = 7'd2;
    localparam [6:0] SEED_2  = 7'd3;
    localparam [6:0] TICKS   = 7'd5;  // a correction: the slot is being read
    localparam [6:0] LOAD    = 7'd6;
    localparam [6:0] SHRINK  = 7'd7;  // how far sides move inwards
    localparam [6:0] OFFSET  = 7'd8;  // offsets in place of places
    localparam [6:0] LOOK    = 7'd9;  // are bins looked at?
    localparam [6:0] LOOK_AT = 7'd10;  // on which axes?
    localparam [6:0] LOOK_GO = 7'd11;  // each axis
    localparam [6:0] LOOKING = 7'd12;
    localparam [6:0] CUT     = 7'd13;
    localparam [6:0] ORDER   = 7'd14;
    localparam [6:0] ORDERED = 7'd15;
    localparam [6:0] LOOKED  = 7'd16;  // begins new bins
    localparam [6:0] SPEED   = 7'd17;  // waits for the leading bit of the time
    localparam [6:0] LIFE    = 7'd19;  // waits for the velocity and the lengths
    localparam [6:0] TURN    = 7'd20;  // the next N_ev
    localparam [6:0] PLACE   = 7'd21;  // box and window
    localparam [6:0] WINDOW  = 7'd22;  // waits for them, and for the sides to be written
    localparam [6:0] KEPT    = 7'd23;
    localparam [6:0] CLEAR   = 7'd24;  // clears the bins
    localparam [6:0] SAY     = 7'd25;  // hands over a record
    localparam [6:0] NEXT    = 7'd26;  // a motion step: the next slot
    localparam [6:0] FETCH   = 7'd27;  // reads it
    localparam [6:0] AGE     = 7'd28;  // has its life ended?
    localparam [6:0] FETCHED = 7'd29;
    localparam [6:0] AGED    = 7'd30;
    localparam [6:0] MOVE    = 7'd31;  // moves it
    localparam [6:0] LONG    = 7'd32;  // is it too long?
    localparam [6:0] SHORT   = 7'd33;
    localparam [6:0] SCAN    = 7'd34;  // compares it with others: the next one
    localparam [6:0] COMPARE = 7'd35;  // reads that one
    localparam [6:0] PAIR    = 7'd36;
    localparam [6:0] FOUND   = 7'd37;
    localparam [6:0] YOUNGER = 7'd38;  // they are alike: which is younger?
    localparam [6:0] OLDER   = 7'd39;
    localparam [6:0] LIVED   = 7'd40;  // how long has it lived?
    localparam [6:0] STEPS   = 7'd41;  // in steps
    localparam [6:0] SINCE   = 7'd42;  // how long ago was its last record, or its seed?
    localparam [6:0] JOIN    = 7'd43;
    localparam [6:0] MEET    = 7'd44;  // which boxes and windows does it touch?
    localparam [6:0] MET     = 7'd45;
    localparam [6:0] TOUCH   = 7'd46;  // a candidate touches another one, which is read
    localparam [6:0] TOUCHED = 7'd47;
    localparam [6:0] MERGE   = 7'd48;  // two become one: writes the slot back
    localparam [6:0] RELOAD  = 7'd49;  // reads the one that goes
    localparam [6:0] RELOADS = 7'd50;
    localparam [6:0] GOES    = 7'd51;
    localparam [6:0] GONE    = 7'd52;  // the id of the one that stays, then a record
    localparam [6:0] STAYS   = 7'd53;
    localparam [6:0] RETURN  = 7'd54;  // reads the one that stays
    localparam [6:0] RETURNS = 7'd55;
    localparam [6:0] UNITE   = 7'd56;
    localparam [6:0] UNITED  = 7'd57;  // how far its sides are from those of the one that goes
    localparam [6:0] COVER   = 7'd61;  // they cover both
    localparam [6:0] COVERED = 7'd67;  // new bins and a new window
    localparam [6:0] BINS    = 7'd58;
    localparam [6:0] MERGED  = 7'd59;  // writes it back
    localparam [6:0] GO_ON   = 7'd60;
    localparam [6:0] BORN    = 7'd62;
    localparam [6:0] REPORT  = 7'd63;  // is it time for a record?
    localparam [6:0] LAPSE   = 7'd64;  // the slot becomes free
    localparam [6:0] DONE    = 7'd65;  // writes the slot back
    localparam [6:0] WRITTEN = 7'd66;

    // Why the slot's window is found.
    localparam [1:0] FOR_SEED    = 2'd0;
    localparam [1:0] FOR_CORRECT = 2'd1;
    localparam [1:0] FOR_STEP    = 2'd2;
    localparam [1:0] FOR_MERGE   = 2'd3;

    reg [6:0]        state, after, after_clear;
    reg [2:0]        pause;          // clocks until the state is gone on with
    reg [1:0]        why;
    reg [SLOT_W:0]   slot, other;    // of a motion step; with which it is compared
    reg [SLOT_W-1:0] stays, goes;
    reg              scans_touch;    // a candidate was united with another one, not with its partner
    reg [N-1:0]      settled;        // has had four corrections
    reg [X_W-1:0]    x;
    reg [Y_W-1:0]    y;
    reg              alone;          // a life ends, not in a step
    reg              ended, again;   // its time is over; its box has grown since it was first compared
    wire [N-1:0]     lives      = visible | candidate;
    wire [SLOT_W-1:0] this_slot  = slot[SLOT_W-1:0];
    wire [SLOT_W-1:0] this_other = other[SLOT_W-1:0];
    wire             is_visible = visible[at];

    assign rests = state == REST;

    // ---- the slot, and what memory has of it ---------------------------------------------------------------------------

    reg  [SUP_W-1:0]  support;
    reg  [5:0]        corrections;
    reg  [7:0]        looked;
    reg               meets, has_partner;
    reg  [SLOT_W-1:0] partner;
    reg  [15:0]       together;
    wire [23:0]       usual;
    reg  [9:0]        log2;
    reg               keep, keep_time, keep_until, keep_window, keep_id, keep_start;
    reg  [ID_W-1:0]   births;

    wire [31:0]         q_v;
    wire [4*SIDE_W-1:0] q_refs;
    wire [5:0]          q_corrections;
    wire [7:0]          q_looked;
    wire                q_meets, q_has_partner;
    wire [3:0]          q_hidden;
    wire [9:0]          q_n_ev, q_log2;
    wire [SLOT_W-1:0]   q_partner;
    wire [15:0]         q_together;
    wire [23:0]         q_usual;
    wire [2*SIDE_W+1:0] q_start;
    wire [4*PX_W-1:0]   box, window;

    wire signed [SIDE_W-1:0] lo_x, hi_x, lo_y, hi_y;
    wire                lane;
    wire [SIDE_W:0]     sum_lane;
    wire signed [SIDE_W:0] ref_lo, ref_hi;
    wire signed [15:0]  v_lane;
    wire [4*SIDE_W-1:0] refs;
    wire [31:0]         v;
    wire                crossed_x, crossed_y;
    wire [14:0]         speed_x = v_x[15] ? -v_x[14:0] : v_x[14:0];
    wire [14:0]         speed_y = v_y[15] ? -v_y[14:0] : v_y[14:0];
    wire [PX_W-1:0]     length_x = side_x[SIDE_W-1:12];
    wire [PX_W-1:0]     length_y = side_y[SIDE_W-1:12];
    wire                moves    = is_visible || corrections >= 6'd4;  // its velocity counts

    assign {lo_x, hi_x, lo_y, hi_y} = o_sides;
    assign {v_y, v_x} = v;
    assign o_support = support;
    assign o_log2    = log2;

    motion_context #(
        .SLOT_W(SLOT_W),
        .SIDE_W(SIDE_W),
        .PX_W  (PX_W),
        .ID_W  (ID_W)
    ) u_context (
        .clk          (clk),
        .at           (at),
        .puts         (puts),
        .put_slot     (put_slot),
        .keep         (keep),
        .keep_window  (keep_window),
        .keep_id      (keep_id),
        .keep_start   (keep_start),
        .v            (v),
        .refs         (refs),
        .corrections  (corrections),
        .looked       (looked),
        .meets        ({o_hidden, meets}),
        .n_ev         (n_ev),
        .has_partner  (has_partner),
        .partner      (partner),
        .together     (together),
        .usual        (usual),
        .box          (box),
        .window       (window),
        .id           (births),
        .start        ({sum_x, sum_y}),
        .log2         (log2),
        .q_v          (q_v),
        .q_refs       (q_refs),
        .q_corrections(q_corrections),
        .q_looked     (q_looked),
        .q_meets      ({q_hidden, q_meets}),
        .q_n_ev       (q_n_ev),
        .q_has_partner(q_has_partner),
        .q_partner    (q_partner),
        .q_together   (q_together),
        .q_usual      (q_usual),
        .q_id         (id),
        .q_start      (q_start),
        .q_log2       (q_log2),
        .p_box        (o_box),
        .p_window     (o_window),
        .p_n_ev       (o_n_ev)
    );

    // ---- its sides -----------------------------------------------------------------------------------------------------

    reg  c_seed, c_shrink, c_cut_high, c_cut_low, c_order, c_cover, c_move, c_shorten, c_reflect, c_settle, c_rub;
    wire loads  = read_done && (state == LOAD || state == FETCHED || state == GOES);
    wire unites = read_done && state == UNITE;
    reg  [PX_W-1:0] cut_px;
    wire            turn;
    wire [15:0]     v_next;

    motion_sides #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .SIDE_W(SIDE_W)
    ) u_sides (
        .clk        (clk),
        .rst        (rst),
        .load       (loads || unites),
        .load_refs  (loads),
        .seed       (c_seed),
        .shrink     (c_shrink),
        .cut_high   (c_cut_high),
        .cut_low    (c_cut_low),
        .order      (c_order),
        .on_y       (look_y),
        .unite      (c_cover),
        .move       (c_move),
        .shorten    (c_shorten),
        .reflect    (c_reflect),
        .settle     (c_settle),
        .turn       (turn),
        .rub        (c_rub),
        .x          (x),
        .y          (y),
        .r_sides    (r_sides),
        .m_refs     (q_refs),
        .m_v        (q_v),
        .v_next     (v_next),
        .marks      (o_marks),
        .cut_px     (cut_px),
        .seed_px    (seed_px),
        .side_shrink(side_shrink),
        .side_max   (side_max),
        .friction   (friction),
        .lane       (lane),
        .ref_lo     (ref_lo),
        .ref_hi     (ref_hi),
        .v          (v_lane),
        .sum        (sum_lane),
        .o_sides    (o_sides),
        .o_refs     (refs),
        .o_v        (v),
        .side_x     (side_x),
        .side_y     (side_y),
        .sum_x      (sum_x),
        .sum_y      (sum_y),
        .crossed_x  (crossed_x),
        .crossed_y  (crossed_y)
    );

    // ---- gaps -----------------------------------------------------------------------------------------------------------

    reg  [PX_W-1:0] was_x, was_y;      // lengths before a cut
    reg  [PX_W+3:0] long_x, long_y;    // so long must the other axis be
    reg             across_x, across_y, looks_x, looks_y;
    wire [PX_W-1:0] least_gap  = {{(PX_W - 8) {1'b0}}, gap_px};
    wire [PX_W-1:0] half_other = {1'b0, look_y ? was_x[PX_W-1:1] : was_y[PX_W-1:1]};
    wire [PX_W-1:0] cut_bin    = {{(PX_W - 4) {1'b0}}, low_stays ? gap_begins : gap_ends};

    assign look_log2 = look_y ? log2[9:5] : log2[4:0];

    // Bins of 2^n pixels, four to eight for the whole side.
    function [4:0] bin_log2;
        input [PX_W-1:0] length;
        integer k;
        begin
            bin_log2 = 5'd0;
            for (k = 4; k <= PX_W; k = k + 1) if (length[k-1]) bin_log2 = k[4:0] - 5'd3;
        end
    endfunction

    // ---- times ---------------------------------------------------------------------------------------------------------

    localparam [1:0] LAST     = 2'd0;
    localparam [1:0] UNTIL    = 2'd1;  // the deadline
    localparam [1:0] SEEDED   = 2'd2;
    localparam [1:0] REPORTED = 2'd3;

    reg  [1:0]        since;
    reg               c_correct, c_hold, c_take, c_divide;
    reg  [5:0]        down;
    wire [TIME_W-1:0] age;
    wire [23:0]       ticks;
    wire              time_ended, silent, dividing, older, enough, overdue;

    motion_times #(
        .SLOT_W(SLOT_W),
        .TIME_W(TIME_W)
    ) u_times (
        .clk         (clk),
        .rst         (rst),
        .at          (at),
        .since       (since),
        .keep_now    (keep_time),
        .keep_until  (keep_until),
        .now         (op_time),
        .age         (age),
        .ended       (time_ended),
        .ticks       (ticks),
        .silent      (silent),
        .load        (loads || unites),
        .loaded      (q_usual),
        .seed        (c_seed),
        .correct     (c_correct),
        .first       (corrections == 6'd0),
        .usual       (usual),
        .detect_ticks(detect_ticks),
        .life_log2   (life_log2),
        .life_ticks  (life_ticks),
        .coast_ticks (coast_ticks),
        .hold        (c_hold),
        .take        (c_take),
        .divide      (c_divide),
        .down        (down),
        .dividing    (dividing),
        .older       (older),
        .together    (together),
        .join_steps  (join_steps),
        .enough      (enough),
        .report_steps(report_steps),
        .overdue     (overdue)
    );

    // ---- velocity ------------------------------------------------------------------------------------------------------

    reg        c_inverse, c_speed;
    reg  [3:0] gain;
    wire       inverse_busy;
    wire [4:0] leading;
    wire [6:0] inverse;
    wire [6:0] slow_gain  = {1'b0, corrections >> gain_slow} + 7'd1;
    wire [3:0] least_gain = slow_gain < {3'd0, gain_log2} ? slow_gain[3:0] : gain_log2;

    motion_inverse u_inverse (
        .clk    (clk),
        .rst    (rst),
        .start  (c_inverse),
        .number (ticks),
        .busy   (inverse_busy),
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
        .slower   (corrections < settle_count),
        .leading  (leading),
        .inverse  (inverse),
        .gain     (gain),
        .step_log2(step_log2),
        .speed_max(speed_max),
        .v        (v_lane),
        .turn     (turn),
        .v_next   (v_next)
    );

    // ---- box and window ------------------------------------------------------------------------------------------------

    reg  c_window, windowed, stored;  // they have been found; the sides have been written
    wire window_done;

    motion_window #(
        .SIDE_W(SIDE_W)
    ) u_window (
        .clk        (clk),
        .rst        (rst),
        .start      (c_window),
        .lo_x       (lo_x),
        .hi_x       (hi_x),
        .lo_y       (lo_y),
        .hi_y       (hi_y),
        .length_x   (length_x),
        .length_y   (length_y),
        .speed_x    (speed_x),
        .speed_y    (speed_y),
        .known      (moves),
        .elongation (elongation),
        .ring_across(ring_across),
        .ring_along (ring_along),
        .ring_any   (ring_any),
        .ring_px    (ring_px),
        .ring_max   (ring_max),
        .done       (window_done),
        .box        (box),
        .window     (window)
    );

    // ---- the slot and others -------------------------------------------------------------------------------------------

    reg             c_pair;
    reg [SUP_W-1:0] other_support;
    wire            pair_done, alike, weaker;

    motion_pair #(
        .PX_W (PX_W),
        .SUP_W(SUP_W)
    ) u_pair (
        .clk          (clk),
        .rst          (rst),
        .start        (c_pair),
        .one_box      (box),
        .one_v_x      (v_x),
        .one_v_y      (v_y),
        .one_support  (support),
        .other_box    (o_box),
        .other_v_x    (q_v[15:0]),
        .other_v_y    (q_v[31:16]),
        .other_support(other_support),
        .join_speed   (join_speed),
        .join_reach   (join_reach),
        .join_px      (join_px),
        .done         (pair_done),
        .alike        (alike),
        .weaker       (weaker)
    );

    reg              c_meet, c_touch;
    wire             meet_done, meets_now, middle_held;
    wire [3:0]       hidden_now;
    wire             touches;
    wire [SLOT_W-1:0] touched;

    motion_meeting #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .PX_W  (PX_W)
    ) u_meeting (
        .clk      (clk),
        .rst      (rst),
        .start    (c_meet),
        .begins   (c_touch),
        .slot     (this_slot),
        .visible  (visible),
        .candidate(candidate),
        .box      (box),
        .window   (window),
        .ask      (ask),
        .ask_for  (ask_for),
        .in_box   (in_box),
        .in_window(in_window),
        .done     (meet_done),
        .meets    (meets_now),
        .hidden   (hidden_now),
        .held     (middle_held),
        .touches  (touches),
        .touched  (touched)
    );

    // ---- births --------------------------------------------------------------------------------------------------------

    wire appears;

    motion_birth #(
        .SIDE_W(SIDE_W),
        .SUP_W (SUP_W),
        .TIME_W(TIME_W)
    ) u_birth (
        .clk          (clk),
        .lane         (lane),
        .sum          (sum_lane),
        .side_x       (side_x),
        .side_y       (side_y),
        .start        (q_start),
        .young        (crossed_x || crossed_y || corrections < 6'd4),
        .support      (support),
        .age          (age),
        .birth_support(birth_support),
        .birth_px     (birth_px),
        .birth_ticks  (birth_ticks),
        .birth_travel (birth_travel),
        .appears      (appears)
    );

    // ---- what is done, in order ----------------------------------------------------------------------------------------

    reg               writes;              // an operation is wanted
    reg  [4:0]        op;                  // clear, put, full, store, read
    reg  [3:0]        bin;
    reg  [PX_W:0]     outline;
    reg               look_due;            // bins are looked at
    reg               other_older;
    wire              op_free      = !writes || op_ready;
    wire [SUP_W:0]    both_support = {1'b0, support} + {1'b0, r_support};
    wire              goes_on      = pause == 3'd0;

    localparam [4:0] OP_READ  = 5'b00001;
    localparam [4:0] OP_STORE = 5'b00010;
    localparam [4:0] OP_FULL  = 5'b00110;  // and the support
    localparam [4:0] OP_ALL   = 5'b01110;  // and the window
    localparam [4:0] OP_CLEAR = 5'b10000;

    assign op_valid = writes;
    assign {op_clear, op_put, op_full, op_store, op_read} = op;
    assign op_slot  = at;
    assign op_bin   = bin;
    assign say      = state == SAY && goes_on;
    assign job_done = state == KEPT;

    always @(posedge clk) begin
        {c_seed, c_shrink, c_cut_high, c_cut_low, c_order, c_cover, c_move, c_shorten, c_reflect, c_settle, c_rub} <= 11'd0;
        {c_inverse, c_speed, c_window, c_pair, c_meet, look} <= 6'd0;
        {c_correct, c_hold, c_take, c_divide} <= 4'd0;
        {keep, keep_time, keep_until, keep_window, keep_id, keep_start} <= 6'd0;

        look_due     <= gap_corrections != 8'd0 && {1'b0, looked} + 9'd1 >= {1'b0, gap_corrections};
        outline      <= {1'b0, length_x} + {1'b0, length_y};
        long_x       <= {4'd0, was_x} * {{PX_W{1'b0}}, elongation};
        long_y       <= {4'd0, was_y} * {{PX_W{1'b0}}, elongation};
        looks_x      <= across_x || {4'd0, was_x} >= long_y;
        looks_y      <= across_y || {4'd0, was_y} >= long_x;

        if (op_ready) writes <= 1'b0;
        if (store_done) stored <= 1'b1;
        if (window_done) windowed <= 1'b1;
        if (begins) candidate[begins_slot] <= 1'b1;
        if (keep_id) births <= births + {{(ID_W - 1) {1'b0}}, 1'b1};

        if (loads || unites) begin
            o_marks     <= r_marks;
            o_hidden    <= q_hidden;
            meets       <= q_meets;
            n_ev        <= q_n_ev;
            corrections <= q_corrections;
            looked      <= q_looked;
            has_partner <= q_has_partner;
            partner     <= q_partner;
            together    <= q_together;
            log2        <= q_log2;
        end

        if (!goes_on) pause <= pause - 3'd1;
        else case (state)
            REST: begin
                slot  <= {(SLOT_W + 1) {1'b0}};
                since <= LAST;
                alone <= do_end;
                x     <= job_x;
                y     <= job_y;
                if (do_step || do_end) begin
                    op_time <= now;
                    op_seq  <= seq;
                    if (|lives) state <= NEXT;
                    if (do_end) begin
                        at    <= end_slot;
                        slot  <= {1'b0, end_slot};
                        state <= lives[end_slot] ? FETCH : REST;
                    end
                end else if (job_valid) begin
                    at      <= job_slot;
                    op_time <= job_time;
                    op_seq  <= job_seq;
                    support <= job_support;
                    state   <= SEED;
                    if (!job_seed) begin
                        writes <= 1'b1;
                        op     <= OP_READ;
                        pause  <= 3'd4;
                        state  <= TICKS;
                    end
                end
            end

            // ---- a candidate that begins -----------------------------------------------------------------------------
            SEED:
            if (!lane) begin
                c_seed      <= 1'b1;
                since       <= SEEDED;
                keep_time   <= 1'b1;
                o_marks     <= 4'd0;
                o_hidden    <= 4'd0;
                meets       <= 1'b0;
                n_ev        <= nev_low;
                support     <= {{(SUP_W - 1) {1'b0}}, 1'b1};
                corrections <= 6'd0;
                looked      <= 8'd0;
                has_partner <= 1'b0;
                together    <= 16'd0;
                settled[at] <= 1'b0;
                pause       <= 3'd1;
                state       <= SEED_1;
            end
            SEED_1: begin
                c_settle <= 1'b1;
                pause    <= 3'd5;
                state    <= SEED_2;
            end
            SEED_2: begin
                log2        <= {bin_log2(length_y), bin_log2(length_x)};
                why         <= FOR_SEED;
                after_clear <= PLACE;
                state       <= CLEAR;
            end

            // ---- a correction ----------------------------------------------------------------------------------------
            TICKS: begin
                c_inverse <= 1'b1;
                why       <= FOR_CORRECT;
                state     <= LOAD;
            end
            LOAD:
            if (read_done) begin
                pause <= 3'd2;
                state <= !q_meets && side_shrink != 4'd0 ? SHRINK : OFFSET;
            end
            SHRINK: begin
                c_shrink <= 1'b1;
                pause    <= 3'd1;
                state    <= OFFSET;
            end
            OFFSET: begin
                c_reflect <= 1'b1;
                o_marks   <= 4'd0;
                gain      <= least_gain + {3'd0, meets};
                if (gap_corrections != 8'd0) looked <= looked + 8'd1;
                state     <= look_due ? LOOK : SPEED;
            end
            LOOK: begin
                across_x <= {speed_y, 1'b0} >= {1'b0, speed_x};
                across_y <= {speed_x, 1'b0} >= {1'b0, speed_y};
                look_y   <= 1'b0;
                pause    <= 3'd4;
                state    <= LOOK_AT;
            end
            LOOK_AT: begin
                was_x <= length_x;
                was_y <= length_y;
                pause <= 3'd2;
                state <= corrections >= 6'd8 && (speed_x != 15'd0 || speed_y != 15'd0) ? LOOK_GO : LOOKED;
            end
            LOOK_GO:
            if (look_y ? looks_y : looks_x) begin
                narrowest <= (look_y ? across_y : across_x) || least_gap > half_other ? least_gap : half_other;
                look      <= 1'b1;
                state     <= LOOKING;
            end else begin
                look_y <= 1'b1;
                state  <= look_y ? LOOKED : LOOK_GO;
            end
            LOOKING: begin
                cut_px <= cut_bin << look_log2;
                if (look_done) state <= gap_found ? CUT : ORDERED;
            end
            CUT:
            if (!lane) begin
                cut_px     <= cut_bin << look_log2;
                c_cut_high <= low_stays;
                c_cut_low  <= !low_stays;
                pause      <= 3'd5;
                state      <= ORDER;
            end
            ORDER: begin
                c_order <= !low_stays;
                state   <= ORDERED;
            end
            ORDERED: begin
                look_y <= 1'b1;
                pause  <= 3'd6;
                state  <= look_y ? LOOKED : LOOK_GO;
            end
            LOOKED: begin
                looked      <= 8'd0;
                log2        <= {bin_log2(length_y), bin_log2(length_x)};
                after_clear <= SPEED;
                state       <= CLEAR;
            end
            SPEED:
            if (!inverse_busy && !lane) begin
                c_speed  <= corrections >= 6'd2;
                c_settle <= 1'b1;
                c_correct <= 1'b1;
                pause     <= corrections >= 6'd2 ? 3'd7 : 3'd2;
                state     <= LIFE;
            end
            LIFE: begin
                pause <= 3'd1;
                state <= TURN;
            end
            TURN: begin
                n_ev     <= outline < {{(PX_W - 9) {1'b0}}, nev_low} ? nev_low
                          : outline > {{(PX_W - 9) {1'b0}}, nev_high} ? nev_high : outline[9:0];
                corrections <= corrections == 6'd63 ? 6'd63 : corrections + 6'd1;
                if (corrections == 6'd3) begin
                    keep_start  <= 1'b1;
                    settled[at] <= 1'b1;
                end
                kind  <= `EVCOT_KIND_MOVED;
                after <= PLACE;
                pause <= corrections >= 6'd2 ? 3'd3 : 3'd0;
                state <= is_visible ? SAY : PLACE;
            end

            // ---- box and window --------------------------------------------------------------------------------------
            PLACE:
            if (op_free) begin
                c_window <= 1'b1;
                windowed <= 1'b0;
                stored   <= why == FOR_STEP || why == FOR_MERGE;
                writes   <= why == FOR_SEED || why == FOR_CORRECT;
                op       <= why == FOR_SEED ? OP_FULL : OP_STORE;
                state    <= WINDOW;
            end
            WINDOW:
            if (windowed && stored) begin
                keep_window <= 1'b1;
                other       <= corrections < 6'd4 ? SLOTS[SLOT_W:0] : {(SLOT_W + 1) {1'b0}};
                case (why)
                    FOR_STEP:  state <= SCAN;
                    FOR_MERGE: state <= MERGED;
                    default: begin
                        keep          <= 1'b1;
                        since     <= LAST;
                        keep_time <= 1'b1;
                        state         <= KEPT;
                    end
                endcase
            end
            KEPT: begin
                since      <= UNTIL;
                keep_until <= 1'b1;
                state      <= REST;
            end
            CLEAR:
            if (op_free) begin
                writes <= 1'b1;
                op     <= OP_CLEAR;
                bin    <= bin + 4'd1;
                if (bin == 4'd14) state <= after_clear;
            end
            SAY:
            if (record_free) begin
                since     <= REPORTED;
                keep_time <= 1'b1;
                state     <= after;
            end

            // ---- a motion step of a slot -----------------------------------------------------------------------------
            NEXT: begin
                at <= this_slot;
                if (slot == SLOTS[SLOT_W:0]) state <= REST;
                else if (lives[this_slot]) state <= FETCH;
                else slot <= slot + {{SLOT_W{1'b0}}, 1'b1};
            end
            FETCH: begin
                writes <= 1'b1;
                op     <= OP_READ;
                since  <= UNTIL;
                pause  <= 3'd3;
                state  <= AGE;
            end
            AGE: begin
                ended <= time_ended;
                since <= LAST;
                state <= FETCHED;
            end
            FETCHED:
            if (read_done) begin
                support <= r_support;
                state   <= AGED;
            end
            AGED: begin
                c_reflect <= 1'b1;
                kind      <= `EVCOT_KIND_LOST;
                after     <= LAPSE;
                pause     <= !ended && !alone ? 3'd1 : 3'd4;
                state     <= !ended && !alone ? MOVE : is_visible ? SAY : LAPSE;
            end
            MOVE: begin
                c_move <= moves;
                c_rub  <= moves && friction != 4'd0 && !meets && silent;
                pause  <= 3'd5;
                state  <= LONG;
            end
            LONG: begin
                c_shorten <= 1'b1;
                pause     <= 3'd1;
                state     <= SHORT;
            end
            SHORT: begin
                c_reflect <= 1'b1;
                why       <= FOR_STEP;
                pause     <= 3'd4;
                state     <= PLACE;
            end
            LAPSE: begin
                visible[at]   <= 1'b0;
                candidate[at] <= 1'b0;
                slot          <= slot + {{SLOT_W{1'b0}}, 1'b1};
                state         <= alone ? REST : NEXT;
            end
            DONE:
            if (op_free) begin
                writes <= 1'b1;
                op     <= OP_ALL;
                stored <= 1'b0;
                keep   <= 1'b1;
                state  <= WRITTEN;
            end
            WRITTEN:
            if (stored) begin
                slot  <= slot + {{SLOT_W{1'b0}}, 1'b1};
                state <= NEXT;
            end

            // ---- comparing it with the others ------------------------------------------------------------------------
            SCAN: begin
                at <= this_slot;
                if (other == SLOTS[SLOT_W:0]) begin
                    if (together != 16'd0) together <= together - 16'd1;
                    state <= MEET;
                end else if (settled[this_other] && lives[this_other] && other != slot) begin
                    at    <= this_other;
                    state <= COMPARE;
                end else other <= other + {{SLOT_W{1'b0}}, 1'b1};
            end
            COMPARE: begin
                writes <= 1'b1;
                op     <= OP_READ;
                state  <= PAIR;
            end
            PAIR:
            if (read_done) begin
                other_support <= r_support;
                c_pair        <= 1'b1;
                state         <= FOUND;
            end
            FOUND:
            if (pair_done && alike) begin
                has_partner <= 1'b1;
                partner     <= this_other;
                together    <= has_partner && partner == this_other ? together + 16'd1 : 16'd1;
                since       <= SEEDED;
                pause       <= 3'd3;
                state       <= YOUNGER;
            end else if (pair_done) begin
                other <= other + {{SLOT_W{1'b0}}, 1'b1};
                state <= SCAN;
            end
            YOUNGER: begin
                c_take <= 1'b1;
                at     <= this_slot;
                pause  <= 3'd4;
                state  <= OLDER;
            end
            OLDER: begin
                other_older <= older;
                down        <= {1'b0, step_log2} + {2'b00, join_life};
                state       <= LIVED;
            end
            LIVED: begin
                c_take   <= other_older;
                c_divide <= 1'b1;
                pause    <= 3'd1;
                state    <= STEPS;
            end
            STEPS:
            if (!dividing) state <= JOIN;
            JOIN: begin
                scans_touch <= 1'b0;
                stays       <= this_slot;
                goes        <= this_other;
                if (visible[this_slot] != visible[this_other] ? visible[this_other] : keep_older ? other_older : weaker) begin
                    stays <= this_other;
                    goes  <= this_slot;
                end
                state <= enough ? MERGE : MEET;
            end
            MEET: begin
                c_meet  <= 1'b1;
                c_touch <= 1'b1;
                again   <= 1'b0;
                since   <= visible[this_slot] ? REPORTED : SEEDED;
                down    <= {1'b0, step_log2};
                pause   <= 3'd2;
                state   <= SINCE;
            end
            SINCE: begin
                c_take   <= 1'b1;
                c_divide <= 1'b1;
                state    <= MET;
            end
            MET:
            if (meet_done) begin
                if (visible[this_slot]) begin
                    meets    <= meets_now;
                    o_hidden <= hidden_now;
                    state    <= REPORT;
                end else if (middle_held && !again) state <= LAPSE;
                else if (touches) begin
                    other <= {1'b0, touched};
                    at    <= touched;
                    state <= TOUCH;
                end else begin
                    pause <= 3'd5;
                    state <= BORN;
                end
            end
            TOUCH: begin
                writes <= 1'b1;
                op     <= OP_READ;
                state  <= TOUCHED;
            end
            TOUCHED:
            if (read_done) begin
                scans_touch <= 1'b1;
                stays       <= support < r_support ? this_other : this_slot;
                goes        <= support < r_support ? this_slot : this_other;
                at          <= this_slot;
                pause       <= 3'd1;
                state       <= MERGE;
            end
            REPORT:
            if (!dividing) begin
                kind  <= `EVCOT_KIND_MOVED;
                after <= DONE;
                state <= overdue ? SAY : DONE;
            end
            BORN: begin
                kind  <= `EVCOT_KIND_BORN;
                after <= DONE;
                state <= DONE;
                if (appears) begin
                    visible[at]   <= 1'b1;
                    candidate[at] <= 1'b0;
                    keep_id       <= 1'b1;
                    pause         <= 3'd4;
                    state         <= SAY;
                end
            end

            // ---- two become one --------------------------------------------------------------------------------------
            MERGE: begin
                since <= UNTIL;
                pause <= 3'd3;
                state <= GONE;
                if (stays == this_slot) begin
                    writes <= 1'b1;
                    op     <= OP_FULL;
                    stored <= 1'b0;
                    keep   <= 1'b1;
                    state  <= RELOAD;
                end
            end
            RELOAD:
            if (stored) begin
                at    <= goes;
                state <= RELOADS;
            end
            RELOADS: begin
                writes <= 1'b1;
                op     <= OP_READ;
                state  <= GOES;
            end
            GOES:
            if (read_done) begin
                support <= r_support;
                state   <= GONE;
            end
            GONE: begin
                c_hold   <= 1'b1;
                c_take   <= 1'b1;
                at       <= stays;
                pause    <= 3'd2;
                state    <= STAYS;
            end
            STAYS: begin
                stays_id <= id;
                at       <= goes;
                kind     <= `EVCOT_KIND_MERGED;
                after    <= RETURN;
                pause    <= 3'd2;
                state    <= visible[goes] ? SAY : RETURN;
            end
            RETURN:
            if (!lane) begin
                c_settle <= 1'b1;
                since    <= UNTIL;
                at       <= stays;
                state    <= RETURNS;
            end
            RETURNS: begin
                writes <= 1'b1;
                op     <= OP_READ;
                state  <= UNITE;
            end
            UNITE:
            if (read_done) begin
                support         <= both_support[SUP_W] ? {SUP_W{1'b1}} : both_support[SUP_W-1:0];
                o_marks         <= 4'hf;
                has_partner     <= 1'b0;
                together        <= 16'd0;
                visible[goes]   <= 1'b0;
                candidate[goes] <= 1'b0;
                state <= UNITED;
            end
            UNITED: begin
                c_reflect <= 1'b1;
                pause     <= 3'd1;
                state     <= COVER;
            end
            COVER: begin
                c_cover <= 1'b1;
                pause   <= 3'd1;
                state   <= COVERED;
            end
            COVERED: begin
                c_settle <= 1'b1;
                pause    <= 3'd5;
                state    <= BINS;
            end
            BINS: begin
                looked        <= 8'd0;
                log2          <= {bin_log2(length_y), bin_log2(length_x)};
                keep_until    <= !older;
                why           <= FOR_MERGE;
                after_clear   <= PLACE;
                state         <= CLEAR;
            end
            MERGED:
            if (op_free) begin
                writes <= 1'b1;
                op     <= OP_ALL;
                stored <= 1'b0;
                keep   <= 1'b1;
                kind   <= `EVCOT_KIND_MOVED;
                after  <= GO_ON;
                state  <= is_visible ? SAY : GO_ON;
            end
            GO_ON:
            if (stored) begin
                slot  <= slot + {{SLOT_W{1'b0}}, 1'b1};
                state <= NEXT;
                if (stays == this_slot) begin
                    slot    <= slot;
                    c_meet  <= scans_touch;
                    c_touch <= 1'b0;
                    since   <= SEEDED;
                    again   <= 1'b1;
                    state   <= scans_touch ? MET : MEET;
                end
            end
            default: state <= REST;
        endcase

        if (rst) begin
            state     <= REST;
            pause     <= 3'd0;
            visible   <= {N{1'b0}};
            candidate <= {N{1'b0}};
            settled   <= {N{1'b0}};
            births    <= {ID_W{1'b0}};
            writes    <= 1'b0;
            bin       <= 4'd15;
            keep_id   <= 1'b0;
        end
    end

    wire unused = &{1'b0, slow_gain[6:4]};

endmodule

`default_nettype wire
