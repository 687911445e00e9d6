// SPDX-License-Identifier: Apache-2.0
// A motion step of a slot, or the end of its life, in order: what the other parts of motion_work.v do, and when. Two slots that become
// one are handed to motion_merge.v.
//
// Commands to motion_sides.v are given while its `lane` is high: an even number of clocks after the slot was read.
//
// Latency:    from start to done 20 clocks for a slot whose track may return, 46 for a candidate, 51 or 56 if it appears. A visible slot
//             takes 41 if no division is longer. To these, each other slot that is not free adds a clock, a side that is too long 5.
//             Each slot that is compared adds 30, the first one 4 more. hw/formal/motion_step.vh has all bounds.
// Throughput: one at a time.
// Stall:      waits for its records to be accepted, and for masks of the window before to be written.
// Reset:      waits for a start.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

module motion_step #(
    parameter N      = 8,
    parameter SLOT_W = 3
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              start,        // a motion step of work_slot, which is not free, while nothing else is done
    input  wire              end_life,     // with it: its life ends at once
    input  wire [SLOT_W-1:0] work_slot,
    output reg               rests,
    output reg               done,
    output reg  [SLOT_W-1:0] at,           // the slot that is worked on, or compared
    output wire [SLOT_W-1:0] this_slot,    // the one whose step it is

    output reg               fetch,        // the slot `at` is read,
    input  wire              read_done,    // and was

    // merging: see motion_merge.v
    output reg               merge,
    output reg  [SLOT_W-1:0] goes,
    input  wire              merged,

    // what decides
    input  wire [1:0]        at_state,     // of `at`, two clocks late: free, candidate, visible, left
    input  wire [N-1:0]      left,         // lost, but it may return
    input  wire [N-1:0]      settled,      // four corrections are behind it; only of slots that are not free this counts
    input  wire [5:0]        corrections,
    input  wire              meets,        // the slot meets another
    input  wire              silent,
    input  wire              ended,
    input  wire              older,
    input  wire              dividing,
    input  wire              enough,
    input  wire              overdue,
    input  wire              too_long,     // an axis was: x a clock behind c_shorten, y in the next one
    input  wire              window_soon,  // in two clocks it is
    input  wire              window_done,
    input  wire              mask_busy,    // the window of another slot is still being written to masks, and must stay
    input  wire              pair_done,
    input  wire              alike,
    input  wire              weaker,       // than the one that was read, two clocks before
    input  wire              keep_older,
    input  wire              meet_done,
    input  wire [N-1:0]      nearby,       // the slot can be one object with these alone
    input  wire              held,
    input  wire              touches,
    input  wire [SLOT_W-1:0] touched,
    input  wire              appears,
    input  wire              returns,      // as this one, which has left
    input  wire [SLOT_W-1:0] returned,
    input  wire              may_return,   // what is lost
    input  wire              record_free,

    // commands
    output wire              load,         // the slot is being read: it is loaded
    output reg               c_reflect,
    output reg               c_move,
    output reg               c_rub,
    output reg               c_shorten,
    output reg               c_window,
    output reg               c_follow,     // with it: the stated velocity
    output reg               widest,       // that window is for what may return
    output reg               c_compare,
    output reg               c_pair,
    output reg               c_part,
    output reg               c_take,
    output reg               c_divide,
    output reg               by_life,      // a step's length, and 2^join_life
    output reg               c_ask,
    output reg               c_touch,
    output reg               c_meet,
    output reg               appear,
    output wire              resume,       // with it: as what has left
    output reg               lapse,
    output reg               leave,        // with it: it may return
    output reg               c_leave,      // and has its time
    output wire              ask_start,    // where it was at the fourth correction is read, and not its id
    output reg               say,          // the record is taken
    output reg  [1:0]        kind,
    output reg  [1:0]        since,        // see motion_times.v
    output reg               keep,
    output reg               keep_now,
    output reg               keep_until,
    output reg               keep_window
);

    localparam [1:0] LAST     = 2'd0;
    localparam [1:0] SEEDED   = 2'd1;
    localparam [1:0] REPORTED = 2'd2;

    localparam [1:0] VISIBLE = 2'd2;   // states of slots
    localparam [1:0] LEFT    = 2'd3;

    localparam [4:0] REST    = 5'd0;   // waits for a start
    localparam [4:0] AGE     = 5'd3;   // has its life ended?
    localparam [4:0] FETCHED = 5'd4;
    localparam [4:0] AGED    = 5'd5;
    localparam [4:0] MOVE    = 5'd6;   // moves it
    localparam [4:0] LONG    = 5'd7;   // where it is too long, it is shortened
    localparam [4:0] LENGTH  = 5'd2;   // then what has changed is noted
    localparam [4:0] PLACE   = 5'd8;   // box and window
    localparam [4:0] WINDOW  = 5'd9;   // waits for them
    localparam [4:0] SCAN    = 5'd10;  // compares it with those near: the next one
    localparam [4:0] COMPARE = 5'd11;  // reads that one
    localparam [4:0] PAIR    = 5'd12;
    localparam [4:0] FOUND   = 5'd13;
    localparam [4:0] YOUNGER = 5'd14;  // they are alike: which is younger?
    localparam [4:0] OLDER   = 5'd15;
    localparam [4:0] LIVED   = 5'd16;  // how long has it lived, in steps?
    localparam [4:0] STEPS   = 5'd17;
    localparam [4:0] MEET    = 5'd18;  // which boxes and windows does it touch?
    localparam [4:0] SINCE   = 5'd19;  // how long ago was its last record, or its seed?
    localparam [4:0] MET     = 5'd20;
    localparam [4:0] TOUCH   = 5'd21;  // a candidate touches another one, which is read
    localparam [4:0] TOUCHED = 5'd22;
    localparam [4:0] UNITE   = 5'd23;
    localparam [4:0] MERGE   = 5'd24;  // waits until two have become one
    localparam [4:0] REPORT  = 5'd25;  // is it time for a record?
    localparam [4:0] BORN    = 5'd26;  // becomes visible; as a track that was lost, whose slot becomes free
    localparam [4:0] SAY     = 5'd27;  // hands over a record
    localparam [4:0] LAPSE   = 5'd28;  // the slot becomes free
    localparam [4:0] DONE    = 5'd29;  // writes the slot back
    localparam [4:0] DECIDE  = 5'd1;   // what becomes of it, by what it touches

    reg [4:0] state;
    reg [6:0]        pause;          // a one for each clock until the state is gone on with
    reg [SLOT_W-1:0] slot;           // whose step it is
    reg [SLOT_W-1:0] this_other;     // with which it is compared
    reg              alone;          // a life ends, not in a step
    reg              over, again;    // its time is over; its box has grown since it was first compared
    reg              back;           // it is a track that was lost
    reg              touching;       // a candidate was united with another one, not with its partner
    reg              shortened, other_older;
    reg              too_long_x;     // too_long, a clock later
    reg [2:0]        places;         // box and window are asked for, when what follows from the lengths is there
    reg              reads;          // the slot whose step it is, is being read
    reg  [N-1:0]     ahead;          // those near with which it may be compared, and was not
    wire             any_ahead;
    wire [SLOT_W-1:0] next_ahead;
    reg              compared;       // it was, with all of them or with its partner
    reg              is_visible;     // the slot whose step it is,
    reg              young;          // and it has less than four corrections
    reg              other_visible;  // the one that it is compared with
    reg              stays;          // what may return has done so before: its time is not changed
    wire             goes_on    = !pause[0];
    reg              departs;        // what is lost in a step may return
    wire             leaves     = kind == `EVCOT_KIND_LOST && departs;  // with the record

    assign this_slot = slot;
    assign load      = reads;
    assign resume    = appear && back;
    assign ask_start = state == DECIDE || (state == BORN && !back);

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_next (
        .asked (state == SCAN),
        .among (ahead),
        .any   (any_ahead),
        .lowest(next_ahead)
    );

    // As many ones as clocks until the state is gone on with.
    function [6:0] clocks;
        input [2:0] number;
        clocks = ~(7'h7f << number);
    endfunction

    always @(posedge clk) begin
        {c_reflect, c_move, c_rub, c_shorten, c_compare, c_pair, c_part, c_take, c_divide} <= 9'd0;
        {c_window, places} <= {places, 1'b0};
        c_follow <= places[2] && !widest && (is_visible || !young);
        {c_ask, c_meet, merge, appear, lapse, leave, c_leave, say, keep, keep_now, keep_until, keep_window} <= 12'd0;
        {fetch, done} <= 2'b00;
        shortened <= c_shorten;
        if (shortened) c_reflect <= 1'b1;
        too_long_x <= too_long;
        departs    <= may_return && !alone;
        young      <= corrections < 6'd4;

        pause <= {1'b0, pause[6:1]};
        if (goes_on) case (state)
            REST: begin
                alone    <= end_life;
                at       <= work_slot;
                since    <= LAST;
                stays    <= 1'b0;
                compared <= 1'b0;
                widest   <= 1'b0;
                back     <= 1'b0;
                if (start) begin
                    rests <= 1'b0;
                    reads <= 1'b1;
                    pause <= clocks(3'd2);
                    state <= AGE;
                end
            end
            AGE: begin
                over       <= ended;
                is_visible <= at_state == VISIBLE;
                state <= FETCHED;
            end
            FETCHED:
            if (read_done) begin
                c_reflect <= 1'b1;
                reads     <= 1'b0;
                state     <= AGED;
            end
            AGED: begin
                kind      <= `EVCOT_KIND_LOST;
                pause     <= clocks(!over && !alone ? 3'd2 : 3'd4);  // how long it has been silent; the record
                state     <= !over && !alone ? MOVE : is_visible ? SAY : LAPSE;
                c_leave   <= 1'b1;  // of use if it leaves
                if (!over && !alone && at_state == LEFT) begin
                    pause  <= 7'd0;
                    stays  <= 1'b1;
                    widest <= 1'b1;
                    state  <= PLACE;
                end
            end
            LAPSE: begin
                lapse <= 1'b1;
                pause <= clocks(3'd2);
                state <= DONE;
            end

            MOVE: begin
                c_move <= is_visible || !young;
                c_rub  <= (is_visible || !young) && !meets && silent;
                pause  <= clocks(3'd5);
                state  <= LONG;
            end
            LONG: begin
                c_shorten <= 1'b1;
                pause     <= clocks(3'd2);
                state     <= LENGTH;
            end
            LENGTH:
            if (too_long_x || too_long) begin
                pause <= clocks(3'd4);
                state <= PLACE;
            end else if (!mask_busy) begin
                places[0] <= 1'b1;
                state     <= WINDOW;
            end
            PLACE:
            if (!mask_busy) begin
                places[0] <= 1'b1;
                state     <= WINDOW;
            end
            WINDOW: begin
                again   <= 1'b0;
                c_ask   <= window_soon && !widest;
                c_touch <= 1'b1;
                if (window_done) begin
                    keep_window <= !stays;  // a slot that stays left keeps box and window, although events have moved its sides
                    since       <= is_visible ? REPORTED : SEEDED;
                    pause       <= clocks(3'd2);
                    state       <= SINCE;
                    if (widest) begin
                        lapse      <= !stays;
                        leave      <= 1'b1;
                        keep_until <= !stays;
                        state      <= DONE;
                    end
                end
            end

            SCAN: begin
                at         <= any_ahead ? next_ahead : this_slot;
                this_other <= next_ahead;
                ahead      <= ahead & (ahead - {{(N - 1) {1'b0}}, 1'b1});
                state      <= any_ahead ? COMPARE : DECIDE;
                if (!any_ahead) begin
                    c_part <= 1'b1;
                    since  <= is_visible ? REPORTED : SEEDED;
                    pause  <= at == this_slot ? 7'd0 : clocks(3'd4);
                end
            end
            COMPARE: begin
                fetch <= 1'b1;
                state <= PAIR;
            end
            PAIR:
            if (read_done) begin
                c_compare <= 1'b1;
                state     <= FOUND;
            end
            FOUND:
            if (pair_done) begin
                c_pair <= alike;
                other_visible <= at_state == VISIBLE;
                since  <= SEEDED;
                pause  <= alike ? clocks(3'd3) : 7'd0;
                state  <= alike ? YOUNGER : SCAN;
            end
            YOUNGER: begin
                c_take <= 1'b1;
                at     <= this_slot;
                pause  <= clocks(3'd5);
                state  <= OLDER;
            end
            OLDER: begin
                other_older <= older;
                state       <= LIVED;
            end
            LIVED: begin
                c_take   <= other_older;
                c_divide <= 1'b1;
                by_life  <= 1'b1;
                pause    <= clocks(3'd1);
                state    <= STEPS;
            end
            STEPS:
            if (!dividing) begin
                touching <= 1'b0;
                goes     <= this_other;
                state    <= MEET;
                if (enough && !(is_visible != other_visible ? other_visible : keep_older ? other_older : weaker)) begin
                    merge <= 1'b1;
                    state <= MERGE;
                end
            end

            MEET: begin
                c_ask   <= 1'b1;
                c_touch <= 1'b1;
                again   <= 1'b0;
                since   <= is_visible ? REPORTED : SEEDED;
                pause   <= clocks(3'd2);
                state   <= SINCE;
            end
            SINCE: begin
                c_take   <= is_visible;
                c_divide <= is_visible;
                by_life  <= 1'b0;
                state    <= MET;
            end
            MET: begin
                ahead <= young ? {N{1'b0}} : settled & nearby & ~left;
                if (meet_done) begin
                    compared <= 1'b1;
                    state    <= compared ? DECIDE : SCAN;
                end
            end
            DECIDE: begin
                this_other <= touched;
                c_meet     <= is_visible;
                if (is_visible) state <= REPORT;
                else if (held && !again) state <= LAPSE;
                else if (touches) begin
                    at    <= touched;
                    state <= TOUCH;
                end else begin
                    pause <= clocks(3'd5);
                    state <= BORN;
                end
            end
            TOUCH: begin
                fetch <= 1'b1;
                state <= TOUCHED;
            end
            TOUCHED:
            if (read_done) begin
                at    <= this_slot;
                pause <= clocks(3'd1);
                state <= UNITE;
            end
            UNITE: begin
                touching <= 1'b1;
                goes     <= this_other;
                merge    <= !weaker;
                state    <= weaker ? DONE : MERGE;
            end
            MERGE:
            if (merged) begin
                since   <= SEEDED;
                again   <= 1'b1;
                c_touch <= 1'b0;
                c_ask   <= touching;
                state   <= touching ? MET : MEET;
            end
            REPORT:
            if (!dividing) begin
                kind  <= `EVCOT_KIND_MOVED;
                state <= overdue ? SAY : DONE;
            end
            BORN: begin
                kind <= back ? `EVCOT_KIND_MOVED : `EVCOT_KIND_BORN;
                if (back && at != this_slot) begin
                    lapse <= 1'b1;
                    at    <= this_slot;
                end else if (back || (appears && !returns)) begin
                    appear <= 1'b1;
                    pause  <= clocks(3'd4);
                    state  <= SAY;
                end else if (appears) begin
                    back  <= 1'b1;
                    at    <= returned;
                    pause <= clocks(3'd3);
                end else state <= DONE;
            end
            SAY:
            if (record_free) begin
                say       <= 1'b1;
                since     <= REPORTED;
                keep_now  <= 1'b1;
                widest    <= leaves;
                state     <= kind != `EVCOT_KIND_LOST ? DONE : leaves ? PLACE : LAPSE;
            end

            DONE: begin
                keep  <= 1'b1;
                done  <= 1'b1;
                rests <= 1'b1;
                state <= REST;
            end
            default: state <= REST;
        endcase

        // Where they begin: not in a state, so that a reset of a flip-flop need not wait for what decides there.
        if (rests) slot <= work_slot;

        if (rst) begin
            state    <= REST;
            rests    <= 1'b1;
            pause    <= 7'd0;
            reads    <= 1'b0;
            places   <= 3'd0;
        end
    end

endmodule

`default_nettype wire
