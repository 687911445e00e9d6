// SPDX-License-Identifier: Apache-2.0
// The pipeline in which events are decided, and what they change of their owners.
//
// A token passes six stages: its place, the slots that it hits, those of the kind that decides, its owner, its owner's words and
// its time, and what becomes of it. There it is done, or it must wait: for a motion step, or until a candidate has been seeded where it
// lies. Then the engine works, as it does after the last event of a correction; all tokens behind are issued again when it is done.
// An event waits in the fourth stage while one of its owner is in the fifth or sixth, or being written in a seventh.
//
// Latency:    6 clocks from issue to done.
// Throughput: a token per clock; of one owner every fourth clock.
// Stall:      m_ready is low while no token may be issued.
// Reset:      nothing is under way.
// Combinational paths: may_issue -> s_ready; write_slot, used_x and used_y -> busy.
`default_nettype none
`include "motion_codes.vh"

module motion_events #(
    parameter N      = 8,
    parameter SLOT_W = 3,
    parameter X_W    = 9,
    parameter Y_W    = 9,
    parameter SIDE_W = 25,   // bits of a side
    parameter OFF_W  = 30,   // bits of an offset
    parameter PX_W   = 13,   // bits of a bound in pixels
    parameter REL_W  = 10,   // bits of a recentred address
    parameter SUP_W  = 16,   // bits of a support count
    parameter TIME_W = 48,
    parameter W      = 48    // bits of the engine's words
) (
    input  wire              clk,
    input  wire              rst,

    // tokens: see motion_queue.v
    input  wire              may_issue,
    input  wire              s_valid,
    output wire              s_ready,
    input  wire [3:0]        s_index,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    output wire [3:0]        index,
    input  wire [TIME_W-1:0] event_time,
    input  wire              is_event,
    input  wire              is_skip,
    input  wire [X_W-1:0]    x,
    input  wire [Y_W-1:0]    y,
    input  wire              p,

    // registers and slots
    input  wire [15:0]       out,
    input  wire [15:0]       back,
    input  wire              counts,      // events are counted in bins
    input  wire [TIME_W-1:0] next_step,
    input  wire [N-1:0]      visible,
    input  wire [N-1:0]      candidate,
    input  wire [N-1:0]      may_begin,

    // what becomes of a token
    output wire              done,
    output wire              steps,       // a motion step is due before it
    output wire              seeds,       // a candidate begins
    output wire              corrects,    // done, and a correction follows
    output wire              active,      // a token is in a stage
    output reg               done_event,
    output reg               done_skip,
    output reg               done_owned,
    output reg  [SLOT_W-1:0] done_slot,
    output reg  [TIME_W-1:0] done_time,
    output reg  [X_W-1:0]    done_x,
    output reg  [Y_W-1:0]    done_y,
    output reg               done_p,
    output wire [REL_W-1:0]  done_rel_x,
    output wire [REL_W-1:0]  done_rel_y,

    // to the bins
    output reg               bin_count,
    output reg  [SLOT_W-1:0] bin_slot,
    output wire              in_bin_x,
    output wire              in_bin_y,
    output wire [3:0]        bin_x,
    output wire [3:0]        bin_y,
    output wire              first_x,     // a clock later
    output wire              first_y,
    output wire [15:0]       used_x,      // bins of the engine's slot
    output wire [15:0]       used_y,

    // the engine, while no token is in a stage
    input  wire              busy,
    input  wire [SLOT_W-1:0] hot_slot,
    input  wire [2:0]        hot_index,
    input  wire              hot_wanted,  // else 0
    output wire [W-1:0]      hot_x,
    output wire [W-1:0]      hot_y,
    input  wire              write_x,
    input  wire              write_y,
    input  wire [SLOT_W-1:0] write_slot,
    input  wire [3:0]        target,
    input  wire [W-1:0]      acc_x,
    input  wire [W-1:0]      acc_y,
    input  wire [3:0]        place,       // a bound: see motion_match.v
    input  wire              ask_lo,
    input  wire              ask_hi,
    output wire [N-1:0]      box_x,
    output wire [N-1:0]      box_y,
    output wire [N-1:0]      window_x,
    output wire [N-1:0]      window_y
);

    // ---- whose is it? ------------------------------------------------------------------------------------------------

    reg  [4:1]        valid;   // stages
    reg  [3:0]        index_1, index_2, index_3, index_4;
    reg  signed [PX_W-1:0] lo_x, hi_x, lo_y, hi_y;
    wire              owned, begins, shared;
    wire [SLOT_W-1:0] owner;

    reg               valid_5, event_5, skip_5, owned_5, begins_5, shared_5, p_5;
    reg  [SLOT_W-1:0] slot_5;
    reg  [TIME_W-1:0] time_5;
    reg  [X_W-1:0]    x_5;
    reg  [Y_W-1:0]    y_5;
    reg               writes_7, updates_7;
    reg  [SLOT_W-1:0] slot_7;
    reg               valid_6, due_6, begins_6, shared_6, full_6;

    wire hold = valid[4] && owned
             && ((valid_5 && owned_5 && slot_5 == owner) || (valid_6 && done_owned && done_slot == owner) || (writes_7 && slot_7 == owner));
    wire flush = valid_6 && (due_6 || begins_6 || full_6);

    assign s_ready = may_issue && !hold;
    assign index   = index_4;
    assign active  = |valid || valid_5 || valid_6;

    motion_match #(
        .N     (N),
        .PX_W  (PX_W),
        .SLOT_W(SLOT_W)
    ) u_match (
        .clk       (clk),
        .hold      (hold),
        .lo_x      (lo_x),
        .hi_x      (hi_x),
        .lo_y      (lo_y),
        .hi_y      (hi_y),
        .visible   (visible),
        .candidate (candidate),
        .may_begin (may_begin),
        .place     (place),
        .place_slot(write_slot),
        .bound_x   (acc_x[PX_W-1:0]),
        .bound_y   (acc_y[PX_W-1:0]),
        .box_x     (box_x),
        .box_y     (box_y),
        .window_x  (window_x),
        .window_y  (window_y),
        .owned     (owned),
        .begins    (begins),
        .shared    (shared),
        .owner     (owner)
    );

    always @(posedge clk) begin
        if (!hold) begin
            valid   <= {valid[3:1], s_valid && may_issue};
            index_1 <= s_index;
            index_2 <= index_1;
            index_3 <= index_2;
            index_4 <= index_3;
        end
        if (!hold && !busy) begin
            {lo_x, hi_x} <= {2{{{(PX_W - X_W) {1'b0}}, s_x}}};
            {lo_y, hi_y} <= {2{{{(PX_W - Y_W) {1'b0}}, s_y}}};
        end
        if (ask_lo) {lo_x, lo_y} <= {acc_x[PX_W-1:0], acc_y[PX_W-1:0]};
        if (ask_hi) {hi_x, hi_y} <= {acc_x[PX_W-1:0], acc_y[PX_W-1:0]};
        if (flush || rst) valid <= 4'd0;
    end

    // ---- its owner's words -------------------------------------------------------------------------------------------

    reg  [SUP_W-1:0]  supports[0:(1<<SLOT_W)-1];
    reg  [9:0]        nevs    [0:(1<<SLOT_W)-1];
    reg  [9:0]        numbers [0:(1<<SLOT_W)-1];  // events since the last correction
    reg  [SUP_W-1:0]  support_5, support_6;
    reg  [9:0]        nev_5, number_5, number_6;   // n_ev less one
    wire [10:0]       under_nev = {1'b0, number_5} - {1'b0, nev_5};
    wire [SLOT_W-1:0] slot = busy ? hot_slot : owner;
    wire [TIME_W-1:0] until_step = time_5 - next_step;
    wire [W-1:0]      word_x, word_y;

    wire takes   = done && done_owned;
    wire updates = takes && !shared_6;
    wire [SUP_W-1:0] support_next = &support_6 ? support_6 : support_6 + {{(SUP_W - 1) {1'b0}}, 1'b1};
    wire writes_support = write_x && target == `EVCOT_MOTION_HOT_SUPPORT;
    wire writes_nev     = write_x && target == `EVCOT_MOTION_HOT_N_EV;
    wire writes_bins    = write_x && target == `EVCOT_MOTION_HOT_BINS;
    wire [SLOT_W-1:0] to = !busy ? done_slot : write_slot;

    reg  [W-1:0] scalar;
    wire [W-1:0] read_scalar = ({1'b0, hot_index} == `EVCOT_MOTION_HOT_SUPPORT ? {{(W - SUP_W) {1'b0}}, support_5} : {W{1'b0}})
                        | ({1'b0, hot_index} == `EVCOT_MOTION_HOT_N_EV ? {{(W - 10) {1'b0}}, nev_5} : {W{1'b0}});
    assign hot_x = word_x | scalar;
    assign hot_y = word_y | scalar;

    assign steps    = valid_6 && due_6;
    assign seeds    = valid_6 && !due_6 && begins_6;
    assign done     = valid_6 && !due_6 && !begins_6;
    assign corrects = done && full_6;

    always @(posedge clk) begin
        scalar    <= hot_wanted ? read_scalar : {W{1'b0}};
        valid_5   <= valid[4] && !hold;
        event_5   <= is_event;
        skip_5    <= is_skip;
        owned_5   <= is_event && owned;
        begins_5  <= begins;
        shared_5  <= shared;
        slot_5    <= owner;
        time_5    <= event_time;
        {x_5, y_5, p_5} <= {x, y, p};
        support_5 <= supports[slot];
        nev_5     <= nevs[slot];
        number_5  <= numbers[slot];

        valid_6    <= valid_5;
        due_6      <= !until_step[TIME_W-1];
        begins_6   <= owned_5 && begins_5;
        shared_6   <= shared_5;
        full_6     <= owned_5 && !shared_5 && !begins_5 && !under_nev[10];
        support_6  <= support_5;
        number_6   <= number_5;
        done_event <= event_5;
        done_skip  <= skip_5;
        done_owned <= owned_5;
        done_slot  <= slot_5;
        done_time  <= time_5;
        {done_x, done_y, done_p} <= {x_5, y_5, p_5};

        if (takes || writes_support) supports[to] <= !busy ? support_next : acc_x[SUP_W-1:0];
        if (updates || writes_nev) numbers[to] <= !busy ? number_6 + 10'd1 : 10'd0;
        if (writes_nev) nevs[write_slot] <= acc_x[9:0];

        if (flush || rst) begin
            valid_5 <= 1'b0;
            valid_6 <= 1'b0;
        end
    end

    // ---- on each axis --------------------------------------------------------------------------------------------------

    wire        still = visible[slot_5];
    wire [16:0] far   = still ? {1'b0, out} : {out, 1'b0};
    wire [16:0] near  = still ? {1'b0, back} : {back, 1'b0};

    motion_axis_memory #(
        .SLOT_W(SLOT_W),
        .AT_W  (X_W),
        .SIDE_W(SIDE_W),
        .OFF_W (OFF_W),
        .PX_W  (PX_W),
        .REL_W (REL_W),
        .W     (W)
    ) u_x (
        .clk        (clk),
        .slot       (slot),
        .index      (hot_index),
        .wanted     (hot_wanted),
        .word       (word_x),
        .place      (x_5),
        .out        (far),
        .back       (near),
        .update     (updates_7),
        .update_slot(slot_7),
        .rel        (done_rel_x),
        .in_bin     (in_bin_x),
        .bin        (bin_x),
        .busy       (busy),
        .write      (write_x),
        .write_slot (write_slot),
        .target     (target),
        .data       (acc_x)
    );

    motion_axis_memory #(
        .SLOT_W(SLOT_W),
        .AT_W  (Y_W),
        .SIDE_W(SIDE_W),
        .OFF_W (OFF_W),
        .PX_W  (PX_W),
        .REL_W (REL_W),
        .W     (W)
    ) u_y (
        .clk        (clk),
        .slot       (slot),
        .index      (hot_index),
        .wanted     (hot_wanted),
        .word       (word_y),
        .place      (y_5),
        .out        (far),
        .back       (near),
        .update     (updates_7),
        .update_slot(slot_7),
        .rel        (done_rel_y),
        .in_bin     (in_bin_y),
        .bin        (bin_y),
        .busy       (busy),
        .write      (write_y),
        .write_slot (write_slot),
        .target     (target),
        .data       (acc_y)
    );

    // ---- which bins were used --------------------------------------------------------------------------------------------

    reg  [31:0] uses[0:(1<<SLOT_W)-1];
    reg  [31:0] used_9;
    reg  [3:0]  bin_x_9, bin_y_9;
    reg         counts_7;
    wire [SLOT_W-1:0] use_slot = busy && !bin_count ? write_slot : bin_slot;
    wire [31:0] use_now = uses[use_slot];
    assign {used_y, used_x} = use_now;
    assign first_x = !used_9[{1'b0, bin_x_9}];
    assign first_y = !used_9[{1'b1, bin_y_9}];

    always @(posedge clk) begin
        writes_7  <= takes;
        updates_7 <= updates;
        slot_7    <= done_slot;
        counts_7  <= updates && counts;
        bin_count <= counts_7;
        bin_slot  <= slot_7;
        used_9    <= use_now;
        bin_x_9   <= bin_x;
        bin_y_9   <= bin_y;
        if (bin_count || writes_bins)
            uses[use_slot] <= writes_bins ? 32'd0
                : use_now | {in_bin_y ? 16'd1 << bin_y : 16'd0, in_bin_x ? 16'd1 << bin_x : 16'd0};
        if (rst) {writes_7, updates_7, counts_7, bin_count} <= 4'd0;
    end

    wire unused = &{1'b0, under_nev};

endmodule

`default_nettype wire
