// SPDX-License-Identifier: Apache-2.0
// N cluster trackers with boxes and velocities, which meet without merging: the array with the rules of docs/motion.md.
//
// Tokens and streams are those of cot_array.v, but for the record. Events are decided in a pipeline (motion_events.v); what else is done
// to a slot, a program does (motion_engine.v), while no event is decided: it seeds and corrects slots, and moves them in steps.
//
// Registers: `mode` of each slot, off or seeded, and those of motion_regs.v. A write of `mode` restarts the slot before the next
// token; after one of `step_log2` steps are at multiples of the new length. Others are to be written while the array is idle.
//
// Latency:    unstalled, from the clock edge that takes the event: an owned or a passed event after 13 clocks; a record after
//             some 340, depending on values.
// Throughput: a token per clock; events of one owner every fourth. Some 160 more for the first event of a candidate, 250 to 350 for a
//             correction, 480 if it looks for gaps; for a motion step 30, and some 250 for each slot that lives, more where they meet.
// Stall:      every output is held until accepted.
// Reset:      turns all slots off, and gives the registers their defaults.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"
`include "motion_codes.vh"

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

    localparam PX_W  = SIDE_W - 12;  // bits of a bound in pixels
    localparam OFF_W = SIDE_W + 5;   // bits of an offset: of up to 1023 events
    localparam REL_W = RADIX_W + 2;
    localparam W     = (TIME_W > SIDE_W + 14) ? TIME_W : SIDE_W + 14;  // bits of the engine's words

    // ---- registers -------------------------------------------------------------------------------------------------

    wire [4:0]   step_log2;
    wire [3:0]   gap_share;
    wire         counts;
    wire [15:0]  back, out;
    wire         writes_mode = cfg_valid && cfg_addr == `EVCOT_MREG_MODE;
    reg  [N-1:0] seeded;            // `mode`
    reg  [N-1:0] restart;           // it was written
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

    // ---- tokens ------------------------------------------------------------------------------------------------------

    wire              q_valid, q_ready, queue_empty, is_event, is_skip, p;
    wire [3:0]        q_index, index;
    wire [X_W-1:0]    q_x, x;
    wire [Y_W-1:0]    q_y, y;
    wire [TIME_W-1:0] event_time;
    wire              done, steps, seeds, corrects, active, done_event, done_skip, done_owned, done_p;
    wire [SLOT_W-1:0] done_slot;
    wire [TIME_W-1:0] done_time;
    wire [X_W-1:0]    done_x;
    wire [Y_W-1:0]    done_y;
    wire [REL_W-1:0]  done_rel_x, done_rel_y;

    motion_queue #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .TICK_W(TICK_W),
        .TIME_W(TIME_W)
    ) u_queue (
        .clk       (clk),
        .rst       (rst),
        .s_valid   (s_valid),
        .s_ready   (s_ready),
        .s_tick    (s_tick),
        .s_event   (s_event),
        .s_skip    (s_skip),
        .s_x       (s_x),
        .s_y       (s_y),
        .s_p       (s_p),
        .m_valid   (q_valid),
        .m_ready   (q_ready),
        .m_index   (q_index),
        .m_x       (q_x),
        .m_y       (q_y),
        .index     (index),
        .event_time(event_time),
        .is_event  (is_event),
        .is_skip   (is_skip),
        .x         (x),
        .y         (y),
        .p         (p),
        .done      (done),
        .again     (|starts),
        .empty     (queue_empty)
    );

    // ---- time, and what the engine is to do -----------------------------------------------------------------------------

    reg  [SEQ_W-1:0]  seq, op_seq;       // number of the next event; of that of the record
    reg  [TIME_W-1:0] now, next_step, op_time;
    reg  [20:0]       step_ticks, step_mask;
    reg  [1:0]        restep;            // step_log2 was written, or reset: the next step is set
    reg  [X_W-1:0]    op_x;
    reg  [Y_W-1:0]    op_y;
    reg               go;
    reg  [2:0]        starts;            // what a token led to, a clock ago: step, seed, correction
    reg  [9:0]        entry;
    reg  [SLOT_W-1:0] go_slot;
    reg               skips, compared, skip_due;  // steps while no slot lives
    reg               pending;           // a register was written
    reg  [ID_W-1:0]   births;
    wire              busy, room, output_empty;
    wire [N-1:0]      visible, candidate;
    wire [N-1:0]      lives = visible | candidate;
    wire [TIME_W-1:0] until_step = op_time - next_step;
    wire [TIME_W-1:0] step_after = (restep[1] ? now | {{(TIME_W - 21) {1'b0}}, step_mask} : next_step)
                                 + {{(TIME_W - 21) {1'b0}}, restep[1] ? 21'd1 : step_ticks};
    wire              waits = busy || go || |starts || skips || pending;
    wire              engine_out, write_x, write_y;
    wire [4:0]        target;
    reg               decided;           // and of the token then
    reg  [SLOT_W-1:0] decided_slot;
    reg  [X_W-1:0]    decided_x;
    reg  [Y_W-1:0]    decided_y;
    reg  [SEQ_W-1:0]  decided_seq;
    reg  [TIME_W-1:0] decided_time;

    always @(posedge clk) begin
        go         <= 1'b0;
        step_ticks <= 21'd1 << step_log2;
        step_mask  <= ~(21'h1fffff << step_log2);
        restep     <= {restep[0], cfg_valid && cfg_addr == `EVCOT_MREG_STEP_LOG2};
        pending    <= restarts || cfg_valid || |restep;
        if (done) begin
            now <= done_time;
            if (done_event || done_skip) seq <= seq + {{(SEQ_W - 1) {1'b0}}, 1'b1};
        end
        starts <= {steps, seeds, corrects};
        if (|starts) begin
            go      <= !starts[2] || |lives;
            skips   <= starts[2] && !(|lives);
            entry   <= starts[2] ? `EVCOT_MOTION_AT_STEP : starts[1] ? `EVCOT_MOTION_AT_SEED : `EVCOT_MOTION_AT_CORRECT;
            go_slot <= decided_slot;
            op_time <= starts[2] && |lives ? next_step : decided_time;
            op_seq  <= decided_seq;
            op_x    <= decided_x;
            op_y    <= decided_y;
        end else if (restarts && pending && !active && !busy && !go && !skips) begin
            go                    <= 1'b1;
            entry                 <= `EVCOT_MOTION_AT_RESTART;
            go_slot               <= restart_slot;
            op_time               <= now;
            op_seq                <= seq;
            restart[restart_slot] <= 1'b0;
        end
        compared <= skips && !compared;
        skip_due <= !until_step[TIME_W-1];
        if (skips && compared && !skip_due) skips <= 1'b0;
        if ((starts[2] && |lives) || (skips && compared && skip_due) || restep[1]) next_step <= step_after;
        if (engine_out && target == `EVCOT_MOTION_OUT_BORN) births <= births + {{(ID_W - 1) {1'b0}}, 1'b1};
        if (writes_mode) begin
            seeded[cfg_slot]  <= cfg_data[1:0] == `EVCOT_MODE_SEEDED;
            restart[cfg_slot] <= 1'b1;
        end
        decided <= done && done_event;
        idle    <= queue_empty && !s_valid && !active && !waits && !restarts && !cfg_valid && !(|restep) && !decided && output_empty && !m_cm_valid;
        if (rst) begin
            go      <= 1'b0;
            starts  <= 3'd0;
            skips   <= 1'b0;
            restep  <= 2'b01;
            seeded  <= {N{1'b0}};
            restart <= {N{1'b0}};
            now     <= {TIME_W{1'b0}};
            seq     <= {SEQ_W{1'b0}};
            births  <= {ID_W{1'b0}};
            decided <= 1'b0;
            idle    <= 1'b0;
            pending <= 1'b1;
        end
    end

    // ---- events ------------------------------------------------------------------------------------------------------

    wire [SLOT_W-1:0] at, out_slot, other, hot_slot, bin_slot;
    wire [2:0]        hot_index;
    wire              hot_wanted;
    wire [W-1:0]      hot_x, hot_y, acc_x, acc_y, value_x, value_y;
    wire [N-1:0]      box_x, box_y, window_x, window_y;
    wire              bin_count, in_bin_x, in_bin_y, first_x, first_y;
    wire [3:0]        bin_x, bin_y;
    wire [15:0]       used_x, used_y;
    wire [3:0]        place;
    wire [1:0]        ask;

    motion_events #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .SIDE_W(SIDE_W),
        .OFF_W (OFF_W),
        .PX_W  (PX_W),
        .REL_W (REL_W),
        .SUP_W (SUP_W),
        .TIME_W(TIME_W),
        .W     (W)
    ) u_events (
        .clk       (clk),
        .rst       (rst),
        .may_issue (room && !waits),
        .s_valid   (q_valid),
        .s_ready   (q_ready),
        .s_index   (q_index),
        .s_x       (q_x),
        .s_y       (q_y),
        .index     (index),
        .event_time(event_time),
        .is_event  (is_event),
        .is_skip   (is_skip),
        .x         (x),
        .y         (y),
        .p         (p),
        .out       (out),
        .back      (back),
        .counts    (counts),
        .next_step (next_step),
        .visible   (visible),
        .candidate (candidate),
        .may_begin (seeded & ~lives),
        .done      (done),
        .steps     (steps),
        .seeds     (seeds),
        .corrects  (corrects),
        .active    (active),
        .done_event(done_event),
        .done_skip (done_skip),
        .done_owned(done_owned),
        .done_slot (done_slot),
        .done_time (done_time),
        .done_x    (done_x),
        .done_y    (done_y),
        .done_p    (done_p),
        .done_rel_x(done_rel_x),
        .done_rel_y(done_rel_y),
        .bin_count (bin_count),
        .bin_slot  (bin_slot),
        .in_bin_x  (in_bin_x),
        .in_bin_y  (in_bin_y),
        .bin_x     (bin_x),
        .bin_y     (bin_y),
        .first_x   (first_x),
        .first_y   (first_y),
        .used_x    (used_x),
        .used_y    (used_y),
        .busy      (busy),
        .hot_slot  (hot_slot),
        .hot_index (hot_index),
        .hot_wanted(hot_wanted),
        .hot_x     (hot_x),
        .hot_y     (hot_y),
        .write_x   (write_x),
        .write_y   (write_y),
        .write_slot(out_slot),
        .target    (target[3:0]),
        .acc_x     (acc_x),
        .acc_y     (acc_y),
        .place     (place),
        .ask_lo    (ask[0]),
        .ask_hi    (ask[1]),
        .box_x     (box_x),
        .box_y     (box_y),
        .window_x  (window_x),
        .window_y  (window_y)
    );

    // ---- the engine --------------------------------------------------------------------------------------------------

    wire [5:0] value_index;
    wire       value_wanted, record_free, looking, gap_found, low_stays, dividing;
    wire [3:0] gap_bin;
    wire [4:0] leading;
    wire [6:0] inverse;

    motion_values #(
        .SLOT_W(SLOT_W),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .REACH (REACH),
        .SUP_W (SUP_W),
        .ID_W  (ID_W),
        .TIME_W(TIME_W),
        .W     (W)
    ) u_values (
        .clk      (clk),
        .rst      (rst),
        .cfg_valid(cfg_valid),
        .cfg_addr (cfg_addr),
        .cfg_data (cfg_data),
        .step_log2(step_log2),
        .gap_share(gap_share),
        .counts   (counts),
        .back     (back),
        .out      (out),
        .now      (op_time),
        .x        (op_x),
        .y        (op_y),
        .other    (other),
        .births   (births),
        .gap_bin  (gap_bin),
        .leading  (leading),
        .inverse  (inverse),
        .wanted   (value_wanted),
        .index    (value_index),
        .value_x  (value_x),
        .value_y  (value_y)
    );

    motion_engine #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .W     (W),
        .Y_LANE_W(SIDE_W + 14),
        .TIME_W(TIME_W)
    ) u_engine (
        .clk        (clk),
        .rst        (rst),
        .go         (go),
        .entry      (entry),
        .go_slot    (go_slot),
        .busy       (busy),
        .visible    (visible),
        .candidate  (candidate),
        .at         (at),
        .other      (other),
        .value_index(value_index),
        .value_wanted(value_wanted),
        .value_x    (value_x),
        .value_y    (value_y),
        .hot_slot   (hot_slot),
        .hot_index  (hot_index),
        .hot_wanted (hot_wanted),
        .hot_x      (hot_x),
        .hot_y      (hot_y),
        .box_x      (box_x),
        .box_y      (box_y),
        .window_x   (window_x),
        .window_y   (window_y),
        .record_free(record_free),
        .looking    (looking),
        .gap_found  (gap_found),
        .low_stays  (low_stays),
        .dividing   (dividing),
        .out        (engine_out),
        .hot_write_x(write_x),
        .hot_write_y(write_y),
        .place      (place),
        .ask        (ask),
        .target     (target),
        .out_slot   (out_slot),
        .out_x      (acc_x),
        .out_y      (acc_y)
    );

    motion_units #(
        .SLOT_W(SLOT_W),
        .PX_W  (PX_W),
        .W     (W)
    ) u_units (
        .clk      (clk),
        .rst      (rst),
        .write    (engine_out),
        .target   (target),
        .acc_x    (acc_x),
        .acc_y    (acc_y),
        .at       (at),
        .gap_share(gap_share),
        .busy     (busy),
        .count    (bin_count),
        .slot     (bin_slot),
        .in_bin_x (in_bin_x),
        .in_bin_y (in_bin_y),
        .bin_x    (bin_x),
        .bin_y    (bin_y),
        .first_x  (first_x),
        .first_y  (first_y),
        .used_x   (used_x),
        .used_y   (used_y),
        .looking  (looking),
        .gap_found(gap_found),
        .low_stays(low_stays),
        .gap_bin  (gap_bin),
        .dividing (dividing),
        .leading  (leading),
        .inverse  (inverse)
    );

    // ---- outputs -----------------------------------------------------------------------------------------------------

    motion_record #(
        .SLOT_W(SLOT_W),
        .SIDE_W(SIDE_W),
        .SUP_W (SUP_W),
        .ID_W  (ID_W),
        .SEQ_W (SEQ_W),
        .TIME_W(TIME_W),
        .W     (W)
    ) u_record (
        .clk         (clk),
        .rst         (rst),
        .write       (engine_out),
        .target      (target),
        .acc_x       (acc_x),
        .acc_y       (acc_y),
        .slot        (out_slot),
        .seq         (op_seq),
        .now         (op_time),
        .free        (record_free),
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

    reg             decided_owned, decided_p;
    reg [REL_W-1:0] decided_rel_x, decided_rel_y;

    always @(posedge clk) begin
        decided_owned <= done_owned;
        decided_slot  <= done_slot;
        decided_rel_x <= done_rel_x;
        decided_rel_y <= done_rel_y;
        decided_x     <= done_x;
        decided_y     <= done_y;
        decided_p     <= done_p;
        decided_seq   <= seq;
        decided_time  <= done_time;
    end

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
        .s_slot      (decided_slot),
        .s_rel_x     (decided_rel_x),
        .s_rel_y     (decided_rel_y),
        .s_x         (decided_x),
        .s_y         (decided_y),
        .s_p         (decided_p),
        .s_seq       (decided_seq),
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

endmodule

`default_nettype wire
