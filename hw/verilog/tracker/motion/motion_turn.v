// SPDX-License-Identifier: Apache-2.0
// What comes next: a token, an operation, a slot that is put in force, a motion step, or the end of a life; and the registers that say so,
// `mode` of each slot and when steps are: one slot at a time, spread over a period of 2^step_log2 ticks.
//
// An operation comes before a slot that is put in force, and that before a token. A step waits until nothing is under way, and all that
// waits is in force; so does the end of a life, which comes first.
//
// Latency:    1 clock from d_valid to now; 4 from a write of `mode` to the end of its slot's life, 4 from a change of step_log2 to next_step.
// Throughput: one of them per clock; behind an operation that writes, and behind a slot that is put in force, one is left out.
// Stall:      a step and the end of a life wait for `drained`.
// Reset:      turns all slots off; the first step is slot 0's, at 2^step_log2.
// Combinational paths: op_valid -> takes_op; op_valid, reached, put_valid, q_due -> takes_put; op_beside, reached,
//             q_runs and q_counts -> takes_token, and issues; put_slot -> puts_slot; reached -> quiet.
`default_nettype none
`include "evcot_defs.vh"

module motion_turn #(
    parameter N      = 8,
    parameter SLOT_W = 3,
    parameter TIME_W = 48
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              cfg_valid,
    input  wire [SLOT_W-1:0] cfg_slot,
    input  wire [`EVCOT_MREG_W-1:0] cfg_addr,
    input  wire [4:0]        cfg_data,
    input  wire [4:0]        step_log2,
    output reg  [N-1:0]      seeded,       // `mode`

    // tokens: see motion_queue.v
    input  wire              q_due,        // there is one, and a motion step comes before it
    input  wire              q_runs,       // there is one, and none does
    input  wire              q_event,      // it is an event, not taken out by a filter
    input  wire              q_counts,     // it is an event, or one that a filter took out
    input  wire              room,         // for those under way and two more: it is seen a clock later
    output wire              takes_token,
    output reg               holds,        // a motion step is under way: next_step changes, and no token is taken
    output wire              issues,       // a token that counts comes in this clock
    output reg  [7:0]        issued,       // lower bits of the number of the next one
    output reg  [7:0]        following,    // those of the one behind it
    input  wire              d_valid,      // a token is done
    input  wire [TIME_W-1:0] d_time,
    output reg  [TIME_W-1:0] now,
    output wire [TIME_W-1:0] next_step,
    output reg  [TIME_W-1:0] paused,       // the length of all empty periods that do not count for deadlines

    // operations
    input  wire              op_valid,
    input  wire              op_beside,    // one beside events, not within a step
    input  wire              op_writes,
    output wire              op_ready,     // whether there is one or not
    output wire              takes_op,

    // slots that are put in force: see motion_waiting.v
    input  wire              reached,
    input  wire              put_valid,
    input  wire [SLOT_W-1:0] put_slot,
    output wire              takes_put,
    input  wire              put_done,
    output wire [SLOT_W-1:0] puts_slot,    // which is, or will be next

    // work
    input  wire              active,       // a token or an operation is under way
    input  wire              waits_none,
    input  wire              rests,
    output wire              steps,
    output wire              ends_life,
    output wire [SLOT_W-1:0] work_slot,    // whose step it is, or whose life ends

    output wire              quiet         // nothing of this is under way
);

    localparam [31:0] LAST = N - 1;

    localparam [1:0] RUN   = 2'd0;
    localparam [1:0] BEGUN = 2'd1;  // a step, or the end of a life
    localparam [1:0] BUSY  = 2'd2;
    localparam [1:0] DUE   = 2'd3;  // the queue sees whether another step is due

    reg  [1:0]        state;
    reg               came;       // an event, in this period
    reg  [5:0]        empty;      // periods in a row without one, at most 32
    reg               bubble;     // an operation that writes was before
    reg               put_busy;   // a slot is being put in force,
    reg  [SLOT_W-1:0] putting;    // this one
    reg               drained;
    reg               open;       // a token may come: there is room, no bubble, and no life must end
    reg  [N-1:0]      restart;    // `mode` was written
    reg               restarts, must_end;
    reg               restep_1, restep_2, restep_3, restep;  // step_log2 changes, or reset: the next step is set
    reg  [19:0]       step_mask;  // from a multiple of a period's length, or a time behind it, to the last tick before the next one
    reg  [SLOT_W-1:0] step_slot, end_slot;
    reg               last_slot;  // the next step is the last one of a period
    reg  [TIME_W+SLOT_W-1:0] step_at;  // its tick, in parts of 2^-SLOT_W: from one slot's step to the next one's are 2^step_log2
    reg               wrote, wrote_seeded;  // `mode` was written, in the clock before
    reg  [SLOT_W-1:0] wrote_slot;
    wire              any_restart;
    wire [SLOT_W-1:0] lowest_restart;
    reg  [TIME_W+SLOT_W-1:0] step_end;  // the last part before the next step but one, or with `restep` before the next
    wire [TIME_W+SLOT_W-1:0] until_step = last_slot ? {{(TIME_W - 20) {1'b0}}, step_mask, {SLOT_W{1'b1}}}
                                                    : {{(TIME_W + SLOT_W - 20) {1'b0}}, step_mask};
    wire              stop      = must_end || q_due;  // all that waits comes first
    wire              starts    = drained;                         // which it has: nothing can have come since

    assign op_ready    = !bubble;
    assign takes_op    = op_valid && op_ready;
    assign takes_put   = !op_valid && !bubble && put_valid && !put_busy && (reached || stop);
    assign takes_token = open && !op_beside && !reached && q_runs;
    assign issues      = takes_token && q_counts;
    assign ends_life   = starts && must_end;
    assign steps       = starts && !must_end;
    assign next_step   = step_at[SLOT_W+:TIME_W];
    assign work_slot   = must_end ? end_slot : step_slot;
    assign puts_slot   = put_busy ? putting : put_slot;
    assign quiet       = state == RUN && !reached && !put_busy && !wrote && !any_restart && !restarts && !must_end
                      && !restep_1 && !restep_2 && !restep_3 && !restep;

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_restart (
        .asked (any_restart),
        .among (restart),
        .any   (any_restart),
        .lowest(lowest_restart)
    );

    always @(posedge clk) begin
        wrote        <= cfg_valid && cfg_addr == `EVCOT_MREG_MODE && !rst;
        wrote_slot   <= cfg_slot;
        wrote_seeded <= cfg_data[1:0] == `EVCOT_MODE_SEEDED;
    end

    wire [N-1:0] one    = {{(N - 1) {1'b0}}, 1'b1};
    wire [N-1:0] writes = wrote ? one << wrote_slot : {N{1'b0}};
    wire [N-1:0] ends   = ends_life ? one << end_slot : {N{1'b0}};

    always @(posedge clk) begin
        seeded  <= wrote_seeded ? seeded | writes : seeded & ~writes;
        restart <= (restart & ~ends) | writes;
        if (rst) {seeded, restart} <= {(2 * N) {1'b0}};
    end

    always @(posedge clk) begin
        bubble   <= (takes_op && op_writes) || takes_put;
        open     <= room && state == RUN && !(takes_op && op_writes) && !takes_put && !restarts;  // `stop` lasts for a clock longer
        if (takes_put) put_busy <= 1'b1;
        if (!put_busy) putting <= put_slot;
        if (put_done) put_busy <= 1'b0;

        if (issues) begin
            issued    <= following;
            following <= following + 8'd1;
        end
        if (d_valid) now <= d_time;
        if (takes_token && q_event) came <= 1'b1;
        if (steps) step_slot <= last_slot ? {SLOT_W{1'b0}} : step_slot + {{(SLOT_W - 1) {1'b0}}, 1'b1};
        if (restep) step_slot <= {SLOT_W{1'b0}};
        last_slot <= restep_2 || step_slot == LAST[SLOT_W-1:0];
        if (steps && step_slot == {SLOT_W{1'b0}}) begin
            came <= 1'b0;
            if (came) empty <= 6'd0;
            else if (!empty[5]) begin
                empty  <= empty + 6'd1;
                paused <= paused + {{(TIME_W - 21) {1'b0}}, {1'b0, step_mask} + 21'd1};
            end
        end

        drained <= state == RUN && stop && !active && waits_none && rests && !op_valid && !bubble;
        case (state)
            RUN:
            if (starts) begin
                state   <= BEGUN;
                holds   <= 1'b1;
                drained <= 1'b0;
            end
            BEGUN: state <= BUSY;
            BUSY:
            if (rests) state <= DUE;
            DUE: begin
                holds <= 1'b0;
                state <= RUN;
            end
        endcase

        restarts <= any_restart;
        must_end <= restarts;
        end_slot <= lowest_restart;

        step_mask <= ~(20'hfffff << step_log2);
        restep_1  <= cfg_valid && cfg_addr == `EVCOT_MREG_STEP_LOG2 && cfg_data != step_log2;
        restep_2  <= restep_1;  // step_mask follows
        restep_3  <= restep_2;
        restep    <= restep_3;
        step_end  <= (restep_3 ? {now, {SLOT_W{1'b0}}} : step_at) | until_step;
        if (steps || restep) step_at <= step_end + {{(TIME_W + SLOT_W - 1) {1'b0}}, 1'b1};

        if (rst) begin
            state    <= RUN;
            bubble   <= 1'b0;
            put_busy <= 1'b0;
            drained  <= 1'b0;
            open     <= 1'b0;
            holds    <= 1'b0;
            issued    <= 8'd0;
            following <= 8'd1;
            now      <= {TIME_W{1'b0}};
            paused   <= {TIME_W{1'b0}};
            empty    <= 6'd0;
            came     <= 1'b0;
            restarts <= 1'b0;
            must_end <= 1'b0;
            restep_1 <= 1'b1;
            restep_2 <= 1'b1;
            restep_3 <= 1'b1;
            restep   <= 1'b1;
        end
    end

endmodule

`default_nettype wire
