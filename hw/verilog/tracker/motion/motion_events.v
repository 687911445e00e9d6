// SPDX-License-Identifier: Apache-2.0
// The pipeline in which events are decided and move the sides of their owners. Nothing in it ever waits: what an event changes is forwarded to the next
// one, what a correction or a step changes comes as a token of its own, an operation, between two events.
//
// Stages: 1 the address, 2 the slots that it hits, 3 those of the kind that decides, 4 the owner, 5 what is read of it, 6 what becomes of
// the event; then it is done, 8 its bin.
//
// An operation reads (`read`, while r_* are the slot's), writes sides (`store`) and support (`full`), puts a box and window in force (`put`),
// with N_ev events from then on (`left`), perhaps of a candidate that begins (`seed`), or clears a bin (`clear`). What it writes must stay
// until it is done; the token behind one that writes must be empty.
//
// Latency:    7 clocks from a token to what becomes of it, 8 to its bin; 6 from an operation until it is done.
// Throughput: a token or an operation per clock.
// Stall:      none; only tokens for which there is room may enter.
// Reset:      nothing is under way.
// Combinational paths: none.
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

    // a token; an event has its owner decided, one that is skipped is counted alone
    input  wire              s_valid,
    input  wire              s_event,
    input  wire              s_skip,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    input  wire              s_p,
    input  wire [TIME_W-1:0] s_time,

    // an operation
    input  wire              op_read,
    input  wire              op_store,
    input  wire              op_full,
    input  wire              op_put,
    input  wire              op_left,
    input  wire              op_seed,
    input  wire              op_clear,
    input  wire [SLOT_W-1:0] op_slot,
    input  wire [3:0]        op_bin,
    output wire              read_done,
    output wire              store_done,
    output wire              put_done,
    output wire              active,      // a token or an operation is in a stage

    // what operations write
    input  wire [4*SIDE_W-1:0] o_sides,   // lo and hi on x, lo and hi on y
    input  wire [3:0]        o_marks,     // hi and lo of y, hi and lo of x
    input  wire [3:0]        o_hidden,
    input  wire [SUP_W-1:0]  o_support,
    input  wire [9:0]        o_log2,      // of bins, y and x
    input  wire [4*PX_W-1:0] o_box,       // of the slot of `put`, from the clock after it came
    input  wire [4*PX_W-1:0] o_window,
    input  wire [9:0]        o_n_ev,

    // what they read
    output wire [4*SIDE_W-1:0] r_sides,
    output wire [3:0]        r_marks,
    output wire [SUP_W-1:0]  r_support,

    // a motion step asks which boxes and windows share an interval
    input  wire              ask,
    input  wire [4*PX_W-1:0] ask_for,     // lo and hi on x, lo and hi on y
    output wire [N-1:0]      in_box,      // two clocks later
    output wire [N-1:0]      in_window,
    output wire [N-1:0]      in_line,     // which boxes share a column or a row

    // registers and slots
    input  wire [`MOTION_REGS_W-1:0] regs,
    input  wire [N-1:0]      visible,
    input  wire [N-1:0]      candidate,
    input  wire [N-1:0]      fresh,
    input  wire [N-1:0]      empty,
    output wire              begins,      // a candidate is in force
    output wire [SLOT_W-1:0] begins_slot,

    // what becomes of a token
    output reg               d_valid,     // it is done,
    output reg               d_event,     // an event,
    output reg               d_owned,     // which has an owner,
    output reg               d_corrects,  // who is to be corrected,
    output reg               d_seeds,     // or begins
    output reg  [SLOT_W-1:0] d_slot,
    output reg  [RADIX_W+1:0] d_rel_x,
    output reg  [RADIX_W+1:0] d_rel_y,
    output reg  [X_W-1:0]    d_x,
    output reg  [Y_W-1:0]    d_y,
    output reg               d_p,
    output reg  [SUP_W-1:0]  d_support,
    output reg  [TIME_W-1:0] d_time,
    output reg  [SEQ_W-1:0]  d_seq,
    output reg  [SEQ_W-1:0]  seq,         // number of the next event

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

    // ---- what follows from the registers -------------------------------------------------------------------------------

    reg  [16:0]       out, back;    // ways of a side
    reg               counts;       // events are counted in bins
    wire [15:0]       share = regs[`MOTION_SIDE_STEP] >> regs[`MOTION_SIDE_SHARE];

    always @(posedge clk) begin
        back   <= {1'b0, share};
        out    <= {1'b0, regs[`MOTION_SIDE_STEP] - back[15:0]};
        counts <= regs[`MOTION_GAP_CORRECTIONS] != 8'd0;
    end

    // ---- stages 1 to 4: whose is it? -----------------------------------------------------------------------------------

    reg  [6:1]         valid;            // a token
    reg  [TOKEN_W-1:0] token_1, token_2, token_3, token_4, token_5, token_6;
    reg  [6:0]         op_1, op_2, op_3, op_4, op_5, op_6;  // clear, seed, left, put, full, store, read
    reg  [6:2]         ops;              // one of them
    reg  [SLOT_W-1:0]  op_slot_1, op_slot_2, op_slot_3;
    reg  [3:0]         bin_1, bin_2, bin_3, bin_4, bin_5, bin_6, bin_7;
    reg  signed [PX_W-1:0] lo_x, hi_x, lo_y, hi_y;
    reg                asked;            // for an event, or by a motion step
    wire [N-1:0]       box_x, box_y, window_x, window_y;
    wire               owned_4, begins_4, shared_4;
    wire [SLOT_W-1:0]  slot_4;

    assign in_box      = box_x & box_y;
    assign in_window   = window_x & window_y;
    assign in_line     = box_x | box_y;
    assign begins      = op_2[5];
    assign begins_slot = op_slot_2;

    motion_match #(
        .N     (N),
        .PX_W  (PX_W),
        .SLOT_W(SLOT_W)
    ) u_match (
        .clk       (clk),
        .asked     (asked),
        .lo_x      (lo_x),
        .hi_x      (hi_x),
        .lo_y      (lo_y),
        .hi_y      (hi_y),
        .box_x     (box_x),
        .box_y     (box_y),
        .window_x  (window_x),
        .window_y  (window_y),
        .visible   (visible),
        .candidate (candidate),
        .fresh     (fresh),
        .empty     (empty),
        .is_op     (ops[3]),
        .op_slot   (op_slot_3),
        .owned     (owned_4),
        .begins    (begins_4),
        .shared    (shared_4),
        .owner     (slot_4),
        .place     (op_2[3]),
        .place_slot(op_slot_2),
        .box       (o_box),
        .window    (o_window)
    );

    always @(posedge clk) begin
        valid     <= {valid[5:1], s_valid};
        token_1   <= {s_time, s_event, s_skip, s_x, s_y, s_p};
        token_2   <= token_1;
        token_3   <= token_2;
        token_4   <= token_3;
        token_5   <= token_4;
        token_6   <= token_5;
        op_1      <= {op_clear, op_seed, op_left, op_put, op_full, op_store, op_read};
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
        {lo_x, hi_x} <= {2{{{(PX_W - X_W) {1'b0}}, s_x}}};
        {lo_y, hi_y} <= {2{{{(PX_W - Y_W) {1'b0}}, s_y}}};
        asked <= s_valid || ask;
        if (ask) {lo_x, hi_x, lo_y, hi_y} <= ask_for;
        if (rst) begin
            valid <= 6'd0;
            {op_1, op_2, op_3, op_4, op_5, op_6} <= 42'd0;
            ops <= 5'd0;
        end
    end

    // ---- stages 5 and 6: what it does to its owner ---------------------------------------------------------------------

    reg               owned_5, begins_5, shared_5, visible_5, same_5, recent_5;
    reg               takes, updates, begins_6;       // an owner has the event; it changes the owner; or a candidate may begin
    reg  [SLOT_W-1:0] slot_5, slot_6;
    reg               seeding;                        // a candidate has begun that is not in force
    reg  [SUP_W:0]    supports[0:(1<<SLOT_W)-1];      // no more is counted; the count
    reg  [11:0]       lefts   [0:(1<<SLOT_W)-1];      // is it one? is it any? events until the next correction; 0: one is not in force yet
    reg  [SUP_W-1:0]  support_6;
    reg               full_6;
    reg  [9:0]        left_6;
    reg               any_left_6, last_left_6;
    reg  [11:0]       left_op;                        // what an operation writes

    wire               event_5 = valid[5] && token_5[X_W+Y_W+2];
    wire               event_6 = valid[6] && token_6[X_W+Y_W+2];
    wire               skip_6  = token_6[X_W+Y_W+1];
    wire               seeds   = begins_6 && !seeding;
    wire [SUP_W-1:0]   support_next = support_6 + {{(SUP_W - 1) {1'b0}}, !full_6};
    wire               full_next    = &(support_6 | {{(SUP_W - 1) {1'b0}}, 1'b1});
    wire [9:0]         left_next    = left_6 - 10'd1;
    wire [11:0]        left_5       = lefts[slot_5];
    wire               last_next    = left_6 == 10'd2;
    wire               any_next     = !same_5 ? left_5[10] : any_left_6 && !(updates && last_left_6);
    wire [16:0]        far          = visible_5 ? out : {out[15:0], 1'b0};
    wire [16:0]        near         = visible_5 ? back : {back[15:0], 1'b0};
    wire [REL_W-1:0]   rel_x, rel_y;
    reg  [PX_W+REL_W-1:0] middle_x, middle_y;         // of the box that is put in force, half pixels: the lower part counts
    wire [SIDE_W-1:0]  lo_x_6, hi_x_6, lo_y_6, hi_y_6;

    assign read_done  = op_6[0];
    assign store_done = op_6[1];
    assign put_done   = op_6[3];
    assign active     = |valid || |op_1 || |ops || d_valid;
    assign r_sides    = {lo_x_6, hi_x_6, lo_y_6, hi_y_6};
    assign r_support  = support_6;

    function [PX_W+REL_W-1:0] wide;
        input [PX_W-1:0] bound;
        wide = {{REL_W{bound[PX_W-1]}}, bound};
    endfunction

    always @(posedge clk) begin
        owned_5   <= owned_4;
        begins_5  <= begins_4;
        shared_5  <= shared_4;
        visible_5 <= visible[slot_4];
        slot_5    <= slot_4;
        same_5    <= event_5 && owned_5 && slot_4 == slot_5;
        recent_5  <= (updates || op_6[1]) && slot_4 == slot_6;

        takes     <= event_5 && owned_5 && !begins_5;
        updates   <= event_5 && owned_5 && !begins_5 && !shared_5 && any_next;
        begins_6  <= event_5 && owned_5 && begins_5;
        slot_6    <= slot_5;
        if (!same_5 || takes) {full_6, support_6} <= same_5 ? {full_next, support_next} : supports[slot_5];
        if (!same_5 || updates) begin
            {last_left_6, left_6} <= same_5 ? {last_next, left_next} : {left_5[11], left_5[9:0]};
        end
        any_left_6 <= any_next;
        left_op    <= {o_n_ev == 10'd1, o_n_ev != 10'd0, o_n_ev};

        if (takes || op_6[2]) supports[slot_6] <= op_6[2] ? {&o_support, o_support} : {full_next, support_next};
        if (updates || op_6[4])
            lefts[slot_6] <= op_6[4] ? left_op : {last_next, !last_left_6, left_next};
        if (seeds) seeding <= 1'b1;
        if (op_6[5]) seeding <= 1'b0;

        d_valid    <= valid[6];
        d_event    <= event_6;
        d_owned    <= takes || seeds;
        d_corrects <= updates && last_left_6;
        d_seeds    <= seeds;
        d_slot     <= slot_6;
        d_rel_x    <= seeds ? {REL_W{1'b0}} : rel_x;
        d_rel_y    <= seeds ? {REL_W{1'b0}} : rel_y;
        middle_x   <= wide(o_box[3*PX_W+:PX_W]) + wide(o_box[2*PX_W+:PX_W]);
        middle_y   <= wide(o_box[PX_W+:PX_W]) + wide(o_box[0+:PX_W]);
        {d_x, d_y, d_p} <= token_6[X_W+Y_W:0];
        d_time     <= token_6[TOKEN_W-1-:TIME_W];
        d_support  <= support_next;
        d_seq      <= seq;
        if (valid[6] && (event_6 || skip_6)) seq <= seq + {{(SEQ_W - 1) {1'b0}}, 1'b1};
        if (rst) begin
            {takes, updates, begins_6} <= 3'd0;
            seeding <= 1'b0;
            seq     <= {SEQ_W{1'b0}};
            d_valid <= 1'b0;
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
        .update  (updates),
        .store   (op_6[1]),
        .put     (op_6[3]),
        .set_bins(op_6[6]),
        .slot_3  (slot_6),
        .rel     (rel_x),
        .lo      (lo_x_6),
        .hi      (hi_x_6),
        .marks   (r_marks[1:0]),
        .s_lo    (o_sides[3*SIDE_W+:SIDE_W]),
        .s_hi    (o_sides[2*SIDE_W+:SIDE_W]),
        .s_marks (o_marks[1:0]),
        .s_hidden(o_hidden[1:0]),
        .s_middle(middle_x[REL_W-1:0]),
        .s_log2  (o_log2[4:0]),
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
        .update  (updates),
        .store   (op_6[1]),
        .put     (op_6[3]),
        .set_bins(op_6[6]),
        .slot_3  (slot_6),
        .rel     (rel_y),
        .lo      (lo_y_6),
        .hi      (hi_y_6),
        .marks   (r_marks[3:2]),
        .s_lo    (o_sides[SIDE_W+:SIDE_W]),
        .s_hi    (o_sides[0+:SIDE_W]),
        .s_marks (o_marks[3:2]),
        .s_hidden(o_hidden[3:2]),
        .s_middle(middle_y[REL_W-1:0]),
        .s_log2  (o_log2[9:5]),
        .in_bin  (in_bin_y),
        .bin     (bin_y)
    );

    wire unused = &{1'b0, middle_x, middle_y, regs};

    // ---- behind: the bins ------------------------------------------------------------------------------------------------

    reg              count_7, clear_7;
    reg [SLOT_W-1:0] slot_7;

    always @(posedge clk) begin
        count_7     <= updates && counts;
        clear_7     <= op_6[6];
        slot_7      <= slot_6;
        bin_count   <= count_7;
        bin_clear   <= clear_7;
        bin_slot    <= slot_7;
        bin_cleared <= bin_7;
        if (rst) {count_7, clear_7, bin_count, bin_clear} <= 4'd0;
    end

endmodule

`default_nettype wire
