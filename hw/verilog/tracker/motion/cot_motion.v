// SPDX-License-Identifier: Apache-2.0
// N cluster trackers with boxes and velocities, which meet without merging: the array with the rules of docs/motion.md.
//
// Tokens and streams are those of cot_array.v, but for the record. A slot's context lies in a memory; what is done to a slot is done in
// registers, the working copy, one slot at a time: an event is compared with all boxes and windows at once, then its owner's context is
// read, changed and written back. Corrections and motion steps are sequences of clocks, in which no event is decided.
//
// Registers: `mode` of each slot, off or seeded, and those of motion_regs.v. A write of `mode` restarts the slot before the next
// token; after one of `step_log2` steps are at multiples of the new length. Others are to be written while the array is idle.
//
// Latency:    unstalled, from the clock edge that takes the event: an owned event after 8 clocks, a passed one after 6; a record after
//             about 50, depending on values.
// Throughput: 4 clocks for an owned event, 3 for a passed one, 14 for the first of a candidate. About 45 more for a correction, 140 if
//             it looks for gaps; for a motion step N + 4, and for each slot that lives 25, and up to 12 N where slots are compared.
// Stall:      every output is held until accepted.
// Reset:      turns all slots off, and gives the registers their defaults.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

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
    output reg                 m_cm_valid,
    input  wire                m_cm_ready,
    output reg  [1:0]          m_cm_kind,
    output reg  [SLOT_W-1:0]   m_cm_slot,
    output reg  [ID_W-1:0]     m_cm_id,
    output reg  [ID_W-1:0]     m_cm_other,   // MERGED: the track that stays; else 0
    output reg  [SIDE_W-1:0]   m_cm_x,       // middle, 2^-12 px, signed
    output reg  [SIDE_W-1:0]   m_cm_y,
    output reg  [SIDE_W-1:0]   m_cm_width,   // 2^-12 px
    output reg  [SIDE_W-1:0]   m_cm_height,
    output reg  [15:0]         m_cm_v_x,     // 2^-12 px per motion step, signed
    output reg  [15:0]         m_cm_v_y,
    output reg  [9:0]          m_cm_n_ev,
    output reg  [SUP_W-1:0]    m_cm_support,
    output reg  [SEQ_W-1:0]    m_cm_seq,
    output reg  [TIME_W-1:0]   m_cm_time,

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

    localparam PX_W      = SIDE_W - 12;  // bits of a bound in pixels
    localparam OFF_W     = SIDE_W + 5;   // bits of an offset: of up to 1023 events
    localparam REL_W     = RADIX_W + 2;
    localparam CONTEXT_W = 4 * SIDE_W + 4 * OFF_W + 8 * PX_W + SUP_W + 2 * TIME_W + SLOT_W + 158;
    localparam [31:0] SLOTS = N;

    // What the sequencer does.
    localparam [6:0] READY   = 7'd0;   // waits for a token, or a restart
    localparam [6:0] LOAD    = 7'd1;   // an event: reads its owner's context
    localparam [6:0] SEED    = 7'd2;   // clears the bins of a candidate that begins
    localparam [6:0] SEEDED  = 7'd3;   // and places it
    localparam [6:0] CLEAR   = 7'd68;  // clears the bins, by the lengths that are known since the clock before
    localparam [6:0] TAKE    = 7'd4;   // compares the event with the sides
    localparam [6:0] MOVE    = 7'd5;   // moves them
    localparam [6:0] WINDOW  = 7'd6;   // waits for box and window
    localparam [6:0] RECORD  = 7'd7;   // hands over a record
    localparam [6:0] RESTART = 7'd8;   // `mode` was written: reads the slot
    localparam [6:0] FREE    = 7'd9;   // ends a life at a restart

    localparam [6:0] SHRINK   = 7'd10;  // a correction: how far the sides move inwards
    localparam [6:0] SHRINK_1 = 7'd70;
    localparam [6:0] INWARDS  = 7'd11;
    localparam [6:0] LOOK     = 7'd12;  // are bins looked at?
    localparam [6:0] LOOK_AT  = 7'd13;  // on which axes?
    localparam [6:0] LOOK_GO  = 7'd14;  // each axis
    localparam [6:0] LOOKING  = 7'd15;
    localparam [6:0] CUT_AT   = 7'd16;
    localparam [6:0] CUT_EDGE = 7'd17;
    localparam [6:0] CUT      = 7'd18;
    localparam [6:0] LOOKED   = 7'd19;  // clears the bins
    localparam [6:0] TICKS    = 7'd20;  // since the last correction
    localparam [6:0] GAIN     = 7'd21;
    localparam [6:0] SPEED    = 7'd22;  // waits for the velocity
    localparam [6:0] USUAL    = 7'd23;  // the usual time, and the next N_ev
    localparam [6:0] GRANT    = 7'd24;  // the time until the deadline
    localparam [6:0] LIFE     = 7'd25;
    localparam [6:0] CORRECT  = 7'd26;  // the deadline; then the window
    localparam [6:0] CORRECTED = 7'd27;

    localparam [6:0] NEXT    = 7'd28;  // a motion step: the next slot
    localparam [6:0] FETCH   = 7'd29;
    localparam [6:0] AGE     = 7'd30;  // has its life ended? has it been silent for long?
    localparam [6:0] GO      = 7'd31;  // moves it
    localparam [6:0] LONG    = 7'd32;  // is it too long?
    localparam [6:0] SHORTEN = 7'd33;
    localparam [6:0] PLACED  = 7'd34;
    localparam [6:0] LAPSE   = 7'd35;  // the slot becomes free
    localparam [6:0] DONE    = 7'd36;  // the slot is done

    localparam [6:0] SCAN    = 7'd37;  // compares it with the others: the next one
    localparam [6:0] LOAD_IT = 7'd38;
    localparam [6:0] SCAN_1  = 7'd39;
    localparam [6:0] SCAN_2  = 7'd40;
    localparam [6:0] SCAN_3  = 7'd41;
    localparam [6:0] SCAN_4  = 7'd71;
    localparam [6:0] SCAN_5  = 7'd72;
    localparam [6:0] FOUND   = 7'd42;  // what follows

    localparam [6:0] PARTNER = 7'd43;  // it has a partner
    localparam [6:0] YOUNGER = 7'd44;  // which of both is younger
    localparam [6:0] OLDER   = 7'd45;
    localparam [6:0] LIVED   = 7'd46;  // how long has it lived
    localparam [6:0] STEPS   = 7'd47;  // in steps
    localparam [6:0] ENOUGH  = 7'd48;
    localparam [6:0] JOIN    = 7'd49;
    localparam [6:0] JOINED  = 7'd50;

    localparam [6:0] MERGE   = 7'd51;  // writes the slot back
    localparam [6:0] MERGE_1 = 7'd52;
    localparam [6:0] MERGE_2 = 7'd53;
    localparam [6:0] MERGE_3 = 7'd54;  // reads the one that goes
    localparam [6:0] MERGE_4 = 7'd55;
    localparam [6:0] MERGE_5 = 7'd56;  // reads the one that stays
    localparam [6:0] MERGE_6 = 7'd57;
    localparam [6:0] UNITE   = 7'd69;
    localparam [6:0] UNITED  = 7'd58;
    localparam [6:0] MERGED  = 7'd59;
    localparam [6:0] GO_ON   = 7'd60;

    localparam [6:0] BIRTH   = 7'd61;  // does it become visible?
    localparam [6:0] BIRTH_1 = 7'd62;
    localparam [6:0] BIRTH_2 = 7'd63;
    localparam [6:0] BIRTH_3 = 7'd64;
    localparam [6:0] BORN    = 7'd65;
    localparam [6:0] REPORT  = 7'd66;  // is it time for a record?
    localparam [6:0] REPORT_1 = 7'd67;

    // Why slots are compared.
    localparam [1:0] FOR_PARTNER = 2'd0;  // is one the partner?
    localparam [1:0] FOR_OWNER   = 2'd1;  // does a visible one hold the candidate's middle?
    localparam [1:0] FOR_TOUCH   = 2'd2;  // does its box touch another candidate's?
    localparam [1:0] FOR_HIDING  = 2'd3;  // which visible ones hide its sides?

    // ---- registers -------------------------------------------------------------------------------------------------

    wire [4:0]  step_log2;
    wire [15:0] side_step, birth_support;
    wire [11:0] side_max;
    wire [14:0] speed_max;
    wire [3:0]  side_share, side_shrink, gain_log2, friction, ring_across, ring_along, ring_any, elongation, life_log2, birth_travel;
    wire [3:0]  gap_share, join_life, join_speed, join_reach;
    wire [2:0]  gain_slow;
    wire [5:0]  settle;
    wire [9:0]  nev_low, nev_high, join_steps, report_steps;
    wire [7:0]  seed_px, ring_px, ring_max, birth_px, gap_corrections, gap_px, join_px;
    wire [23:0] detect_ticks, life_ticks, coast_ticks, birth_ticks;
    wire        keep_older;

    motion_regs u_regs (
        .clk            (clk),
        .rst            (rst),
        .cfg_valid      (cfg_valid),
        .cfg_addr       (cfg_addr),
        .cfg_data       (cfg_data),
        .step_log2      (step_log2),
        .side_step      (side_step),
        .side_share     (side_share),
        .side_shrink    (side_shrink),
        .side_max       (side_max),
        .gain_log2      (gain_log2),
        .gain_slow      (gain_slow),
        .settle         (settle),
        .speed_max      (speed_max),
        .friction       (friction),
        .nev_low        (nev_low),
        .nev_high       (nev_high),
        .seed_px        (seed_px),
        .ring_px        (ring_px),
        .ring_max       (ring_max),
        .ring_across    (ring_across),
        .ring_along     (ring_along),
        .ring_any       (ring_any),
        .elongation     (elongation),
        .detect_ticks   (detect_ticks),
        .life_log2      (life_log2),
        .life_ticks     (life_ticks),
        .coast_ticks    (coast_ticks),
        .birth_support  (birth_support),
        .birth_px       (birth_px),
        .birth_ticks    (birth_ticks),
        .birth_travel   (birth_travel),
        .gap_corrections(gap_corrections),
        .gap_share      (gap_share),
        .gap_px         (gap_px),
        .join_steps     (join_steps),
        .join_life      (join_life),
        .join_speed     (join_speed),
        .join_reach     (join_reach),
        .join_px        (join_px),
        .keep_older     (keep_older),
        .report_steps   (report_steps)
    );

    wire         writes_mode = cfg_valid && cfg_addr == `EVCOT_MREG_MODE;
    reg          restep;      // step_log2 was written, or reset: the next step is set
    reg  [N-1:0] seeded;      // `mode`
    reg  [N-1:0] restart;     // it was written
    wire         restarts;
    wire [SLOT_W-1:0] restart_slot;

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_restart (
        .asked (restarts),
        .among (restart),
        .any   (restarts),
        .lowest(restart_slot)
    );

    // ---- slots -----------------------------------------------------------------------------------------------------

    reg [6:0]        state, after, after_clear, after_record;
    reg [SLOT_W-1:0] at;      // the slot whose context is read and written
    reg [SLOT_W:0]   slot;    // of a motion step
    reg [SLOT_W:0]   other;   // with which it is compared
    reg              store;   // the working copy is written
    reg              place;   // and its box and window

    reg [N-1:0] visible, candidate;
    wire [N-1:0] lives = visible | candidate;
    wire         is_visible = visible[at];

    // The working copy, and what the memory has of the slot `at`.
    reg  signed [SIDE_W-1:0]    lo_x;
    reg  signed [SIDE_W-1:0]    hi_x;
    reg  signed [SIDE_W-1:0]    lo_y;
    reg  signed [SIDE_W-1:0]    hi_y;
    reg  signed [15:0]          v_x;
    reg  signed [15:0]          v_y;
    reg  signed [OFF_W-1:0]     off_lo_x;
    reg  signed [OFF_W-1:0]     off_hi_x;
    reg  signed [OFF_W-1:0]     off_lo_y;
    reg  signed [OFF_W-1:0]     off_hi_y;
    reg  [3:0]                  beyond;
    reg  [3:0]                  hidden;
    reg                         meets;
    reg  [9:0]                  count;
    reg  [9:0]                  n_ev;
    reg  [SUP_W-1:0]            support;
    reg  [5:0]                  corrections;
    reg  [TIME_W-1:0]           last;
    reg  [23:0]                 usual;
    reg  [TIME_W-1:0]           deadline;
    reg                         has_partner;
    reg  [SLOT_W-1:0]           partner;
    reg  [15:0]                 together;
    reg  [4:0]                  log2_x;
    reg  [4:0]                  log2_y;
    reg  [7:0]                  looked;
    reg  [15:0]                 used_x;
    reg  [15:0]                 used_y;
    reg  [4*PX_W-1:0]           box;
    reg  [4*PX_W-1:0]           window;

    wire signed [SIDE_W-1:0]    o_lo_x;
    wire signed [SIDE_W-1:0]    o_hi_x;
    wire signed [SIDE_W-1:0]    o_lo_y;
    wire signed [SIDE_W-1:0]    o_hi_y;
    wire signed [15:0]          o_v_x;
    wire signed [15:0]          o_v_y;
    wire signed [OFF_W-1:0]     o_off_lo_x;
    wire signed [OFF_W-1:0]     o_off_hi_x;
    wire signed [OFF_W-1:0]     o_off_lo_y;
    wire signed [OFF_W-1:0]     o_off_hi_y;
    wire [3:0]                  o_beyond;
    wire [3:0]                  o_hidden;
    wire                        o_meets;
    wire [9:0]                  o_count;
    wire [9:0]                  o_n_ev;
    wire [SUP_W-1:0]            o_support;
    wire [5:0]                  o_corrections;
    wire [TIME_W-1:0]           o_last;
    wire [23:0]                 o_usual;
    wire [TIME_W-1:0]           o_deadline;
    wire                        o_has_partner;
    wire [SLOT_W-1:0]           o_partner;
    wire [15:0]                 o_together;
    wire [4:0]                  o_log2_x;
    wire [4:0]                  o_log2_y;
    wire [7:0]                  o_looked;
    wire [15:0]                 o_used_x;
    wire [15:0]                 o_used_y;
    wire [4*PX_W-1:0]           o_box;
    wire [4*PX_W-1:0]           o_window;

    reg  [CONTEXT_W-1:0] contexts[0:(1<<SLOT_W)-1];
    wire [CONTEXT_W-1:0] context_read = contexts[at];
    wire [CONTEXT_W-1:0] working = {
        lo_x, hi_x, lo_y, hi_y, v_x, v_y, off_lo_x, off_hi_x, off_lo_y, off_hi_y, beyond, hidden, meets, count,
        n_ev, support, corrections, last, usual, deadline, has_partner, partner, together, log2_x, log2_y, looked,
        used_x, used_y, box, window
    };
    assign {
        o_lo_x, o_hi_x, o_lo_y, o_hi_y, o_v_x, o_v_y, o_off_lo_x, o_off_hi_x, o_off_lo_y, o_off_hi_y, o_beyond,
        o_hidden, o_meets, o_count, o_n_ev, o_support, o_corrections, o_last, o_usual, o_deadline, o_has_partner,
        o_partner, o_together, o_log2_x, o_log2_y, o_looked, o_used_x, o_used_y, o_box, o_window
    } = context_read;

    // Of each slot, written at one place each.
    reg [TIME_W-1:0]   seeded_at  [0:(1<<SLOT_W)-1];
    reg [TIME_W-1:0]   reported_at[0:(1<<SLOT_W)-1];
    reg [ID_W-1:0]     ids        [0:(1<<SLOT_W)-1];
    reg [2*SIDE_W+1:0] starts     [0:(1<<SLOT_W)-1];  // sums of both sides at the fourth correction
    wire [TIME_W-1:0]      its_seeded   = seeded_at[at];
    wire [TIME_W-1:0]      its_reported = reported_at[at];
    wire [ID_W-1:0]        its_id       = ids[at];
    wire signed [SIDE_W:0] start_x, start_y;
    assign {start_x, start_y} = starts[at];

    // What follows from the working copy.
    wire signed [SIDE_W:0] sum_x   = {lo_x[SIDE_W-1], lo_x} + {hi_x[SIDE_W-1], hi_x};
    wire signed [SIDE_W:0] sum_y   = {lo_y[SIDE_W-1], lo_y} + {hi_y[SIDE_W-1], hi_y};
    wire signed [SIDE_W:0] apart_x = {hi_x[SIDE_W-1], hi_x} - {lo_x[SIDE_W-1], lo_x};
    wire signed [SIDE_W:0] apart_y = {hi_y[SIDE_W-1], hi_y} - {lo_y[SIDE_W-1], lo_y};
    wire [SIDE_W-1:0]      side_x  = apart_x[SIDE_W] ? {SIDE_W{1'b0}} : apart_x[SIDE_W-1:0];
    wire [SIDE_W-1:0]      side_y  = apart_y[SIDE_W] ? {SIDE_W{1'b0}} : apart_y[SIDE_W-1:0];
    wire [PX_W-1:0]        length_x = side_x[SIDE_W-1:12];
    wire [PX_W-1:0]        length_y = side_y[SIDE_W-1:12];
    reg  [PX_W:0]          outline;
    wire [14:0]            speed_x = v_x[15] ? -v_x[14:0] : v_x[14:0];
    wire [14:0]            speed_y = v_y[15] ? -v_y[14:0] : v_y[14:0];
    wire                   moves   = is_visible || corrections >= 6'd4;  // its velocity counts

    // Bins of 2^n pixels, four to eight for the whole side.
    function [4:0] bin_log2;
        input [PX_W-1:0] length;
        integer k;
        begin
            bin_log2 = 5'd0;
            for (k = 4; k <= PX_W; k = k + 1) if (length[k-1]) bin_log2 = k[4:0] - 5'd3;
        end
    endfunction

    // ---- input -----------------------------------------------------------------------------------------------------

    reg              in_valid, in_event, in_skip, in_p;
    reg [X_W-1:0]    in_x;
    reg [Y_W-1:0]    in_y;
    reg [TIME_W-1:0] in_time;
    reg              known;      // whose the token's event is, and whether a motion step is due before it
    reg              due;
    reg [SEQ_W-1:0]  seq;        // number of the next event
    reg [TIME_W-1:0] now, next_step;
    wire             room, output_empty;
    wire [TIME_W-1:0] until_step = in_time - next_step;

    // What does not change who owns an event.
    wire calm     = state == READY || state == LOAD || state == TAKE || state == MOVE;
    wire decides  = state == READY && !restarts && known && !due && (room || !in_event);
    wire steps    = state == READY && !restarts && known && due;
    wire owned, begins, shared;
    wire [SLOT_W-1:0] owner;

    assign s_ready = !in_valid;

    motion_match #(
        .N     (N),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .PX_W  (PX_W),
        .SLOT_W(SLOT_W)
    ) u_match (
        .clk       (clk),
        .asked     (in_valid && calm && !known),
        .x         (in_x),
        .y         (in_y),
        .visible   (visible),
        .candidate (candidate),
        .may_begin (seeded & ~lives),
        .place     (place),
        .place_slot(at),
        .box       (box),
        .window    (window),
        .owned     (owned),
        .begins    (begins),
        .shared    (shared),
        .owner     (owner)
    );

    // ---- the event that is decided -----------------------------------------------------------------------------------

    reg [X_W-1:0]    x;
    reg [Y_W-1:0]    y;
    reg              p, is_shared, is_first, full;
    reg [TIME_W-1:0] op_time;  // of the event or of the motion step
    reg [SEQ_W-1:0]  op_seq;
    reg [17:0]       out, back;
    reg              in_bin_x, in_bin_y;
    reg [3:0]        bin_x, bin_y;
    reg [REL_W-1:0]  rel_x, rel_y;

    wire [15:0] share = side_step >> side_share;
    reg  [15:0] one_back, one_out;

    // The pixels from that of the low side: a - b - c is a + ~b + 1 - c, whose lowest bit here is the carry.
    wire [PX_W+1:0] place_x = {{(PX_W + 1 - X_W) {1'b0}}, x, 1'b1} + ~{lo_x[SIDE_W-1], lo_x[SIDE_W-1:11]};
    wire [PX_W+1:0] place_y = {{(PX_W + 1 - Y_W) {1'b0}}, y, 1'b1} + ~{lo_y[SIDE_W-1], lo_y[SIDE_W-1:11]};
    wire [PX_W:0]   from_x = place_x[PX_W+1:1];
    wire [PX_W:0]   from_y = place_y[PX_W+1:1];
    wire [PX_W:0] bins_x = from_x >> log2_x;
    wire [PX_W:0] bins_y = from_y >> log2_y;
    wire [PX_W-1:0] window_lo_x = window[3*PX_W+:PX_W];
    wire [PX_W-1:0] window_lo_y = window[PX_W+:PX_W];
    wire [PX_W+REL_W-1:0] wide_rel_x, wide_rel_y;  // its lower part is what counts
    wire [PX_W-1:0] in_window_x = {{(PX_W - X_W) {1'b0}}, x} - window_lo_x;
    wire [PX_W-1:0] in_window_y = {{(PX_W - Y_W) {1'b0}}, y} - window_lo_y;
    assign wide_rel_x = {{REL_W{1'b0}}, in_window_x};
    assign wide_rel_y = {{REL_W{1'b0}}, in_window_y};

    wire [1:0] beyond_x, beyond_y;
    wire signed [SIDE_W-1:0] moved_lo_x, moved_hi_x, moved_lo_y, moved_hi_y;
    wire signed [OFF_W-1:0]  moved_off_lo_x, moved_off_hi_x, moved_off_lo_y, moved_off_hi_y;

    motion_axis #(
        .AT_W  (X_W),
        .SIDE_W(SIDE_W),
        .OFF_W (OFF_W)
    ) u_axis_x (
        .clk        (clk),
        .compare    (state == TAKE),
        .place      (x),
        .lo         (lo_x),
        .hi         (hi_x),
        .off_lo     (off_lo_x),
        .off_hi     (off_hi_x),
        .hidden     (hidden[1:0]),
        .out        (out),
        .back       (back),
        .beyond     (beyond_x),
        .lo_next    (moved_lo_x),
        .hi_next    (moved_hi_x),
        .off_lo_next(moved_off_lo_x),
        .off_hi_next(moved_off_hi_x)
    );

    motion_axis #(
        .AT_W  (Y_W),
        .SIDE_W(SIDE_W),
        .OFF_W (OFF_W)
    ) u_axis_y (
        .clk        (clk),
        .compare    (state == TAKE),
        .place      (y),
        .lo         (lo_y),
        .hi         (hi_y),
        .off_lo     (off_lo_y),
        .off_hi     (off_hi_y),
        .hidden     (hidden[3:2]),
        .out        (out),
        .back       (back),
        .beyond     (beyond_y),
        .lo_next    (moved_lo_y),
        .hi_next    (moved_hi_y),
        .off_lo_next(moved_off_lo_y),
        .off_hi_next(moved_off_hi_y)
    );

    // ---- box and window ----------------------------------------------------------------------------------------------

    reg               window_start;
    wire              window_done;
    wire [4*PX_W-1:0] box_next, window_next;

    motion_window #(
        .SIDE_W(SIDE_W)
    ) u_window (
        .clk        (clk),
        .rst        (rst),
        .start      (window_start),
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
        .box        (box_next),
        .window     (window_next)
    );

    // ---- gaps --------------------------------------------------------------------------------------------------------

    reg            look, on_y, across_x, across_y;
    reg [PX_W+3:0] long_x, long_y;   // so long must the other axis be
    reg [PX_W-1:0] was_x, was_y;     // lengths before a cut
    reg [PX_W-1:0] cut_px;
    reg signed [SIDE_W-1:0] edge_at;
    wire           look_done, gap_found, low_stays;
    wire [3:0]     gap_begins, gap_ends;
    wire           looks_x = across_x || {4'd0, was_x} >= long_y;
    wire           looks_y = across_y || {4'd0, was_y} >= long_x;
    wire [PX_W-1:0] least_gap = {{(PX_W - 8) {1'b0}}, gap_px};
    wire [PX_W-1:0] half_other = {1'b0, on_y ? was_x[PX_W-1:1] : was_y[PX_W-1:1]};
    reg  [PX_W-1:0] narrowest;

    motion_gaps #(
        .PX_W  (PX_W),
        .SLOT_W(SLOT_W)
    ) u_gaps (
        .clk      (clk),
        .rst      (rst),
        .slot     (at),
        .count    (state == MOVE && !is_shared && gap_corrections != 8'd0),
        .in_x     (in_bin_x),
        .in_y     (in_bin_y),
        .bin_x    (bin_x),
        .bin_y    (bin_y),
        .first_x  (!used_x[bin_x]),
        .first_y  (!used_y[bin_y]),
        .look     (look),
        .on_y     (on_y),
        .used     (on_y ? used_y : used_x),
        .bin_log2 (on_y ? log2_y : log2_x),
        .narrowest(narrowest),
        .gap_share(gap_share),
        .done     (look_done),
        .found    (gap_found),
        .low_stays(low_stays),
        .begins   (gap_begins),
        .ends     (gap_ends)
    );

    // ---- velocity ----------------------------------------------------------------------------------------------------

    reg               speed_start;
    reg  [TIME_W-1:0] age;     // since the last correction, or since another time
    reg  [23:0]       ticks;
    reg  [3:0]        gain;
    wire              speed_done;
    wire signed [15:0] v_x_next, v_y_next;
    wire [6:0]        slow_gain = {1'b0, corrections >> gain_slow} + 7'd1;
    wire [3:0]        least_gain = slow_gain < {3'd0, gain_log2} ? slow_gain[3:0] : gain_log2;

    motion_velocity #(
        .OFF_W(OFF_W)
    ) u_velocity (
        .clk      (clk),
        .rst      (rst),
        .start    (speed_start),
        .ticks    (ticks),
        .off_lo_x (off_lo_x),
        .off_hi_x (off_hi_x),
        .off_lo_y (off_lo_y),
        .off_hi_y (off_hi_y),
        .slower   (corrections < settle),
        .gain     (gain),
        .step_log2(step_log2),
        .speed_max(speed_max),
        .v_x      (v_x),
        .v_y      (v_y),
        .done     (speed_done),
        .v_x_next (v_x_next),
        .v_y_next (v_y_next)
    );

    // ---- a slot and the others -----------------------------------------------------------------------------------------

    wire       alike, weaker, boxes_touch, middle_in, meet;
    wire [3:0] hides;

    motion_pair #(
        .PX_W (PX_W),
        .SUP_W(SUP_W)
    ) u_pair (
        .clk          (clk),
        .start        (state == LOAD_IT),
        .one_box      (box),
        .one_window   (window),
        .one_v_x      (v_x),
        .one_v_y      (v_y),
        .one_support  (support),
        .other_box    (o_box),
        .other_window (o_window),
        .other_v_x    (o_v_x),
        .other_v_y    (o_v_y),
        .other_support(o_support),
        .join_speed   (join_speed),
        .join_reach   (join_reach),
        .join_px      (join_px),
        .alike        (alike),
        .weaker       (weaker),
        .boxes_touch  (boxes_touch),
        .middle_in    (middle_in),
        .meet         (meet),
        .hides        (hides)
    );

    // ---- output ------------------------------------------------------------------------------------------------------

    reg decided, decided_owned;  // an event goes to the output

    array_output #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .REL_W (REL_W),
        .SEQ_W (SEQ_W),
        .SLOT_W(SLOT_W)
    ) u_output (
        .clk         (clk),
        .rst         (rst),
        .s_valid     (decided),
        .s_owned     (decided_owned),
        .s_slot      (at),
        .s_rel_x     (rel_x),
        .s_rel_y     (rel_y),
        .s_x         (x),
        .s_y         (y),
        .s_p         (p),
        .s_seq       (op_seq),
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

    // ---- the sequencer -----------------------------------------------------------------------------------------------

    reg [1:0]        kind, scan;
    reg [SIDE_W-1:0] part_x, part_y;     // by which unmarked sides move inwards
    reg [31:0]       grant;              // ticks until the deadline
    reg              ended, too_long_x, too_long_y;
    reg [SLOT_W-1:0] stays, goes;
    reg [ID_W-1:0]   stays_id;
    reg [TIME_W-1:0] other_age, lived;
    reg              other_older;
    reg [5:0]        shift;
    reg [15:0]       enough;             // steps together
    reg [ID_W-1:0]   births;
    reg signed [SIDE_W+1:0] way_x, way_y;  // twice the way since the fourth correction
    reg [SIDE_W:0]   sides;              // sum of both
    reg [SIDE_W+1:0] far;                // so much must a way be
    reg              too_small, goes_far;
    reg [29:0]       report_ticks;

    wire [SLOT_W-1:0] this_slot  = slot[SLOT_W-1:0];
    wire [SLOT_W-1:0] this_other = other[SLOT_W-1:0];
    wire [N-1:0]      among      = scan == FOR_PARTNER ? lives : scan == FOR_TOUCH ? candidate : visible;
    wire signed [SIDE_W:0] longest = {{(SIDE_W - 23) {1'b0}}, side_max, 12'd0};
    wire signed [SIDE_W-1:0] half_longest = {{(SIDE_W - 23) {1'b0}}, side_max, 11'd0};
    wire signed [SIDE_W:0] least_side = {{(SIDE_W - 19) {1'b0}}, birth_px, 12'd0};
    wire [TIME_W-1:0] over_deadline = op_time - deadline;
    wire [TIME_W-1:0] later = o_deadline - deadline;
    wire [SUP_W:0]    both_support = {1'b0, support} + {1'b0, o_support};
    wire [SUP_W:0]    more_support = {1'b0, support} + {{SUP_W{1'b0}}, 1'b1};
    wire [SUP_W+15:0] wide_support = {16'd0, support};
    wire [SUP_W+15:0] wide_birth   = {{SUP_W{1'b0}}, birth_support};
    wire signed [24:0] slower_by = {1'b0, ticks} - {1'b0, usual};
    wire [15:0]       lived_steps = |lived[TIME_W-1:16] ? 16'hffff : lived[15:0];
    wire [SIDE_W+1:0] abs_way_x = way_x[SIDE_W+1] ? -way_x : way_x;
    wire [SIDE_W+1:0] abs_way_y = way_y[SIDE_W+1] ? -way_y : way_y;
    wire              last_other = other == SLOTS[SLOT_W:0];

    // Where a motion step takes the sides, and whether that is within reach: from -2^REACH to below 2^(REACH + 1) pixels.
    wire signed [SIDE_W-1:0] gone_lo_x = lo_x + {{(SIDE_W - 16) {v_x[15]}}, v_x};
    wire signed [SIDE_W-1:0] gone_hi_x = hi_x + {{(SIDE_W - 16) {v_x[15]}}, v_x};
    wire signed [SIDE_W-1:0] gone_lo_y = lo_y + {{(SIDE_W - 16) {v_y[15]}}, v_y};
    wire signed [SIDE_W-1:0] gone_hi_y = hi_y + {{(SIDE_W - 16) {v_y[15]}}, v_y};
    wire within_x = (gone_lo_x[SIDE_W-1:SIDE_W-4] == 4'hf || gone_lo_x[SIDE_W-1:SIDE_W-3] == 3'd0)
                 && (gone_hi_x[SIDE_W-1:SIDE_W-4] == 4'hf || gone_hi_x[SIDE_W-1:SIDE_W-3] == 3'd0);
    wire within_y = (gone_lo_y[SIDE_W-1:SIDE_W-4] == 4'hf || gone_lo_y[SIDE_W-1:SIDE_W-3] == 3'd0)
                 && (gone_hi_y[SIDE_W-1:SIDE_W-4] == 4'hf || gone_hi_y[SIDE_W-1:SIDE_W-3] == 3'd0);

    always @(posedge clk) begin
        store        <= 1'b0;
        place        <= 1'b0;
        window_start <= 1'b0;
        speed_start  <= 1'b0;
        look         <= 1'b0;
        decided      <= 1'b0;
        one_back     <= share;
        one_out      <= side_step - share;

        if (store) contexts[at] <= working;
        if (m_cm_ready) m_cm_valid <= 1'b0;

        // A token is taken, then compared, in a clock in which nothing that it is compared with changes.
        if (s_valid && s_ready) begin
            in_valid <= 1'b1;
            in_event <= s_event;
            in_skip  <= s_skip;
            in_x     <= s_x;
            in_y     <= s_y;
            in_p     <= s_p;
            in_time  <= in_time + {{(TIME_W - TICK_W) {1'b0}}, s_tick};
        end
        known <= in_valid && calm && !place && !restep && !cfg_valid && !decides && !steps;
        due   <= !until_step[TIME_W-1];

        // the working copy is read
        if (state == LOAD || state == RESTART || state == FETCH || state == MERGE_4 || state == MERGE_6) begin
            lo_x        <= o_lo_x;
            hi_x        <= o_hi_x;
            lo_y        <= o_lo_y;
            hi_y        <= o_hi_y;
            v_x         <= o_v_x;
            v_y         <= o_v_y;
            off_lo_x    <= o_off_lo_x;
            off_hi_x    <= o_off_hi_x;
            off_lo_y    <= o_off_lo_y;
            off_hi_y    <= o_off_hi_y;
            beyond      <= o_beyond;
            hidden      <= o_hidden;
            meets       <= o_meets;
            count       <= o_count;
            n_ev        <= o_n_ev;
            support     <= o_support;
            corrections <= o_corrections;
            last        <= o_last;
            usual       <= o_usual;
            deadline    <= o_deadline;
            has_partner <= o_has_partner;
            partner     <= o_partner;
            together    <= o_together;
            log2_x      <= o_log2_x;
            log2_y      <= o_log2_y;
            looked      <= o_looked;
            used_x      <= o_used_x;
            used_y      <= o_used_y;
            box         <= o_box;
            window      <= o_window;
        end

        case (state)
            // ---- events ----------------------------------------------------------------------------------------------
            READY: begin
                if (decides) begin
                    in_valid <= 1'b0;
                    now      <= in_time;
                    op_time  <= in_time;
                    op_seq   <= seq;
                    if (in_event || in_skip) seq <= seq + {{(SEQ_W - 1) {1'b0}}, 1'b1};
                    x         <= in_x;
                    y         <= in_y;
                    p         <= in_p;
                    is_shared <= shared;
                    is_first  <= begins;
                    if (in_event) begin
                        at            <= owner;
                        decided       <= !owned;
                        decided_owned <= 1'b0;
                        if (owned) state <= LOAD;
                    end
                end
                if (steps) begin
                    op_time   <= next_step;
                    op_seq    <= seq;
                    next_step <= next_step + ({{(TIME_W - 1) {1'b0}}, 1'b1} << step_log2);
                    slot      <= {(SLOT_W + 1) {1'b0}};
                    if (|lives) state <= NEXT;
                end
                if (restarts) begin
                    at      <= restart_slot;
                    op_time <= now;
                    op_seq  <= seq;
                    state   <= RESTART;
                end
            end
            LOAD: begin
                state <= TAKE;
                if (is_first) begin
                    candidate[at] <= 1'b1;
                    seeded_at[at] <= op_time;
                    lo_x          <= {{(SIDE_W - 12 - X_W) {1'b0}}, x, 12'd0} - {{(SIDE_W - 20) {1'b0}}, seed_px, 12'd0};
                    hi_x          <= {{(SIDE_W - 12 - X_W) {1'b0}}, x, 12'd0} + {{(SIDE_W - 20) {1'b0}}, seed_px, 12'd0};
                    lo_y          <= {{(SIDE_W - 12 - Y_W) {1'b0}}, y, 12'd0} - {{(SIDE_W - 20) {1'b0}}, seed_px, 12'd0};
                    hi_y          <= {{(SIDE_W - 12 - Y_W) {1'b0}}, y, 12'd0} + {{(SIDE_W - 20) {1'b0}}, seed_px, 12'd0};
                    v_x           <= 16'sd0;
                    v_y           <= 16'sd0;
                    off_lo_x      <= {OFF_W{1'b0}};
                    off_hi_x      <= {OFF_W{1'b0}};
                    off_lo_y      <= {OFF_W{1'b0}};
                    off_hi_y      <= {OFF_W{1'b0}};
                    beyond        <= 4'd0;
                    hidden        <= 4'd0;
                    meets         <= 1'b0;
                    count         <= 10'd0;
                    n_ev          <= nev_low;
                    support       <= {SUP_W{1'b0}};
                    corrections   <= 6'd0;
                    last          <= op_time;
                    usual         <= detect_ticks;
                    deadline      <= op_time + {{(TIME_W - 24) {1'b0}}, detect_ticks};
                    has_partner   <= 1'b0;
                    together      <= 16'd0;
                    state         <= SEED;
                end
            end
            SEED: begin
                was_x        <= length_x;
                was_y        <= length_y;
                window_start <= 1'b1;
                after        <= SEEDED;
                after_clear  <= WINDOW;
                state        <= CLEAR;
            end
            CLEAR: begin
                looked <= 8'd0;
                used_x <= 16'd0;
                used_y <= 16'd0;
                log2_x <= bin_log2(was_x);
                log2_y <= bin_log2(was_y);
                state  <= after_clear;
            end
            SEEDED: begin
                place <= 1'b1;
                state <= TAKE;
            end
            TAKE: begin
                rel_x    <= wide_rel_x[REL_W-1:0];
                rel_y    <= wide_rel_y[REL_W-1:0];
                out      <= is_visible ? {2'b00, one_out} : {1'b0, one_out, 1'b0};
                back     <= is_visible ? {2'b00, one_back} : {1'b0, one_back, 1'b0};
                full     <= {1'b0, count} + 11'd1 >= {1'b0, n_ev};
                bin_x    <= bins_x[3:0];
                bin_y    <= bins_y[3:0];
                in_bin_x <= !from_x[PX_W] && bins_x[PX_W:4] == {(PX_W - 3) {1'b0}};
                in_bin_y <= !from_y[PX_W] && bins_y[PX_W:4] == {(PX_W - 3) {1'b0}};
                state    <= MOVE;
            end
            MOVE: begin
                decided       <= 1'b1;
                decided_owned <= 1'b1;
                support       <= more_support[SUP_W] ? {SUP_W{1'b1}} : more_support[SUP_W-1:0];
                store         <= 1'b1;
                state         <= READY;
                if (!is_shared) begin
                    if (gap_corrections != 8'd0) begin
                        if (in_bin_x) used_x[bin_x] <= 1'b1;
                        if (in_bin_y) used_y[bin_y] <= 1'b1;
                    end
                    lo_x     <= moved_lo_x;
                    hi_x     <= moved_hi_x;
                    lo_y     <= moved_lo_y;
                    hi_y     <= moved_hi_y;
                    off_lo_x <= moved_off_lo_x;
                    off_hi_x <= moved_off_hi_x;
                    off_lo_y <= moved_off_lo_y;
                    off_hi_y <= moved_off_hi_y;
                    beyond   <= beyond | {beyond_y, beyond_x};
                    count    <= count + 10'd1;
                    if (full) begin
                        store <= 1'b0;
                        state <= SHRINK;
                    end
                end
            end
            WINDOW:
            if (window_done) begin
                box    <= box_next;
                window <= window_next;
                state  <= after;
            end
            RECORD:
            if (!m_cm_valid || m_cm_ready) begin
                m_cm_valid      <= 1'b1;
                m_cm_kind       <= kind;
                m_cm_slot       <= at;
                m_cm_id         <= its_id;
                m_cm_other      <= kind == `EVCOT_KIND_MERGED ? stays_id : {ID_W{1'b0}};
                m_cm_x          <= sum_x[SIDE_W:1];
                m_cm_y          <= sum_y[SIDE_W:1];
                m_cm_width      <= side_x;
                m_cm_height     <= side_y;
                m_cm_v_x        <= v_x;
                m_cm_v_y        <= v_y;
                m_cm_n_ev       <= n_ev;
                m_cm_support    <= support;
                m_cm_seq        <= op_seq;
                m_cm_time       <= op_time;
                reported_at[at] <= op_time;
                state           <= after_record;
            end
            RESTART: begin
                restart[at]  <= 1'b0;
                kind         <= `EVCOT_KIND_LOST;
                after_record <= FREE;
                state        <= is_visible ? RECORD : FREE;
            end
            FREE: begin
                visible[at]   <= 1'b0;
                candidate[at] <= 1'b0;
                state         <= READY;
            end

            // ---- a correction ------------------------------------------------------------------------------------------
            SHRINK: begin
                part_x <= meets || side_shrink == 4'd0 ? {SIDE_W{1'b0}} : side_x;
                part_y <= meets || side_shrink == 4'd0 ? {SIDE_W{1'b0}} : side_y;
                state  <= SHRINK_1;
            end
            SHRINK_1: begin
                part_x <= part_x >> side_shrink;
                part_y <= part_y >> side_shrink;
                state  <= INWARDS;
            end
            INWARDS: begin
                if (!beyond[0]) begin
                    lo_x     <= lo_x + part_x;
                    off_lo_x <= off_lo_x + {5'd0, part_x};
                end
                if (!beyond[1]) begin
                    hi_x     <= hi_x - part_x;
                    off_hi_x <= off_hi_x - {5'd0, part_x};
                end
                if (!beyond[2]) begin
                    lo_y     <= lo_y + part_y;
                    off_lo_y <= off_lo_y + {5'd0, part_y};
                end
                if (!beyond[3]) begin
                    hi_y     <= hi_y - part_y;
                    off_hi_y <= off_hi_y - {5'd0, part_y};
                end
                beyond <= 4'd0;
                state  <= gap_corrections == 8'd0 ? TICKS : LOOK;
            end
            LOOK: begin
                was_x    <= length_x;
                was_y    <= length_y;
                across_x <= {speed_y, 1'b0} >= {1'b0, speed_x};
                across_y <= {speed_x, 1'b0} >= {1'b0, speed_y};
                on_y     <= 1'b0;
                looked   <= looked + 8'd1;
                state    <= {1'b0, looked} + 9'd1 < {1'b0, gap_corrections} ? TICKS : LOOK_AT;
            end
            LOOK_AT: begin
                long_x <= {4'd0, was_x} * {{PX_W{1'b0}}, elongation};
                long_y <= {4'd0, was_y} * {{PX_W{1'b0}}, elongation};
                state  <= corrections >= 6'd8 && (v_x != 16'sd0 || v_y != 16'sd0) ? LOOK_GO : LOOKED;
            end
            LOOK_GO:
            if (on_y ? looks_y : looks_x) begin
                narrowest <= (on_y ? across_y : across_x) || least_gap > half_other ? least_gap : half_other;
                look      <= 1'b1;
                state     <= LOOKING;
            end else begin
                on_y  <= 1'b1;
                state <= on_y ? LOOKED : LOOK_GO;
            end
            LOOKING:
            if (look_done) begin
                state <= CUT_AT;
                if (!gap_found) begin
                    on_y  <= 1'b1;
                    state <= on_y ? LOOKED : LOOK_GO;
                end
            end
            CUT_AT: begin
                cut_px <= {{(PX_W - 4) {1'b0}}, low_stays ? gap_begins : gap_ends} << (on_y ? log2_y : log2_x);
                state  <= CUT_EDGE;
            end
            CUT_EDGE: begin
                edge_at <= (on_y ? lo_y : lo_x) + {cut_px, 12'd0};
                state   <= CUT;
            end
            CUT: begin
                if (low_stays) begin
                    if (on_y) hi_y <= edge_at;
                    else hi_x <= edge_at;
                end else if (on_y) begin
                    lo_y <= edge_at;
                    if (hi_y < edge_at) hi_y <= edge_at;
                end else begin
                    lo_x <= edge_at;
                    if (hi_x < edge_at) hi_x <= edge_at;
                end
                on_y  <= 1'b1;
                state <= on_y ? LOOKED : LOOK_GO;
            end
            LOOKED: begin
                was_x       <= length_x;
                was_y       <= length_y;
                after_clear <= TICKS;
                state       <= CLEAR;
            end
            TICKS: begin
                age   <= op_time - last;
                last  <= op_time;
                gain  <= least_gain + {3'd0, meets};
                state <= GAIN;
            end
            GAIN: begin
                ticks       <= |age[TIME_W-1:24] ? 24'hffffff : age[23:1] == 23'd0 ? 24'd1 : age[23:0];
                speed_start <= corrections >= 6'd2;
                state       <= corrections >= 6'd2 ? SPEED : USUAL;
            end
            SPEED:
            if (speed_done) begin
                v_x   <= v_x_next;
                v_y   <= v_y_next;
                state <= USUAL;
            end
            USUAL: begin
                off_lo_x    <= {OFF_W{1'b0}};
                off_hi_x    <= {OFF_W{1'b0}};
                off_lo_y    <= {OFF_W{1'b0}};
                off_hi_y    <= {OFF_W{1'b0}};
                usual       <= corrections == 6'd0 ? ticks : usual + {slower_by[24], slower_by[24:2]};
                corrections <= corrections == 6'd63 ? 6'd63 : corrections + 6'd1;
                if (corrections == 6'd3) starts[at] <= {sum_x, sum_y};
                count   <= 10'd0;
                outline <= {1'b0, length_x} + {1'b0, length_y};
                state   <= GRANT;
            end
            GRANT: begin
                n_ev  <= outline < {{(PX_W - 9) {1'b0}}, nev_low} ? nev_low
                       : outline > {{(PX_W - 9) {1'b0}}, nev_high} ? nev_high : outline[9:0];
                grant <= {8'd0, usual} << life_log2;
                state <= LIFE;
            end
            LIFE: begin
                if (grant < {8'd0, life_ticks}) grant <= {8'd0, life_ticks};
                else if (grant > {8'd0, coast_ticks}) grant <= {8'd0, coast_ticks};
                state <= CORRECT;
            end
            CORRECT: begin
                deadline     <= op_time + {{(TIME_W - 24) {1'b0}}, grant[23:0]};
                window_start <= 1'b1;
                after        <= CORRECTED;
                state        <= WINDOW;
            end
            CORRECTED: begin
                store        <= 1'b1;
                place        <= 1'b1;
                kind         <= `EVCOT_KIND_MOVED;
                after_record <= READY;
                state        <= is_visible ? RECORD : READY;
            end

            // ---- a motion step of a slot -------------------------------------------------------------------------------
            NEXT: begin
                at <= this_slot;
                if (slot == SLOTS[SLOT_W:0]) state <= READY;
                else if (lives[this_slot]) state <= FETCH;
                else slot <= slot + {{SLOT_W{1'b0}}, 1'b1};
            end
            FETCH: begin
                state <= AGE;
            end
            AGE: begin
                ended <= !over_deadline[TIME_W-1];
                age   <= op_time - last;
                state <= GO;
            end
            GO: begin
                if (moves) begin
                    if (within_x) begin
                        lo_x <= gone_lo_x;
                        hi_x <= gone_hi_x;
                    end
                    if (within_y) begin
                        lo_y <= gone_lo_y;
                        hi_y <= gone_hi_y;
                    end
                    if (friction != 4'd0 && !meets && age > {{(TIME_W - 26) {1'b0}}, usual, 2'b00}) begin
                        v_x <= v_x - (v_x >>> friction);
                        v_y <= v_y - (v_y >>> friction);
                    end
                end
                state <= LONG;
                if (ended) begin
                    lo_x         <= lo_x;
                    hi_x         <= hi_x;
                    lo_y         <= lo_y;
                    hi_y         <= hi_y;
                    v_x          <= v_x;
                    v_y          <= v_y;
                    kind         <= `EVCOT_KIND_LOST;
                    after_record <= LAPSE;
                    state        <= is_visible ? RECORD : LAPSE;
                end
            end
            LONG: begin
                too_long_x <= apart_x > longest;
                too_long_y <= apart_y > longest;
                way_x      <= {sum_x[SIDE_W], sum_x};
                way_y      <= {sum_y[SIDE_W], sum_y};
                state      <= SHORTEN;
            end
            SHORTEN: begin
                if (too_long_x) begin
                    lo_x <= way_x[SIDE_W:1] - half_longest;
                    hi_x <= way_x[SIDE_W:1] + half_longest;
                end
                if (too_long_y) begin
                    lo_y <= way_y[SIDE_W:1] - half_longest;
                    hi_y <= way_y[SIDE_W:1] + half_longest;
                end
                window_start <= 1'b1;
                after        <= PLACED;
                state        <= WINDOW;
            end
            PLACED: begin
                store <= 1'b1;
                place <= 1'b1;
                other <= {(SLOT_W + 1) {1'b0}};
                scan  <= FOR_PARTNER;
                if (corrections < 6'd4) other <= SLOTS[SLOT_W:0];
                state <= SCAN;
            end
            LAPSE: begin
                visible[this_slot]   <= 1'b0;
                candidate[this_slot] <= 1'b0;
                slot                 <= slot + {{SLOT_W{1'b0}}, 1'b1};
                state                <= NEXT;
            end
            DONE: begin
                store <= 1'b1;
                slot  <= slot + {{SLOT_W{1'b0}}, 1'b1};
                state <= NEXT;
            end

            // ---- comparing it with the others --------------------------------------------------------------------------
            SCAN: begin
                at <= last_other ? this_slot : this_other;
                if (last_other)
                    case (scan)
                        FOR_PARTNER: begin
                            if (together != 16'd0) together <= together - 16'd1;
                            state <= JOINED;
                        end
                        FOR_OWNER: begin
                            other <= {(SLOT_W + 1) {1'b0}};
                            scan  <= FOR_TOUCH;
                        end
                        FOR_TOUCH:  state <= BIRTH;
                        FOR_HIDING: state <= REPORT;
                    endcase
                else if (among[this_other] && other != slot) state <= LOAD_IT;
                else other <= other + {{SLOT_W{1'b0}}, 1'b1};
            end
            LOAD_IT: begin
                state <= SCAN_1;
                if (scan == FOR_PARTNER && o_corrections < 6'd4) begin
                    other <= other + {{SLOT_W{1'b0}}, 1'b1};
                    state <= SCAN;
                end
            end
            SCAN_1: state <= scan == FOR_PARTNER ? SCAN_2 : FOUND;
            SCAN_2: state <= SCAN_3;
            SCAN_3: state <= SCAN_4;
            SCAN_4: state <= SCAN_5;
            SCAN_5: state <= FOUND;
            FOUND: begin
                other <= other + {{SLOT_W{1'b0}}, 1'b1};
                state <= SCAN;
                case (scan)
                    FOR_PARTNER:
                    if (alike) begin
                        other <= other;
                        state <= PARTNER;
                    end
                    FOR_OWNER: if (middle_in) state <= LAPSE;
                    FOR_TOUCH:
                    if (boxes_touch) begin
                        stays <= weaker ? this_other : this_slot;
                        goes  <= weaker ? this_slot : this_other;
                        other <= other;
                        state <= MERGE;
                    end
                    FOR_HIDING:
                    if (meet) begin
                        meets  <= 1'b1;
                        hidden <= hidden | hides;
                    end
                endcase
            end

            PARTNER: begin
                has_partner <= 1'b1;
                partner     <= this_other;
                together    <= has_partner && partner == this_other ? together + 16'd1 : 16'd1;
                other_age   <= op_time - its_seeded;
                at          <= this_slot;
                state       <= YOUNGER;
            end
            YOUNGER: begin
                age   <= op_time - its_seeded;
                state <= OLDER;
            end
            OLDER: begin
                other_older <= other_age > age;
                shift       <= {1'b0, step_log2} + {2'b00, join_life};
                state       <= LIVED;
            end
            LIVED: begin
                lived <= other_older ? age : other_age;
                state <= STEPS;
            end
            STEPS:
            if (shift >= 6'd8) begin
                lived <= {8'd0, lived[TIME_W-1:8]};
                shift <= shift - 6'd8;
            end else if (shift != 6'd0) begin
                lived <= {1'b0, lived[TIME_W-1:1]};
                shift <= shift - 6'd1;
            end else state <= ENOUGH;
            ENOUGH: begin
                enough <= lived_steps > {6'd0, join_steps} ? lived_steps : {6'd0, join_steps};
                state  <= JOIN;
            end
            JOIN: begin
                if (visible[this_slot] != visible[this_other]) begin
                    stays <= visible[this_slot] ? this_slot : this_other;
                    goes  <= visible[this_slot] ? this_other : this_slot;
                end else if (keep_older ? other_older : weaker) begin
                    stays <= this_other;
                    goes  <= this_slot;
                end else begin
                    stays <= this_slot;
                    goes  <= this_other;
                end
                state <= together < enough ? JOINED : MERGE;
            end
            JOINED: begin
                other <= {(SLOT_W + 1) {1'b0}};
                scan  <= FOR_OWNER;
                if (visible[this_slot]) begin
                    scan   <= FOR_HIDING;
                    meets  <= 1'b0;
                    hidden <= 4'd0;
                end
                state <= SCAN;
            end

            // ---- two become one ----------------------------------------------------------------------------------------
            MERGE: begin
                at    <= this_slot;
                state <= MERGE_1;
            end
            MERGE_1: begin
                store <= 1'b1;
                state <= MERGE_2;
            end
            MERGE_2: begin
                at    <= stays;
                state <= MERGE_3;
            end
            MERGE_3: begin
                stays_id <= its_id;
                at       <= goes;
                state    <= MERGE_4;
            end
            MERGE_4: begin
                kind         <= `EVCOT_KIND_MERGED;
                after_record <= MERGE_5;
                state        <= is_visible ? RECORD : MERGE_5;
            end
            MERGE_5: begin
                at    <= stays;
                state <= MERGE_6;
            end
            MERGE_6: begin
                at    <= goes;
                state <= UNITE;
            end
            UNITE: begin
                if (o_lo_x < lo_x) lo_x <= o_lo_x;
                if (o_hi_x > hi_x) hi_x <= o_hi_x;
                if (o_lo_y < lo_y) lo_y <= o_lo_y;
                if (o_hi_y > hi_y) hi_y <= o_hi_y;
                off_lo_x        <= {OFF_W{1'b0}};
                off_hi_x        <= {OFF_W{1'b0}};
                off_lo_y        <= {OFF_W{1'b0}};
                off_hi_y        <= {OFF_W{1'b0}};
                beyond          <= 4'hf;
                support         <= both_support[SUP_W] ? {SUP_W{1'b1}} : both_support[SUP_W-1:0];
                if (!later[TIME_W-1]) deadline <= o_deadline;
                has_partner     <= 1'b0;
                together        <= 16'd0;
                visible[goes]   <= 1'b0;
                candidate[goes] <= 1'b0;
                at              <= stays;
                state           <= UNITED;
            end
            UNITED: begin
                was_x        <= length_x;
                was_y        <= length_y;
                window_start <= 1'b1;
                after        <= MERGED;
                after_clear  <= WINDOW;
                state        <= CLEAR;
            end
            MERGED: begin
                store        <= 1'b1;
                place        <= 1'b1;
                kind         <= `EVCOT_KIND_MOVED;
                after_record <= GO_ON;
                state        <= is_visible ? RECORD : GO_ON;
            end
            GO_ON:
            if (stays != this_slot) begin
                slot  <= slot + {{SLOT_W{1'b0}}, 1'b1};
                state <= NEXT;
            end else if (scan == FOR_TOUCH) begin
                other <= other + {{SLOT_W{1'b0}}, 1'b1};
                state <= SCAN;
            end else state <= JOINED;

            // ---- a candidate becomes visible ---------------------------------------------------------------------------
            BIRTH: begin
                age       <= op_time - its_seeded;
                way_x     <= {sum_x[SIDE_W], sum_x} - {start_x[SIDE_W], start_x};
                way_y     <= {sum_y[SIDE_W], sum_y} - {start_y[SIDE_W], start_y};
                sides     <= {1'b0, side_x} + {1'b0, side_y};
                too_small <= apart_x < least_side || apart_y < least_side || corrections < 6'd4 || wide_support < wide_birth;
                state     <= BIRTH_1;
            end
            BIRTH_1: begin
                far   <= ({1'b0, sides} >> ({1'b0, birth_travel} + 5'd1)) + {{(SIDE_W - 12) {1'b0}}, 14'h2000};
                state <= BIRTH_2;
            end
            BIRTH_2: begin
                goes_far <= abs_way_x >= far || abs_way_y >= far;
                state    <= BIRTH_3;
            end
            BIRTH_3: state <= too_small || !goes_far || age < {{(TIME_W - 24) {1'b0}}, birth_ticks} ? DONE : BORN;
            BORN: begin
                visible[at]   <= 1'b1;
                candidate[at] <= 1'b0;
                ids[at]       <= births;
                births        <= births + {{(ID_W - 1) {1'b0}}, 1'b1};
                kind          <= `EVCOT_KIND_BORN;
                after_record  <= DONE;
                state         <= RECORD;
            end
            REPORT: begin
                age          <= op_time - its_reported;
                report_ticks <= {20'd0, report_steps} << step_log2;
                state        <= REPORT_1;
            end
            REPORT_1: begin
                kind         <= `EVCOT_KIND_MOVED;
                after_record <= DONE;
                state        <= age >= {{(TIME_W - 30) {1'b0}}, report_ticks} ? RECORD : DONE;
            end
            default: state <= READY;
        endcase

        // ---- registers -----------------------------------------------------------------------------------------------
        if (writes_mode) begin
            seeded[cfg_slot]  <= cfg_data[1:0] == `EVCOT_MODE_SEEDED;
            restart[cfg_slot] <= 1'b1;
        end
        restep <= cfg_valid && cfg_addr == `EVCOT_MREG_STEP_LOG2;
        if (restep) next_step <= (now | ~({TIME_W{1'b1}} << step_log2)) + {{(TIME_W - 1) {1'b0}}, 1'b1};

        idle <= state == READY && !in_valid && !s_valid && !store && !decided && output_empty && !m_cm_valid && !restarts
                && !restep && !cfg_valid;

        if (rst) begin
            state        <= READY;
            visible      <= {N{1'b0}};
            candidate    <= {N{1'b0}};
            seeded       <= {N{1'b0}};
            restart      <= {N{1'b0}};
            restep       <= 1'b1;
            store        <= 1'b0;
            place        <= 1'b0;
            window_start <= 1'b0;
            speed_start  <= 1'b0;
            look         <= 1'b0;
            decided      <= 1'b0;
            in_valid     <= 1'b0;
            known        <= 1'b0;
            in_time      <= {TIME_W{1'b0}};
            now          <= {TIME_W{1'b0}};
            seq          <= {SEQ_W{1'b0}};
            births       <= {ID_W{1'b0}};
            m_cm_valid   <= 1'b0;
            idle         <= 1'b0;
        end
    end

    wire unused = &{1'b0, wide_rel_x, wide_rel_y, slow_gain[6:4], slower_by[1:0], place_x[0], place_y[0], until_step, over_deadline, later};

endmodule

`default_nettype wire
