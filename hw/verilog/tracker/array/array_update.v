// SPDX-License-Identifier: Apache-2.0
// The context (state) of all slots and the one datapath that changes it: stages C (read), U (take), V (centre) and W (window).
//
// The input of C is a slot's number with an event that the slot owns, or with an operation: REPORT outputs a record of the slot as
// it is, CLEAR returns it to INIT_CELL, JOIN sets it to the result of a merge. The state that U commits is written at its end: average,
// ring, support, timer. State that changes a window is written at the end of W. State that only a special event or an operation needs
// is read in U, if there is one; N_ev of the next window and the record are computed from it in X.
//
// Latency:    5 clocks from C to the record, 2 to the recentred address.
// Throughput: an event per clock. After a special one (the first of a life, or the last of its window of events) or an
//             operation, no valid event may be in C until it has left X and one more clock has passed: 6 clocks later.
//             Events that are flushed may be, directly behind it. An operation is issued when U and V are empty.
// Reset:      no record; ids from 0. The context is not reset: clear every slot.
// Stall:      none; what must not commit is flushed.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

module array_update #(
    parameter N       = 8,   // tracker slots
    parameter FAR     = 0,   // 1: what enters C next stands in registers: see cot_array.v
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter FRAC    = 4,   // fractional bits of a centre and of an average
    parameter RADIX_W = 8,   // bits of a radius register
    parameter NEV_W   = 10,  // bits of N_ev
    parameter TC_W    = 24,  // bits of a timer
    parameter SUP_W   = 16,  // bits of a support count
    parameter ID_W    = 32,  // bits of a track id
    parameter SEQ_W   = 48,  // bits of an event's sequence number
    parameter TIME_W  = 48,  // bits of the tick count
    parameter LIFE_W  = 26,  // bits of a deadline, at least TC_W + 2
    parameter CLOCK_W = 48,  // bits of the time, at least TIME_W and LIFE_W
    parameter SLOT_W  = 3,   // bits of a slot number
    parameter AT_X    = 11,  // bits of a bound of a window: see cot_window.v
    parameter AT_Y    = 11
) (
    input  wire                clk,
    input  wire                rst,

    input  wire                cfg_valid,
    input  wire [SLOT_W-1:0]   cfg_slot,
    input  wire [`EVCOT_REG_W-1:0] cfg_addr,
    input  wire [31:0]         cfg_data,

    // D, what enters C next; C
    input  wire [X_W-1:0]      d_x,
    input  wire [Y_W-1:0]      d_y,
    input  wire [SLOT_W-1:0]   d_slot,
    input  wire [3*SLOT_W-1:0] c_slots,    // three times its slot: fewer readers each
    input  wire [2*SLOT_W-1:0] c_slots_not,  // FAR = 0: twice its complement
    input  wire                c_commits,  // unless something happens to it, the event is committed in U
    input  wire                c_takes,
    input  wire                c_active,   // the event's slot is active
    input  wire                c_seeds,    // the event starts a life
    input  wire [X_W-1:0]      c_x,
    input  wire [Y_W-1:0]      c_y,
    input  wire                c_report,
    input  wire                c_clear,
    input  wire                c_join,
    input  wire                c_looks,    // no operation: the context of its slot is looked at, its timer or
    input  wire                looks_max,  // its max_ticks in place of detect_ticks
    input  wire [X_W+FRAC-1:0] join_x,
    input  wire [Y_W+FRAC-1:0] join_y,
    input  wire [RADIX_W-1:0]  join_g,
    input  wire [SUP_W-1:0]    join_support,

    // U: what C took is committed; the context of its slot
    output reg                 u_special,  // an event that changes a window
    output reg                 u_busy,     // an operation
    output wire [X_W+FRAC-1:0] u_cm_x,
    output wire [Y_W+FRAC-1:0] u_cm_y,
    output reg  [RADIX_W-1:0]  u_g,

    // V: more of it
    output reg                 v_busy,     // a special event or an operation
    output reg  [SLOT_W-1:0]   v_slot,
    output reg  [ID_W-1:0]     v_id,
    output wire [SUP_W-1:0]    v_support,
    output reg                 v_timed,
    output reg  [LIFE_W-1:0]   v_deadline,
    output wire                v_on,       // mode is not off
    output reg  [TC_W-1:0]     v_grant,    // ticks that an event grants
    output wire [RADIX_W+1:0]  v_rel_x,
    output wire [RADIX_W+1:0]  v_rel_y,

    // W: what becomes of the slot's window
    output reg                 w_busy,
    output reg                 w_checks,   // it might overlap now
    output reg                 w_places,
    output wire                w_changes,
    output wire                w_born,     // it becomes active
    output reg  [SLOT_W-1:0]   w_slot,
    output wire [AT_X-1:0]     w_lo_x_not, w_hi_x,
    output wire [AT_Y-1:0]     w_lo_y_not, w_hi_y,
    output wire                w_free,
    output wire                w_window,
    output wire                w_active,

    // the record; what stands beside it: a loss or a merge, the other track, event number, time
    input  wire                lost,
    input  wire [ID_W-1:0]     other,
    input  wire [SEQ_W-1:0]    seq,
    input  wire [CLOCK_W-1:0]  now,        // time of the last committed token
    input  wire [TIME_W-1:0]   ended,      // when the life ended
    output reg                 m_cm_valid,
    input  wire                m_cm_ready,
    output reg  [1:0]          m_cm_kind,
    output reg  [SLOT_W-1:0]   m_cm_slot,
    output reg  [ID_W-1:0]     m_cm_id,
    output reg  [ID_W-1:0]     m_cm_other,
    output reg  [X_W+FRAC-1:0] m_cm_x,
    output reg  [Y_W+FRAC-1:0] m_cm_y,
    output reg  [RADIX_W:0]    m_cm_radius,
    output reg  [NEV_W-1:0]    m_cm_n_ev,
    output reg  [SUP_W-1:0]    m_cm_support,
    output reg  [SEQ_W-1:0]    m_cm_seq,
    output reg  [TIME_W-1:0]   m_cm_time
);

    localparam POS_X = X_W + FRAC;
    localparam POS_Y = Y_W + FRAC;
    localparam XY_W  = X_W > Y_W ? X_W : Y_W;
    localparam OFF_W = (XY_W > RADIX_W ? XY_W : RADIX_W) + 3;  // an offset from the centre, with a radius added

    // One memory for all that is written together. no_rw_check: never written in the clock in which somebody looks at the same
    // slot, so where a memory is synchronous (iCE40), nothing has to pass by it.
    localparam CM_W     = POS_X + POS_Y + RADIX_W;
    localparam AV_DEPTH = (FAR != 0) ? N : 1 << SLOT_W;

    reg [POS_X-1:0]   av_x     [0:AV_DEPTH-1];  // averages; FAR = 0: at the complement of the slot's number
    reg [POS_Y-1:0]   av_y     [0:AV_DEPTH-1];
    reg               timed    [0:N-1];  // has a deadline: active, or a candidate that has begun to collect
    (* no_rw_check *) reg [LIFE_W-1:0]  deadline [0:N-1];  // its low bits
    reg               ring     [0:N-1];  // was occupied in this window
    reg [SUP_W:0]     support  [0:N-1];  // with a bit above that says that it is saturated
    (* no_rw_check *) reg [CM_W-1:0]    cm       [0:N-1];  // centre: x, y; g
    (* no_rw_check *) reg [NEV_W-1:0]   n_ev     [0:N-1];
    reg [NEV_W+1:0]   rest     [0:N-1];  // is the next 0, is it 1: events until the last one of this window
    (* no_rw_check *) reg [ID_W-1:0]    id       [0:N-1];
    (* no_rw_check *) reg [TIME_W-1:0]  start    [0:N-1];  // tick at which the window of N_ev events began
    (* no_rw_check *) reg [TC_W-1:0]    last_tc2 [0:N-1];

    reg [ID_W-1:0] births;  // id of the next track

    // ---- C ---------------------------------------------------------------------------------------------------------

    wire [SLOT_W-1:0]  c_slot, c_slot_rest, c_slot_regs;
    assign {c_slot, c_slot_rest, c_slot_regs} = c_slots;
    wire [SLOT_W-1:0]  not_x, not_y;
    assign {not_x, not_y} = c_slots_not;

    wire [1:0]         mode;
    wire [X_W-1:0]     init_cm_x;
    wire [Y_W-1:0]     init_cm_y;
    wire [RADIX_W-1:0] init_radix, radix_th, radix_step, radix_min, radix_max;
    wire [3:0]         hist_avg;
    wire [TC_W-1:0]    max_ticks, nev_th, detect_ticks;
    wire [NEV_W-1:0]   clust_nev, nev_min, nev_max;

    reg [SLOT_W-1:0]   u_slot;  // the slot in U

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
        .slot        (c_slot_regs),
        .init_cm_x   (init_cm_x),
        .init_cm_y   (init_cm_y),
        .radix_th    (radix_th),
        .radix_step  (radix_step),
        .radix_min   (radix_min),
        .radix_max   (radix_max),
        .hist_avg    (hist_avg),
        .late_slot   (u_slot),
        .mode        (mode),
        .init_radix  (init_radix),
        .max_ticks   (max_ticks),
        .clust_nev   (clust_nev),
        .nev_min     (nev_min),
        .nev_max     (nev_max),
        .nev_th      (nev_th),
        .detect_ticks(detect_ticks)
    );

    localparam [NEV_W-1:0] ONE = 1;
    localparam [NEV_W:0]   TWICE = 2;
    localparam [NEV_W-1:0] TWO = TWICE[NEV_W-1:0];  // 0 where it does not fit: then nothing is

    reg               u_takes, u_last, u_again, u_follows, u_active, u_clear, u_join, u_report, u_first, u_placed;
    reg [NEV_W-1:0]   u_rest;
    reg               u_one;  // u_rest is 1
    wire              u_two = u_rest == TWO;
    reg               u_timed, u_max_grant;
    reg [RADIX_W-1:0] u_th, u_step, u_min, u_max;
    reg [RADIX_W:0]   u_highest, u_lowest;  // from where a step up or down is one too many
    reg [TC_W-1:0]    u_nev_th;

    reg                v_took;
    wire [POS_X-1:0]   w_cm_x, c_av_x, c_cm_x;  // w_cm in V: the new average
    wire [POS_Y-1:0]   w_cm_y, c_av_y, c_cm_y;
    wire [RADIX_W-1:0] c_g;
    wire               c_timed = timed[c_slot];
    wire               c_none, c_one;
    wire [NEV_W-1:0]   c_rest;

    // Is the slot in C that in U, that in V? What is its average? Worked out a clock before where the slot is known then; an
    // average that is just being written is taken on its way.
    reg same_u, same_v;

    generate
        if (FAR != 0) begin : g_far
            reg             written;
            reg [POS_X-1:0] read_x, written_x;
            reg [POS_Y-1:0] read_y, written_y;

            always @(posedge clk) begin
                same_u <= d_slot == c_slot;
                same_v <= d_slot == u_slot;
                read_x <= av_x[d_slot];
                read_y <= av_y[d_slot];
                written   <= v_took && d_slot == v_slot;
                written_x <= w_cm_x;
                written_y <= w_cm_y;
            end
            assign c_av_x = written ? written_x : read_x;
            assign c_av_y = written ? written_y : read_y;
        end else begin : g_near
            always @* begin
                same_u = c_slot_rest == u_slot;
                same_v = c_slot_rest == v_slot;
            end
            assign c_av_x = av_x[not_x];
            assign c_av_y = av_y[not_y];
        end
    endgenerate

    // So is one that is being written now.
    wire passes = v_took && same_v;
    assign {c_cm_x, c_cm_y, c_g} = cm[c_slot];
    assign {c_none, c_one, c_rest} = rest[c_slot_rest];

    // The event in U is of the same slot.
    wire forward = c_takes && u_takes && !u_special && same_u;
    wire place   = c_seeds || c_clear || c_join;
    wire last    = forward ? u_one : c_none;
    wire first   = !c_active && !c_timed;

    always @(posedge clk) begin
        u_slot      <= c_slot_rest;
        u_takes     <= c_takes && c_commits;
        u_follows   <= forward;
        // Committed or not: what is thrown out in C has nothing behind it that counts.
        u_again     <= (c_takes && (last || first)) || c_report || c_clear || c_join || c_looks;
        u_active    <= c_active;
        u_report    <= c_report;
        u_clear     <= c_clear;
        u_join      <= c_join;
        u_busy      <= c_report || c_clear || c_join;
        u_last      <= c_takes && c_commits && last;
        u_first     <= first;
        u_special   <= c_takes && c_commits && (last || first);
        u_placed    <= place;
        u_max_grant <= c_active || c_join || (c_looks && looks_max);
        u_timed     <= c_timed;
        u_g         <= c_g;
        u_rest      <= forward ? u_rest - 1'b1 : c_rest;
        u_one       <= forward ? u_two : c_one;
        u_th        <= radix_th;
        u_step      <= radix_step;
        u_min       <= radix_min;
        u_max       <= radix_max;
        u_highest   <= {1'b0, radix_max} - {1'b0, radix_step};
        u_lowest    <= {1'b0, radix_min} + {1'b0, radix_step};
        u_nev_th    <= nev_th;
        if (rst) {u_takes, u_last, u_special, u_report, u_clear, u_join, u_busy} <= 7'd0;
    end

    // ---- average and centre, from C to W ----------------------------------------------------------------------------

    wire [X_W:0]     u_offset_x;
    wire [Y_W:0]     u_offset_y;

    array_average #(
        .A_W (X_W),
        .FRAC(FRAC),
        .COPY(0)
    ) u_average_x (
        .clk     (clk),
        .rst     (rst),
        .next_at (d_x),
        .event_at(c_x),
        .k       (hist_avg),
        .forward (forward),
        .av      (c_av_x),
        .passes  (passes),
        .cm      (c_cm_x),
        .place   (place),
        .position(c_join ? join_x : {c_clear ? init_cm_x : c_x, {FRAC{1'b0}}}),
        .again   (u_again),
        .moves   (u_last && !u_placed),
        .u_cm    (u_cm_x),
        .u_offset(u_offset_x),
        .v_av    (w_cm_x)
    );
    array_average #(
        .A_W (Y_W),
        .FRAC(FRAC),
        .COPY(1)
    ) u_average_y (
        .clk     (clk),
        .rst     (rst),
        .next_at (d_y),
        .event_at(c_y),
        .k       (hist_avg),
        .forward (forward),
        .av      (c_av_y),
        .passes  (passes),
        .cm      (c_cm_y),
        .place   (place),
        .position(c_join ? join_y : {c_clear ? init_cm_y : c_y, {FRAC{1'b0}}}),
        .again   (u_again),
        .moves   (u_last && !u_placed),
        .u_cm    (u_cm_y),
        .u_offset(u_offset_y),
        .v_av    (w_cm_y)
    );

    // ---- U ---------------------------------------------------------------------------------------------------------

    // The ring is what lies inside the window but further than g from the centre on either axis.
    wire signed [OFF_W-1:0] offset_x = {{(OFF_W - X_W - 1) {u_offset_x[X_W]}}, u_offset_x};
    wire signed [OFF_W-1:0] offset_y = {{(OFF_W - Y_W - 1) {u_offset_y[Y_W]}}, u_offset_y};
    wire signed [OFF_W-1:0] inner    = {{(OFF_W - RADIX_W) {1'b0}}, u_g};
    wire signed [OFF_W-1:0] over_x   = inner - offset_x;
    wire signed [OFF_W-1:0] over_y   = inner - offset_y;
    wire signed [OFF_W-1:0] under_x  = inner + offset_x;
    wire signed [OFF_W-1:0] under_y  = inner + offset_y;

    // Signs of differences tell which is larger.
    wire [RADIX_W:0]   grows_by   = {1'b0, u_highest[RADIX_W-1:0]} - {1'b0, u_g};
    wire [RADIX_W+1:0] shrinks_by = {2'b00, u_g} - {1'b0, u_lowest};

    wire u_sets = u_placed && (u_takes || u_clear || u_join);

    wire u_outside = over_x[OFF_W-1] || over_y[OFF_W-1] || under_x[OFF_W-1] || under_y[OFF_W-1];

    reg               v_special, v_active, v_last, v_first, v_report, v_clear, v_join, v_places, v_sets;
    reg               v_outside, v_rung, v_times, v_lives;
    reg [1:0]         v_mode;
    reg [X_W:0]       v_offset_x;
    reg [Y_W:0]       v_offset_y;
    reg [RADIX_W-1:0] v_g, v_grown, v_shrunk, v_th;
    reg [RADIX_W:0]   v_radius, v_th_less_1;
    reg [NEV_W-1:0]   v_n_ev, v_nev_min, v_nev_max, v_clust_nev;
    reg [TIME_W-1:0]  v_start;
    reg [TC_W-1:0]    v_last_tc2, v_nev_th;
    reg               v_full;
    reg [SUP_W-1:0]   v_count;

    wire v_ring = v_rung || v_outside;

    // Both are read a clock before they are written: an event that follows one of its own slot takes what that one makes of it.
    wire [SUP_W:0] counted     = {v_full, v_count} + {{SUP_W{1'b0}}, !v_full};
    wire [SUP_W:0] new_support = v_clear ? {(SUP_W + 1) {1'b0}} : v_join ? {1'b0, join_support} : counted;

    always @(posedge clk) begin
        v_busy     <= u_special || u_busy;
        v_took     <= u_takes;
        v_special  <= u_special;
        v_last     <= u_last;
        v_report   <= u_report;
        v_clear    <= u_clear;
        v_join     <= u_join;
        v_places   <= u_sets || u_last;
        v_sets     <= u_sets;
        v_slot     <= u_slot;
        v_offset_x <= u_offset_x;
        v_offset_y <= u_offset_y;
        v_radius   <= {1'b0, u_g} + {1'b0, u_th};
        v_outside  <= u_outside;
        v_rung     <= u_follows ? v_ring : ring[u_slot];
        {v_full, v_count} <= u_follows ? new_support : support[u_slot];
        v_times    <= u_clear || u_join || (u_takes && (u_active || u_special));
        v_lives    <= u_max_grant || u_last;
        v_grant    <= (u_max_grant || u_last) ? max_ticks : detect_ticks;
        if (u_again) begin
            v_active    <= u_active;
            v_first     <= u_first;
            v_mode      <= mode;
            v_timed     <= u_timed;
            v_deadline  <= deadline[u_slot];
            v_id        <= id[u_slot];
            v_g         <= u_clear ? init_radix : !u_join ? u_g : (join_g > u_max) ? u_max : join_g;
            v_grown     <= (u_highest[RADIX_W] || grows_by[RADIX_W]) ? u_max : u_g + u_step;
            v_shrunk    <= shrinks_by[RADIX_W+1] ? u_min : u_g - u_step;
            v_th        <= u_th;
            v_th_less_1 <= {1'b0, u_th} - 1'b1;
            v_n_ev      <= n_ev[u_slot];
            v_nev_min   <= nev_min;
            v_nev_max   <= nev_max;
            v_clust_nev <= clust_nev;
            v_start     <= start[u_slot];
            v_last_tc2  <= last_tc2[u_slot];
            v_nev_th    <= u_nev_th;
        end
        if (rst) {v_busy, v_took, v_special, v_last, v_report, v_clear, v_join, v_places, v_sets} <= 9'd0;
    end

    // ---- V ---------------------------------------------------------------------------------------------------------

    wire signed [OFF_W-1:0] from_x = {{(OFF_W - X_W - 1) {v_offset_x[X_W]}}, v_offset_x};
    wire signed [OFF_W-1:0] from_y = {{(OFF_W - Y_W - 1) {v_offset_y[Y_W]}}, v_offset_y};

    wire [OFF_W-1:0] rel_x = from_x + {{(OFF_W - RADIX_W - 1) {1'b0}}, v_radius};
    wire [OFF_W-1:0] rel_y = from_y + {{(OFF_W - RADIX_W - 1) {1'b0}}, v_radius};

    assign v_rel_x = rel_x[RADIX_W+1:0];
    assign v_rel_y = rel_y[RADIX_W+1:0];

    // A window that starts a timer or moves it is read again after W, the timer itself only in walks.
    wire [LIFE_W-1:0] new_deadline = now[LIFE_W-1:0] + {{(LIFE_W - TC_W) {1'b0}}, v_grant} + {{(LIFE_W - 1) {1'b0}}, !v_lives};

    assign v_on = v_mode != `EVCOT_MODE_OFF;

    assign v_support = v_count | {SUP_W{v_full}};

    wire [RADIX_W-1:0] new_g = !v_last ? v_g : v_ring ? v_grown : v_shrunk;

    wire [NEV_W+1:0] over_max  = {2'b00, v_nev_max} - {1'b0, v_n_ev, 1'b0};
    wire [NEV_W:0]   under_min = {1'b0, v_n_ev >> 1} - {1'b0, v_nev_min};

    reg               w_last, w_special, w_report, w_clear, w_old;
    reg               w_first;
    reg [1:0]         w_mode;
    reg [RADIX_W-1:0] w_g;
    reg [RADIX_W:0]   w_radius;
    reg [RADIX_W+1:0] w_inset;
    reg [NEV_W-1:0]   w_n_ev, w_nev_min, w_nev_max;
    reg               w_over, w_under;  // twice and half of n_ev are over and under these
    reg [SUP_W:0]     w_support;
    reg [ID_W-1:0]    w_id;
    reg [TIME_W-1:0]  w_span;  // ticks that the window took
    reg [TC_W:0]      w_slow_over, w_fast_under;
    reg               w_reports, w_sets;

    wire [SLOT_W-1:0] av_slot = (w_sets ? w_slot : v_slot) ^ {SLOT_W{FAR == 0}};

    always @(posedge clk) begin
        if (v_took || v_clear || v_join) support[v_slot] <= new_support;
        // Where a centre is placed, the average is set to it in W.
        if (v_took || w_sets) begin
            av_x[av_slot] <= w_cm_x;
            av_y[av_slot] <= w_cm_y;
        end
        if (v_took || v_clear) ring[v_slot] <= v_ring && !v_last && !v_clear;
        if (v_times) timed[v_slot] <= !v_clear;
        if (v_times) deadline[v_slot] <= new_deadline;

        w_busy    <= v_busy;
        w_checks  <= v_last || v_join;
        w_reports <= v_last || v_join || v_report;
        w_places  <= v_places;
        w_sets    <= v_sets;
        w_special <= v_special;
        w_last    <= v_last;
        w_report  <= v_report;
        w_clear   <= v_clear;
        if (v_busy) begin
            w_old     <= v_active || v_join;
            w_slot    <= v_slot;
            w_mode    <= v_mode;
            w_g       <= new_g;
            w_radius  <= {1'b0, new_g} + {1'b0, v_th};
            w_inset   <= {v_th_less_1[RADIX_W], v_th_less_1} + {2'b00, new_g};
            w_n_ev    <= v_clear ? v_clust_nev : v_n_ev;
            w_nev_min <= v_nev_min;
            w_nev_max <= v_nev_max;
            w_over    <= over_max[NEV_W+1];
            w_under   <= under_min[NEV_W];
            w_support <= v_report ? {v_full, v_count} : new_support;
            w_id      <= v_id;
            w_first   <= v_first;
            w_span    <= now[TIME_W-1:0] - v_start;
            w_slow_over  <= {1'b0, v_last_tc2} + {1'b0, v_nev_th};
            w_fast_under <= {1'b0, v_last_tc2} - {1'b0, v_nev_th};
        end
        if (rst) {w_busy, w_checks, w_reports, w_places, w_special, w_last, w_report, w_clear, w_sets} <= 9'd0;
    end

    // ---- W ---------------------------------------------------------------------------------------------------------

    wire [X_W-1:0] w_pixel_x;
    wire [Y_W-1:0] w_pixel_y;

    cot_window #(
        .W   (X_W),
        .FRAC(FRAC),
        .R_W (RADIX_W + 1)
    ) u_window_x (
        .asked (w_busy),
        .centre(w_cm_x),
        .radius(w_radius),
        .inset (w_inset),
        .pixel (w_pixel_x),
        .lo_not(w_lo_x_not),
        .hi    (w_hi_x)
    );
    cot_window #(
        .W   (Y_W),
        .FRAC(FRAC),
        .R_W (RADIX_W + 1)
    ) u_window_y (
        .asked (w_busy),
        .centre(w_cm_y),
        .radius(w_radius),
        .inset (w_inset),
        .pixel (w_pixel_y),
        .lo_not(w_lo_y_not),
        .hi    (w_hi_y)
    );

    assign w_changes = w_special || w_clear;
    assign w_free    = w_clear && w_mode == `EVCOT_MODE_SEEDED;
    assign w_window  = !w_clear || w_mode == `EVCOT_MODE_FIXED;
    assign w_active  = !w_clear && (w_old || w_last);

    assign w_born = w_last && !w_old;

    // TC2, the window's ticks, has TC_W bits and stops at its largest value.
    wire [TC_W+1:0] over_slow = {1'b0, w_slow_over} - {2'b00, w_span[TC_W-1:0]};
    wire [TC_W:0]   over_fast = {1'b0, w_span[TC_W-1:0]} - {1'b0, w_fast_under[TC_W-1:0]};

    reg              x_busy, x_reports, x_last, x_first, x_rest, x_adapts;
    reg              x_far;             // the span has more bits
    reg              x_over, x_at_most; // it is over slow_over, so is its largest value; not so
    reg              x_under;           // it is under fast_under
    reg [TC_W-1:0]   x_span;
    reg [SLOT_W-1:0] x_slot;
    reg [NEV_W-1:0]  x_same, x_doubled, x_halved;

    // ---- X ---------------------------------------------------------------------------------------------------------

    reg [NEV_W-1:0]  x_n_ev;

    always @* begin
        x_n_ev = {NEV_W{1'bx}};
        if (x_busy) begin
            x_n_ev = x_same;
            if (x_adapts && (x_far ? !x_at_most : x_over)) x_n_ev = x_doubled;
            else if (x_adapts && !x_far && x_under) x_n_ev = x_halved;
        end
    end

    reg              y_rest;  // the number of events left starts over
    reg [SLOT_W-1:0] y_slot;
    reg [NEV_W-1:0]  y_n_ev;

    always @(posedge clk) begin
        if (w_places) cm[w_slot] <= {w_cm_x, w_cm_y, w_g};
        if (w_special) start[w_slot] <= now[TIME_W-1:0];
        if (w_born) begin
            id[w_slot] <= births;
            births     <= births + 1'b1;
        end

        x_busy    <= w_busy;
        x_reports <= w_reports;
        x_last    <= w_last;
        x_rest    <= w_last || w_clear;
        if (w_busy) begin
            x_slot    <= w_slot;
            x_first   <= w_first;
            x_adapts  <= w_last && w_old;
            x_far     <= |w_span[TIME_W-1:TC_W];
            x_over    <= over_slow[TC_W+1];
            x_at_most <= w_slow_over[TC_W] || &w_slow_over[TC_W-1:0];
            x_under   <= over_fast[TC_W] && !w_fast_under[TC_W];
            x_span    <= w_span[TC_W-1:0];
            x_same    <= w_n_ev;
            x_doubled <= w_over ? w_nev_max : w_n_ev << 1;
            x_halved  <= w_under ? w_nev_min : w_n_ev >> 1;
        end

        if (x_rest) n_ev[x_slot] <= x_n_ev;
        if (x_last) last_tc2[x_slot] <= x_first ? {TC_W{1'b0}} : x_span | {TC_W{x_far}};
        y_rest <= x_rest;
        y_slot <= x_slot;
        y_n_ev <= x_n_ev;

        if (y_rest) rest[y_slot] <= {y_n_ev == ONE, y_n_ev == TWO, y_n_ev - 1'b1};
        else if (u_takes) rest[u_slot] <= {u_one, u_two, u_rest - 1'b1};

        if (m_cm_ready) m_cm_valid <= 1'b0;
        if (x_reports) begin
            m_cm_valid <= 1'b1;
            m_cm_n_ev  <= x_n_ev;
        end
        // The rest of the record is a clock early: nothing is in the register then.
        if (w_reports) begin
            m_cm_kind    <= w_report ? (lost ? `EVCOT_KIND_LOST : `EVCOT_KIND_MERGED)
                          : w_born   ? `EVCOT_KIND_BORN : `EVCOT_KIND_MOVED;
            m_cm_slot    <= w_slot;
            m_cm_id      <= w_born ? births : w_id;
            m_cm_other   <= (w_report && !lost) ? other : {ID_W{1'b0}};
            m_cm_x       <= w_cm_x;
            m_cm_y       <= w_cm_y;
            m_cm_radius  <= w_radius;
            m_cm_support <= w_support[SUP_W-1:0] | {SUP_W{w_support[SUP_W]}};
            m_cm_seq     <= seq;
            m_cm_time    <= (w_report && lost) ? ended : now[TIME_W-1:0];
        end
        if (rst) begin
            births     <= {ID_W{1'b0}};
            m_cm_valid <= 1'b0;
            {x_reports, x_last, x_rest, y_rest} <= 4'd0;
        end
    end

    wire unused = &{1'b0, d_slot, not_x, not_y, w_pixel_x, w_pixel_y, over_max, under_min, grows_by, shrinks_by, over_slow, over_fast,
                    rel_x[OFF_W-1:RADIX_W+2], rel_y[OFF_W-1:RADIX_W+2]};

endmodule

`default_nettype wire
