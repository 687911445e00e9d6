// SPDX-License-Identifier: Apache-2.0
// The sequencer of an array with motion: runs the program of motion_program.v on a slot, on both axes at once.
//
// The program seeds and corrects a slot, does a motion step of all, and ends a life. Beside its two lanes the engine has the slot that
// is worked on, `at`, the one that it is compared with, `other`, and which slots are still to be done.
//
// An instruction is fetched in two clocks, then passes the stages of motion_lane.v. A jump takes effect in the last one: it
// takes seven clocks. The program is written such that no instruction needs what is still under way (assembler.py).
//
// Latency:    7 clocks from go to the effect of the first instruction; then as the program needs.
// Throughput: an instruction per clock.
// Stall:      none; the program waits in loops.
// Reset:      all slots are free; waits for a start.
// Combinational paths: none.
`default_nettype none
`include "motion_codes.vh"

module motion_engine #(
    parameter N      = 8,
    parameter SLOT_W = 3,   // bits of a slot number
    parameter W      = 48,  // bits of an accumulator of lane x
    parameter Y_LANE_W = 39,  // and of lane y, in which times are not whole
    parameter TIME_W = 48   // bits of a time, at most W
) (
    input  wire              clk,
    input  wire              rst,

    // start
    input  wire              go,
    input  wire [9:0]        entry,
    input  wire [SLOT_W-1:0] go_slot,
    output reg               busy,        // from the clock after go

    // slots
    output reg  [N-1:0]      visible,
    output reg  [N-1:0]      candidate,
    output reg  [SLOT_W-1:0] at,
    output reg  [SLOT_W-1:0] other,

    // operands: a value two clocks after its index; a word that events change two after its slot, one after its index; 0 if not wanted
    output wire [5:0]        value_index,
    output wire              value_wanted,
    input  wire [W-1:0]      value_x,
    input  wire [W-1:0]      value_y,
    output wire [SLOT_W-1:0] hot_slot,
    output wire [2:0]        hot_index,
    output wire              hot_wanted,
    input  wire [W-1:0]      hot_x,
    input  wire [W-1:0]      hot_y,

    // slots that hold the pixels asked for: on each axis, by box and by window
    input  wire [N-1:0]      box_x,
    input  wire [N-1:0]      box_y,
    input  wire [N-1:0]      window_x,
    input  wire [N-1:0]      window_y,

    // conditions
    input  wire              record_free,
    input  wire              looking,
    input  wire              gap_found,
    input  wire              low_stays,
    input  wire              dividing,

    // what becomes of the accumulators, a clock after the instruction
    output reg               out,
    output reg  [3:0]        place,        // bounds, and places asked for: `out` as well
    output reg  [1:0]        ask,
    output reg               hot_write_x,  // a word that events change
    output reg               hot_write_y,
    output reg  [4:0]        target,       // which one, or what `out` is for
    output reg  [SLOT_W-1:0] out_slot,
    output reg  [W-1:0]      out_x,
    output reg  [W-1:0]      out_y
);

    localparam ADDR_W   = SLOT_W + 5;
    localparam Y_TIME_W = (TIME_W < Y_LANE_W) ? TIME_W : Y_LANE_W;

    // ---- fetching ------------------------------------------------------------------------------------------------------

    reg  [9:0]  pc, pc_fetched, pc_1, pc_2, pc_3, pc_4;
    reg  [9:0]  back, back_2;   // where a part returns to, and where that one does
    reg         fetched, valid_1, valid_2, valid_3;
    wire [`EVCOT_MOTION_WORD_W-1:0] word;
    reg  [`EVCOT_MOTION_WORD_W-1:0] word_1, word_2, word_3;

    motion_program u_program (
        .clk    (clk),
        .address(pc),
        .word   (word)
    );

    // ---- the last stage ------------------------------------------------------------------------------------------------

    reg        loads, shifts, to_left, by_four, inverts, carries, reverses, of_time, sets_acc, sets_flag, from_outside;
    reg        sets_s, stores, hot_stores, outs, calls, returns, picks, takes, swaps, ends, from_flag;
    reg  [3:0] turns;  // the program goes on elsewhere: by both flags
    reg  [1:0] mode, lanes;
    reg        negates;
    reg  [2:0] predicate;
    reg  [9:0] argument;

    wire       flag_x, flag_y, now_x, now_y;
    wire       flush = turns[{flag_y, flag_x}];

    wire [4:0] op = word_3[22:18];
    wire       in_3 = valid_3 && !flush && !rst;

    always @(posedge clk) begin
        if (busy) pc <= pc + 10'd1;
        pc_fetched <= pc;
        pc_1       <= pc_fetched;
        pc_2       <= pc_1;
        pc_3       <= pc_2;
        pc_4       <= pc_3;
        fetched    <= busy;
        valid_1    <= fetched;
        valid_2    <= valid_1;
        valid_3    <= valid_2;
        word_1     <= word;
        word_2     <= word_1;
        word_3     <= word_2;
        case (word_2[22:18])
            `EVCOT_MOTION_OP_SUB, `EVCOT_MOTION_OP_RSB, `EVCOT_MOTION_OP_SUBT,
            `EVCOT_MOTION_OP_LT, `EVCOT_MOTION_OP_LE, `EVCOT_MOTION_OP_LTT: inverts <= 1'b1;
            default: inverts <= 1'b0;
        endcase

        turns <= 4'd0;
        if (in_3)
            case (op)
                `EVCOT_MOTION_OP_CALL, `EVCOT_MOTION_OP_RET, `EVCOT_MOTION_OP_DONE: turns <= 4'b1111;
                `EVCOT_MOTION_OP_J:
                case (word_3[12:10])
                    `EVCOT_MOTION_WHEN_ALWAYS: turns <= 4'b1111;
                    `EVCOT_MOTION_WHEN_X: turns <= 4'b1010;
                    `EVCOT_MOTION_WHEN_NX: turns <= 4'b0101;
                    `EVCOT_MOTION_WHEN_Y: turns <= 4'b1100;
                    `EVCOT_MOTION_WHEN_NY: turns <= 4'b0011;
                    `EVCOT_MOTION_WHEN_ALL: turns <= 4'b1000;
                    `EVCOT_MOTION_WHEN_NALL: turns <= 4'b0111;
                    `EVCOT_MOTION_WHEN_ANY: turns <= 4'b1110;
                endcase
                default: ;
            endcase

        mode      <= word_3[17:16];
        negates   <= word_3[15];
        lanes     <= word_3[14:13];
        predicate <= word_3[12:10];
        argument  <= word_3[9:0];

        loads        <= op == `EVCOT_MOTION_OP_LD;
        shifts       <= op == `EVCOT_MOTION_OP_SHR1 || op == `EVCOT_MOTION_OP_SHR4
                        || op == `EVCOT_MOTION_OP_SHL1 || op == `EVCOT_MOTION_OP_SHL4;
        to_left      <= op == `EVCOT_MOTION_OP_SHL1 || op == `EVCOT_MOTION_OP_SHL4;
        by_four      <= op == `EVCOT_MOTION_OP_SHR4 || op == `EVCOT_MOTION_OP_SHL4;
        carries      <= op == `EVCOT_MOTION_OP_SUB || op == `EVCOT_MOTION_OP_SUBT
                        || op == `EVCOT_MOTION_OP_LT || op == `EVCOT_MOTION_OP_LTT;
        reverses     <= op == `EVCOT_MOTION_OP_RSB;
        of_time      <= op == `EVCOT_MOTION_OP_ADDT || op == `EVCOT_MOTION_OP_SUBT || op == `EVCOT_MOTION_OP_LTT;
        from_outside <= op == `EVCOT_MOTION_OP_FO || op == `EVCOT_MOTION_OP_EXT || op == `EVCOT_MOTION_OP_TAKE;
        from_flag    <= op == `EVCOT_MOTION_OP_FO;
        sets_acc     <= in_3 && op >= `EVCOT_MOTION_OP_LD && op <= `EVCOT_MOTION_OP_SHL4;
        sets_flag    <= in_3 && (op == `EVCOT_MOTION_OP_TAKE || (op >= `EVCOT_MOTION_OP_LT && op <= `EVCOT_MOTION_OP_EXT));
        sets_s       <= in_3 && op == `EVCOT_MOTION_OP_STS;
        stores       <= in_3 && op == `EVCOT_MOTION_OP_ST;
        hot_stores   <= in_3 && op == `EVCOT_MOTION_OP_STH;
        outs         <= in_3 && op == `EVCOT_MOTION_OP_OUT;
        calls        <= in_3 && op == `EVCOT_MOTION_OP_CALL;
        returns      <= in_3 && op == `EVCOT_MOTION_OP_RET;
        picks        <= in_3 && op == `EVCOT_MOTION_OP_PICK;
        takes        <= in_3 && op == `EVCOT_MOTION_OP_TAKE;
        swaps        <= in_3 && op == `EVCOT_MOTION_OP_SWAP;
        ends         <= in_3 && op == `EVCOT_MOTION_OP_DONE;

        if (calls) begin
            back   <= pc_4 + 10'd1;
            back_2 <= back;
        end
        if (returns) back <= back_2;
        if (flush) begin
            pc      <= returns ? back : argument;
            fetched <= 1'b0;
            valid_1 <= 1'b0;
            valid_2 <= 1'b0;
            valid_3 <= 1'b0;
        end
        if (ends) busy <= 1'b0;
        if (go) begin
            busy <= 1'b1;
            pc   <= entry;
        end
        if (rst) begin
            busy    <= 1'b0;
            fetched <= 1'b0;
            valid_1 <= 1'b0;
            valid_2 <= 1'b0;
            valid_3 <= 1'b0;
        end
    end

    // ---- slots ---------------------------------------------------------------------------------------------------------

    reg  [N-1:0]      todo, rest, among, upto;  // in this step; for comparison; of these; up to the lowest one
    reg  [SLOT_W-1:0] found_slot, current;
    reg               found, at_visible, other_visible, owned;
    wire              any_among;
    wire [SLOT_W-1:0] lowest;
    wire [N-1:0]      one = {{(N - 1) {1'b0}}, 1'b1};

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_lowest (
        .asked (busy),
        .among (among),
        .any   (any_among),
        .lowest(lowest)
    );

    always @(posedge clk) begin
        if (picks)
            case (argument[1:0])
                `EVCOT_MOTION_PICK_LIVES: among <= todo & (visible | candidate);
                `EVCOT_MOTION_PICK_PARTNER: among <= rest & (visible | candidate) & (box_x | box_y);
                `EVCOT_MOTION_PICK_TOUCH: among <= rest & candidate & box_x & box_y;
                `EVCOT_MOTION_PICK_HIDE: among <= rest & visible & window_x & window_y;
            endcase
        out         <= outs;
        place       <= {4{outs && argument[4:2] == 3'd0}} & (4'd1 << argument[1:0]);
        ask         <= {outs && argument[4:0] == `EVCOT_MOTION_OUT_ASK_HI, outs && argument[4:0] == `EVCOT_MOTION_OUT_ASK_LO};
        hot_write_x <= hot_stores && now_x;
        hot_write_y <= hot_stores && now_y;
        target      <= argument[4:0];
        out_slot    <= at;
        out_x       <= acc_x;
        out_y       <= {{(W - Y_LANE_W) {1'b0}}, acc_y};

        found         <= any_among;
        found_slot    <= lowest;
        upto          <= among ^ (among - one);
        at_visible    <= visible[at];
        other_visible <= visible[other];
        owned         <= |(visible & window_x & window_y);
        if (takes) begin
            if (argument[0]) begin
                other <= found_slot;
                rest  <= rest & ~upto;
            end else begin
                at      <= found_slot;
                current <= found_slot;
                todo    <= todo & ~upto;
            end
        end
        if (swaps) begin
            at    <= other;
            other <= at;
        end
        if (outs)
            case (argument[4:0])
                `EVCOT_MOTION_OUT_BEGIN: candidate[at] <= 1'b1;
                `EVCOT_MOTION_OUT_BORN: begin
                    visible[at]   <= 1'b1;
                    candidate[at] <= 1'b0;
                end
                `EVCOT_MOTION_OUT_FREE: begin
                    visible[at]   <= 1'b0;
                    candidate[at] <= 1'b0;
                end
                `EVCOT_MOTION_OUT_FREE_OTHER: begin
                    visible[other]   <= 1'b0;
                    candidate[other] <= 1'b0;
                end
                `EVCOT_MOTION_OUT_TODO: todo <= {N{1'b1}};
                `EVCOT_MOTION_OUT_REST: rest <= ~(one << at);
                default: ;
            endcase
        if (go) at <= go_slot;
        if (rst) begin
            visible   <= {N{1'b0}};
            candidate <= {N{1'b0}};
        end
    end

    // ---- lanes ---------------------------------------------------------------------------------------------------------

    wire [ADDR_W-1:0] read_address = {word_1[6] ? other : at, word_1[4:0]};
    wire [W-1:0]      word_x, acc_x;
    wire [Y_LANE_W-1:0] word_y, acc_y;
    reg               condition;

    assign value_index = word_1[5:0];
    assign value_wanted = word_1[9:8] == 2'd2;
    assign hot_slot     = word_1[6] ? other : at;
    assign hot_index    = word_2[2:0];
    assign hot_wanted   = word_2[9:8] == 2'd1;

    always @* begin
        case (argument[3:0])
            `EVCOT_MOTION_EXT_VISIBLE: condition = at_visible;
            `EVCOT_MOTION_EXT_OTHER_VISIBLE: condition = other_visible;
            `EVCOT_MOTION_EXT_OWNED: condition = owned;
            `EVCOT_MOTION_EXT_RECORD_FREE: condition = record_free;
            `EVCOT_MOTION_EXT_LOOKING: condition = looking;
            `EVCOT_MOTION_EXT_GAP_FOUND: condition = gap_found;
            `EVCOT_MOTION_EXT_LOW_STAYS: condition = low_stays;
            `EVCOT_MOTION_EXT_DIVIDING: condition = dividing;
            default: condition = at == current;
        endcase
        if (takes) condition = found;
    end

    motion_lane #(
        .W     (W),
        .TIME_W(TIME_W),
        .ADDR_W(ADDR_W)
    ) u_lane_x (
        .clk          (clk),
        .read_address (read_address),
        .word         (word_x),
        .kind         (word_3[9:8]),
        .from_other   (word_3[7]),
        .other_word   ({{(W - Y_LANE_W) {word_y[Y_LANE_W-1]}}, word_y}),
        .hot          (hot_x),
        .value        (value_x),
        .immediate    (word_3[7:0]),
        .inverts      (inverts),
        .acts         (lanes[0]),
        .predicate    (predicate),
        .sets_acc     (sets_acc),
        .loads        (loads),
        .shifts       (shifts),
        .to_left      (to_left),
        .by_four      (by_four),
        .carries      (carries),
        .reverses     (reverses),
        .of_time      (of_time),
        .sets_flag    (sets_flag),
        .from_outside (from_outside),
        .condition    (from_flag ? flag_y : condition),
        .mode         (mode),
        .negates      (negates),
        .sets_s       (sets_s),
        .stores       (stores),
        .write_address({at, argument[4:0]}),
        .acc          (acc_x),
        .flag         (flag_x),
        .now          (now_x)
    );

    motion_lane #(
        .W     (Y_LANE_W),
        .TIME_W(Y_TIME_W),
        .ADDR_W(ADDR_W)
    ) u_lane_y (
        .clk          (clk),
        .read_address (read_address),
        .word         (word_y),
        .kind         (word_3[9:8]),
        .from_other   (word_3[7]),
        .other_word   (word_x[Y_LANE_W-1:0]),
        .hot          (hot_y[Y_LANE_W-1:0]),
        .value        (value_y[Y_LANE_W-1:0]),
        .immediate    (word_3[7:0]),
        .inverts      (inverts),
        .acts         (lanes[1]),
        .predicate    (predicate),
        .sets_acc     (sets_acc),
        .loads        (loads),
        .shifts       (shifts),
        .to_left      (to_left),
        .by_four      (by_four),
        .carries      (carries),
        .reverses     (reverses),
        .of_time      (of_time),
        .sets_flag    (sets_flag),
        .from_outside (from_outside),
        .condition    (from_flag ? flag_x : condition),
        .mode         (mode),
        .negates      (negates),
        .sets_s       (sets_s),
        .stores       (stores),
        .write_address({at, argument[4:0]}),
        .acc          (acc_y),
        .flag         (flag_y),
        .now          (now_y)
    );

    wire unused = &{1'b0, word_x, hot_y, value_y};

endmodule

`default_nettype wire
