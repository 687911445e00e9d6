// SPDX-License-Identifier: Apache-2.0
// The pipeline in which events are decided and move the sides of their owners. Nothing in it ever waits: what an event changes is
// forwarded to the next one. What else changes slots comes between two events, as a token of its own, an operation.
//
// Stages: 1 the address, 2 the slots that it hits, 3 those of the kind that decides, 4 the owner, 5 what is read of it, 6 what becomes of
// the event, 7 it is done, and the sides are written; 8 its bin.
//
// Operations: `step` reads a slot for its motion step; `effect` puts into effect what has been computed of a slot (`e_own`), and ends
// other slots; `clear` clears a bin. What takes effect must stay until it is done, and the token behind it must be empty. All that a
// job needs to know of a slot, and of its cause, leaves as j_*.
//
// Latency:    7 clocks from a token to what becomes of it, and to j_*; 8 to its bin; 6 from an effect until it is done.
// Throughput: a token or an operation per clock.
// Stall:      none; only tokens for which there is room may enter, and none that `collides` with masks that are being written.
// Reset:      nothing is under way, and every slot is free; then masks are cleared, until `ready` is high.
// Combinational paths: s_x, s_y, next_x, next_y -> collides.
`default_nettype none
`include "motion_fields.vh"

module motion_events #(
    parameter N       = 8,
    parameter SLOT_W  = 3,
    parameter X_W     = 9,
    parameter Y_W     = 9,
    parameter SIDE_W  = 25,  // bits of a side
    parameter PX_W    = 13,  // bits of a bound in pixels
    parameter RADIX_W = 8,
    parameter SUP_W   = 16,  // bits of a support count
    parameter SEQ_W   = 48,
    parameter TIME_W  = 48
) (
    input  wire              clk,
    input  wire              rst,
    output wire              ready,       // for tokens

    // a token; an event has its owner decided, one that is skipped is counted alone
    input  wire              s_valid,
    input  wire              s_event,
    input  wire              s_skip,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    input  wire              s_p,
    input  wire              s_burst,     // it is within a burst (docs/motion.md, rule T4)
    input  wire [TIME_W-1:0] s_time,
    input  wire [X_W-1:0]    next_x,      // of the token behind it, and
    input  wire [Y_W-1:0]    next_y,
    output wire              collides,    // neither may come in the next clock: see motion_match.v

    // box and window of a slot, lo and hi on x, lo and hi on y, which may take effect when `mask_busy` is low
    input  wire              mask,
    input  wire [SLOT_W-1:0] mask_slot,   // with it, and in the clock before
    input  wire [4*PX_W-1:0] mask_box,    // until `mask_busy` is low
    input  wire [4*PX_W-1:0] mask_window, // from two clocks later on
    output wire              mask_busy,

    // an operation
    input  wire              op_step,     // of which s_time is the tick
    input  wire              op_effect,
    input  wire              op_clear,
    input  wire [SLOT_W-1:0] op_slot,
    input  wire [3:0]        op_bin,
    output wire              effect_done,
    output wire              active,      // a token or an operation is in a stage

    // what takes effect, from the clock after `op_effect` on: of op_slot, if it is its own,
    input  wire              e_own,
    input  wire [N-1:0]      e_ended,     // and the end of these slots
    input  wire [1:0]        e_state,     // free, candidate, visible, left
    input  wire [4*SIDE_W-1:0] e_moves,   // how far sides move: lo and hi on x, lo and hi on y
    input  wire [3:0]        e_marks,     // hi and lo of y, hi and lo of x
    input  wire [3:0]        e_hidden,
    input  wire [2*RADIX_W+3:0] e_middle, // of the box, half pixels, y and x
    input  wire [9:0]        e_n_ev,
    input  wire [9:0]        bin_log2,    // of the bins that are cleared, y and x

    // registers and slots
    input  wire [`MOTION_REGS_W-1:0] regs,
    input  wire [N-1:0]      seeded,      // a candidate may begin there
    output reg  [N-1:0]      corrects,    // a correction or a seed of the slot is not in effect
    output wire [N-1:0]      alive,       // not free

    // what becomes of a token
    output reg               d_valid,     // it is done,
    output reg               d_event,     // an event,
    output reg               d_owned,     // which has an owner
    output reg  [SLOT_W-1:0] d_slot,
    output reg  [RADIX_W+1:0] d_rel_x,
    output reg  [RADIX_W+1:0] d_rel_y,
    output reg  [X_W-1:0]    d_x,
    output reg  [Y_W-1:0]    d_y,
    output reg               d_p,
    output reg  [TIME_W-1:0] d_time,
    output reg  [SEQ_W-1:0]  d_seq,
    output reg               d_visible,   // its owner is visible in effect

    // a job, in the clock of d_*; number and tick are d_seq and d_time, the place of a seed d_x and d_y
    output reg               j_valid,
    output reg  [1:0]        j_kind,      // 0 a correction, 1 a seed, 2 a step
    output wire [4*SIDE_W-1:0] j_sides,   // behind the event; of a seed 0
    output wire [3:0]        j_marks,
    output reg  [SUP_W-1:0]  j_owned,     // events owned since the last job
    output reg               j_burst,     // the event is within a burst

    // to the bins
    output reg               bin_count,
    output reg               bin_clear,
    output reg  [SLOT_W-1:0] bin_slot,
    output reg  [3:0]        bin_cleared,
    output wire              in_bin_x,
    output wire              in_bin_y,
    output wire [3:0]        bin_x,
    output wire [3:0]        bin_y
);

    localparam REL_W   = RADIX_W + 2;
    localparam TOKEN_W = TIME_W + X_W + Y_W + 3;

    localparam [1:0] CANDIDATE = 2'd1;
    localparam [1:0] VISIBLE   = 2'd2;
    localparam [1:0] LEFT      = 2'd3;

    // ---- what follows from the registers -------------------------------------------------------------------------------

    reg  [16:0]       out;          // ways of a side
    wire [16:0]       back;
    wire [33:0]       backs;        // 2^15 times back: a shift to the right is a product with a power of two
    reg               counts;       // events are counted in bins

    assign back = backs[15+:17];

    multiplier #(
        .A_W(17),
        .B_W(17)
    ) u_back (
        .clk(clk),
        .a  ({1'b0, regs[`MOTION_SIDE_STEP]}),
        .b  (17'h8000 >> regs[`MOTION_SIDE_SHARE]),
        .p  (backs)
    );

    always @(posedge clk) begin
        out    <= {1'b0, regs[`MOTION_SIDE_STEP] - back[15:0]};
        counts <= regs[`MOTION_GAP_CORRECTIONS] != 8'd0;
    end

    // ---- stages 1 to 4: whose is it? -----------------------------------------------------------------------------------

    reg  [6:1]         valid;            // a token
    reg  [6:1]         burst;            // its event is within a burst
    reg  [TOKEN_W-1:0] token_1, token_2, token_3, token_4, token_5, token_6;
    reg  [2:0]         op_1, op_2, op_3, op_4, op_5, op_6;  // clear, effect, step
    reg  [6:2]         ops;              // one of them
    reg  [SLOT_W-1:0]  op_slot_1, op_slot_2, op_slot_3;
    reg  [3:0]         bin_1, bin_2, bin_3, bin_4, bin_5, bin_6, bin_7;
    reg  [N-1:0]       visible, candidate, left;  // in effect
    reg  [N-1:0]       empty, fresh;     // free slots in which a candidate may begin; those without a track that may return
    reg  [N-1:0]       visible_2;        // a clock later
    wire               owned_4, begins_4, shared_4;
    wire [SLOT_W-1:0]  slot_4;

    // What takes effect changes states in its second stage: the event in front has its owner by then, but not yet its state.
    wire [N-1:0]       one     = {{(N - 1) {1'b0}}, 1'b1};
    reg  [N-1:0]       comes, ends;     // then: a one for the slot, if it is its own; slots that end
    wire [N-1:0]       others  = ~(comes | ends);
    wire [N-1:0]       lives   = comes & ~ends;

    always @(posedge clk) begin
        comes     <= op_1[1] && e_own ? one << op_slot_1 : {N{1'b0}};
        ends      <= op_1[1] ? e_ended : {N{1'b0}};
        visible   <= (visible & others) | (lives & {N{e_state == VISIBLE}});
        candidate <= (candidate & others) | (lives & {N{e_state == CANDIDATE}});
        left      <= (left & others) | (lives & {N{e_state == LEFT}});
        visible_2 <= visible;
        empty     <= seeded & ~(visible | candidate);
        fresh     <= seeded & ~(visible | candidate | left);
        if (rst) {visible, candidate, left, comes, ends} <= {(5 * N) {1'b0}};
    end

    motion_match #(
        .N     (N),
        .X_W   (X_W),
        .Y_W   (Y_W),
        .PX_W  (PX_W),
        .SLOT_W(SLOT_W)
    ) u_match (
        .clk        (clk),
        .rst        (rst),
        .ready      (ready),
        .x          (s_x),
        .y          (s_y),
        .next_x     (next_x),
        .next_y     (next_y),
        .collides   (collides),
        .visible    (visible),
        .candidate  (candidate),
        .fresh      (fresh),
        .empty      (empty),
        .asked      (valid[3]),
        .is_op      (ops[3]),
        .op_slot    (op_slot_3),
        .owned      (owned_4),
        .begins     (begins_4),
        .shared     (shared_4),
        .owner      (slot_4),
        .update     (mask),
        .update_slot(mask_slot),
        .box        (mask_box),
        .window     (mask_window),
        .busy       (mask_busy),
        .place      (op_2[1] && e_own),
        .place_slot (op_slot_2)
    );

    always @(posedge clk) begin
        valid     <= {valid[5:1], s_valid};
        burst     <= {burst[5:1], s_burst};
        token_1   <= {s_time, s_event, s_skip, s_x, s_y, s_p};
        token_2   <= token_1;
        token_3   <= token_2;
        token_4   <= token_3;
        token_5   <= token_4;
        token_6   <= token_5;
        op_1      <= {op_clear, op_effect, op_step};
        op_2      <= op_1;
        ops       <= {ops[5:2], |op_1};
        op_3      <= op_2;
        op_4      <= op_3;
        op_5      <= op_4;
        op_6      <= op_5;
        op_slot_1 <= op_slot;
        op_slot_2 <= op_slot_1;
        op_slot_3 <= op_slot_2;
        bin_1     <= op_bin;
        bin_2     <= bin_1;
        bin_3     <= bin_2;
        bin_4     <= bin_3;
        bin_5     <= bin_4;
        bin_6     <= bin_5;
        bin_7     <= bin_6;
        if (rst) begin
            valid <= 6'd0;
            {op_1, op_2, op_3, op_4, op_5, op_6} <= 18'd0;
            ops <= 5'd0;
        end
    end

    // ---- stages 5 to 7: what it does to its owner ----------------------------------------------------------------------

    reg               owned_5, begins_5, shared_5, visible_5, same_5, recent_5;
    reg               visible_6;
    reg               takes, measures, updates, begins_6;  // an owner has the event; its sides move; it is counted; or a candidate may begin
    reg  [SLOT_W-1:0] slot_5, slot_6;
    reg               seeding;                        // a candidate has begun that is not in effect,
    reg  [SLOT_W-1:0] seed_slot;                      // here,
    reg  [N-1:0]      seed_here;                      // a one for that slot, if any
    reg               new_5, new_6;                   // the operation is on that slot
    reg  [SUP_W:0]    owneds [0:(1<<SLOT_W)-1];       // no more is counted; events since the last job
    reg  [11:0]       lefts  [0:(1<<SLOT_W)-1];       // is it one? is it any? events until the next correction; 0: one is not in effect
    reg  [SEQ_W-1:0]  seq;                            // number of the next event
    reg  [SUP_W-1:0]  owned_6;
    reg               full_6;
    reg  [9:0]        left_6;
    reg               any_left_6, last_left_6;
    reg  [11:0]       left_op;                        // what takes effect

    wire               event_5 = valid[5] && token_5[X_W+Y_W+2];
    wire               event_6 = valid[6] && token_6[X_W+Y_W+2];
    wire               skip_6  = token_6[X_W+Y_W+1];
    wire               seeds_6    = begins_6 && !seeding;
    wire               corrects_6 = updates && last_left_6;
    wire               own_5      = op_5[1] && e_own;
    reg                own_6, acts_6;      // what takes effect is the slot's own; it is, or a step
    wire [SUP_W-1:0]   owned_next = owned_6 + {{(SUP_W - 1) {1'b0}}, !full_6};
    wire               full_next  = &(owned_6 | {{(SUP_W - 1) {1'b0}}, 1'b1});
    wire [SUP_W:0]     owned_new  = corrects_6 || seeds_6 || op_6[0] ? {(SUP_W + 1) {1'b0}} : {full_next, owned_next};
    wire [9:0]         left_next  = left_6 - 10'd1;
    wire [11:0]        left_5     = lefts[slot_5];
    wire               last_next  = left_6 == 10'd2;
    wire               any_next   = !same_5 ? left_5[10] : any_left_6 && !corrects_6;
    wire [16:0]        far_once   = visible_5 ? out : {out[15:0], 1'b0};
    wire [18:0]        far        = burst[5] ? {far_once, 2'b00} : {2'b00, far_once};
    wire [16:0]        near       = visible_5 ? back : {back[15:0], 1'b0};
    wire [REL_W-1:0]   rel_x, rel_y;
    wire [SIDE_W-1:0]  lo_x_7, hi_x_7, lo_y_7, hi_y_7;
    wire [N-1:0]       here_6     = one << slot_6;

    assign effect_done = op_6[1];
    assign active      = |valid || |op_1 || |ops || d_valid;
    assign alive       = visible | candidate | left | seed_here;
    assign j_sides     = {lo_x_7, hi_x_7, lo_y_7, hi_y_7};

    always @(posedge clk) begin
        owned_5   <= owned_4;
        begins_5  <= begins_4;
        shared_5  <= shared_4;
        visible_5 <= visible_2[slot_4];
        slot_5    <= slot_4;
        same_5    <= event_5 && owned_5 && !begins_5 && slot_4 == slot_5;
        recent_5  <= (measures || own_6) && slot_4 == slot_6;

        takes     <= event_5 && owned_5 && !begins_5;
        measures  <= event_5 && owned_5 && !begins_5 && !shared_5;
        updates   <= event_5 && owned_5 && !begins_5 && !shared_5 && any_next;
        begins_6  <= event_5 && owned_5 && begins_5;
        slot_6    <= slot_5;
        visible_6 <= visible_5;
        own_6     <= own_5;
        acts_6    <= own_5 || op_5[0];
        new_5     <= seeding && slot_4 == seed_slot && (op_4[0] || (op_4[1] && e_own));  // long after it was seeded
        new_6     <= new_5;
        if (!same_5 || takes) {full_6, owned_6} <= same_5 ? owned_new : owneds[slot_5];
        if (!same_5 || updates) {last_left_6, left_6} <= same_5 ? {last_next, left_next} : {left_5[11], left_5[9:0]};
        any_left_6 <= any_next;
        left_op    <= {e_n_ev == 10'd1, e_n_ev != 10'd0, e_n_ev};

        if (takes || seeds_6 || op_6[0]) owneds[slot_6] <= owned_new;
        if (updates || (own_6 && (new_6 || !any_left_6)))
            lefts[slot_6] <= updates ? {last_next, !last_left_6, left_next} : left_op;
        corrects <= (corrects | (corrects_6 || seeds_6 ? here_6 : {N{1'b0}}))
                  & ~(own_6 ? here_6 : {N{1'b0}}) & ~(op_6[1] ? e_ended : {N{1'b0}});
        if (seeds_6) {seeding, seed_slot, seed_here} <= {1'b1, slot_6, here_6};
        if (op_6[1] && (new_6 || |(e_ended & seed_here))) {seeding, seed_here} <= {(N + 1) {1'b0}};

        d_valid    <= valid[6];
        d_event    <= event_6;
        d_owned    <= takes || seeds_6;
        d_slot     <= slot_6;
        d_visible  <= visible_6;
        d_rel_x    <= seeds_6 ? {REL_W{1'b0}} : rel_x;
        d_rel_y    <= seeds_6 ? {REL_W{1'b0}} : rel_y;
        {d_x, d_y, d_p} <= token_6[X_W+Y_W:0];
        d_time     <= token_6[TOKEN_W-1-:TIME_W];
        if (valid[6] && (event_6 || skip_6)) seq <= seq + {{(SEQ_W - 1) {1'b0}}, 1'b1};
        d_seq      <= seq;
        j_valid    <= corrects_6 || seeds_6 || op_6[0];
        j_kind     <= {op_6[0], seeds_6};
        j_owned    <= op_6[0] ? owned_6 : owned_next;
        j_burst    <= burst[6];
        if (rst) begin
            {takes, measures, updates, begins_6, own_6, acts_6} <= 6'd0;
            corrects <= {N{1'b0}};
            {seeding, seed_here} <= {(N + 1) {1'b0}};
            seq      <= {SEQ_W{1'b0}};
            d_valid  <= 1'b0;
            j_valid  <= 1'b0;
        end
    end

    motion_axis #(
        .SLOT_W(SLOT_W),
        .AT_W  (X_W),
        .SIDE_W(SIDE_W),
        .PX_W  (PX_W),
        .REL_W (REL_W)
    ) u_x (
        .clk     (clk),
        .slot    (slot_4),
        .place   (token_5[Y_W+1+:X_W]),
        .out     (far),
        .back    (near),
        .forward (same_5),
        .recent  (recent_5),
        .slot_2  (slot_5),
        .moves   (own_5),
        .rests   (op_5[0]),
        .fresh   (new_5),
        .update  (measures || acts_6),
        .effect  (own_6),
        .clear   (corrects_6),
        .set_bins(op_6[2]),
        .begins  (seeds_6),
        .slot_3  (slot_6),
        .rel     (rel_x),
        .m_lo    (lo_x_7),
        .m_hi    (hi_x_7),
        .m_marks (j_marks[1:0]),
        .hide_now(op_4[1] && e_own),
        .s_move_lo(e_moves[3*SIDE_W+:SIDE_W]),
        .s_move_hi(e_moves[2*SIDE_W+:SIDE_W]),
        .s_marks (e_marks[1:0]),
        .s_hidden(e_hidden[1:0]),
        .s_middle(e_middle[0+:REL_W]),
        .s_log2  (bin_log2[4:0]),
        .in_bin  (in_bin_x),
        .bin     (bin_x)
    );

    motion_axis #(
        .SLOT_W(SLOT_W),
        .AT_W  (Y_W),
        .SIDE_W(SIDE_W),
        .PX_W  (PX_W),
        .REL_W (REL_W)
    ) u_y (
        .clk     (clk),
        .slot    (slot_4),
        .place   (token_5[1+:Y_W]),
        .out     (far),
        .back    (near),
        .forward (same_5),
        .recent  (recent_5),
        .slot_2  (slot_5),
        .moves   (own_5),
        .rests   (op_5[0]),
        .fresh   (new_5),
        .update  (measures || acts_6),
        .effect  (own_6),
        .clear   (corrects_6),
        .set_bins(op_6[2]),
        .begins  (seeds_6),
        .slot_3  (slot_6),
        .rel     (rel_y),
        .m_lo    (lo_y_7),
        .m_hi    (hi_y_7),
        .m_marks (j_marks[3:2]),
        .hide_now(op_4[1] && e_own),
        .s_move_lo(e_moves[SIDE_W+:SIDE_W]),
        .s_move_hi(e_moves[0+:SIDE_W]),
        .s_marks (e_marks[3:2]),
        .s_hidden(e_hidden[3:2]),
        .s_middle(e_middle[REL_W+:REL_W]),
        .s_log2  (bin_log2[9:5]),
        .in_bin  (in_bin_y),
        .bin     (bin_y)
    );

    wire unused = &{1'b0, regs, backs};

    // ---- behind: the bins ------------------------------------------------------------------------------------------------

    reg              count_7, clear_7;
    reg [SLOT_W-1:0] slot_7;

    always @(posedge clk) begin
        count_7     <= updates && counts;
        clear_7     <= op_6[2];
        slot_7      <= slot_6;
        bin_count   <= count_7;
        bin_clear   <= clear_7;
        bin_slot    <= slot_7;
        bin_cleared <= bin_7;
        if (rst) {count_7, clear_7, bin_count, bin_clear} <= 4'd0;
    end

endmodule

`default_nettype wire
