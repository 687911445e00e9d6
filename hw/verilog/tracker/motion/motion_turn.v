// SPDX-License-Identifier: Apache-2.0
// What comes next: a token, an operation, a slot for which computed state takes effect, a motion step, or the end of a life; and the
// registers that say so, `mode` of each slot and when steps are: one slot at a time, spread over a period of 2^step_log2 ticks.
//
// A slot takes effect before the first event or step that reaches its number or its tick. Tokens under way may make others wait: so the
// next one follows at once only if it is within their 256 ticks, and a step, or the end of a life, only when none is under way. What
// takes effect waits for those too, unless none of them can cause a job of its slot. Before a life ends, all that waits takes effect.
//
// Latency:    1 clock from d_valid to now; 4 from a change of step_log2 to next_step.
// Throughput: a token per clock; behind a slot that takes effect, 6 clocks to the next token, and 12 to the next such slot. A step in 5.
// Stall:      tokens wait for jobs that are due; a step for room for its job.
// Reset:      the first step is slot 0's, at 2^step_log2. cfg_rst, which comes with rst, turns all slots off.
// Combinational paths: q_runs, q_late, q_far, due_valid, due_any and op_clear -> takes_token; op_clear -> op_effect; op_clear and
//             alive -> op_step.
`default_nettype none
`include "evcot_defs.vh"

module motion_turn #(
    parameter N      = 8,
    parameter SLOT_W = 3,
    parameter TIME_W = 48,
    parameter DUE_W  = 24
) (
    input  wire              clk,
    input  wire              rst,
    input  wire              cfg_rst,

    input  wire              cfg_valid,
    input  wire [SLOT_W-1:0] cfg_slot,
    input  wire [`EVCOT_MREG_W-1:0] cfg_addr,
    input  wire [4:0]        cfg_data,
    input  wire [4:0]        step_log2,
    output reg  [N-1:0]      seeded,       // `mode`

    // tokens: see motion_queue.v
    input  wire              q_due,        // there is one, and a motion step comes before it
    input  wire              q_runs,       // there is one, and none does
    input  wire              q_late,       // due_tick is not behind it
    input  wire              q_far,        // it is 256 ticks or more behind `now`
    input  wire              q_event,      // it is an event, not taken out by a filter
    input  wire              q_counts,     // it is an event, or one that a filter took out
    input  wire              room,         // for those under way and two more: it is seen a clock later
    output wire              takes_token,
    output reg               holds,        // a motion step is under way: next_step changes, and no token is taken
    input  wire              d_valid,      // a token is done
    input  wire [TIME_W-1:0] d_time,
    output reg  [TIME_W-1:0] now,
    output wire [TIME_W-1:0] next_step,

    // operations: see motion_events.v
    input  wire              op_clear,     // one that may always come
    input  wire              active,       // a token or an operation is under way, or a job
    output wire              op_step,      // of work_slot
    output wire              op_effect,    // of due_slot
    input  wire              effect_done,
    output reg               effects,      // something takes effect:
    output reg  [SLOT_W-1:0] e_slot,       // this slot,
    output reg               e_own,        // if it is its own,
    output reg  [N-1:0]      e_ended,      // and the end of these

    // jobs: see motion_jobs.v
    input  wire [N-1:0]      alive,        // slots that are not free
    input  wire [N-1:0]      corrects,     // slots of which no event causes a job
    output wire [SLOT_W-1:0] work_slot,    // whose step it is, or whose life ends
    output reg               job_real,     // of the operation, if it is a step: the slot lives,
    output reg               job_pauses,   // a period has ended in which nothing came,
    output reg               job_ends,     // or a life ends
    output wire [TIME_W-1:0] work_time,
    output wire              works,        // no token comes
    input  wire              due_valid,
    input  wire              due_any,
    input  wire [SLOT_W-1:0] due_slot,
    input  wire [7:0]        due_event,
    input  wire [DUE_W-1:0]  due_tick,
    input  wire              ready,
    input  wire              due_own,
    input  wire [N-1:0]      due_ended,

    output wire              quiet         // nothing of this is under way
);

    localparam [31:0] LAST = N - 1;

    localparam [1:0] RUN   = 2'd0;
    localparam [1:0] BEGUN = 2'd1;  // a step: the next one's tick is found
    localparam [1:0] BUSY  = 2'd2;
    localparam [1:0] DUE   = 2'd3;  // the queue sees whether another step is due

    reg  [1:0]        state;
    reg  [7:0]        issued;     // lower bits of the number of the next event
    reg  [7:0]        following;  // those of the one behind it
    reg               came;       // an event, in this period
    reg  [5:0]        empty;      // periods in a row without one, at most 32
    reg               bubble;     // an effect was before
    reg               effects_1, effects_2;  // it has, a clock and two before
    reg               may_effect, may_step, may_end;  // may come in this clock, if no bin is cleared
    reg               calm;       // nothing is under way
    reg               stepping;   // a step may be under way
    reg               reached;    // due_event is the next event's
    reg               step_late;  // due_tick is not behind the next step
    reg               fast;       // no event under way causes a job of due_slot, or of one that ends with it
    reg               open;       // a token may come: there is room, no bubble, and no life must end
    reg  [N-1:0]      restart;    // `mode` was written
    reg               restarts, must_end;
    reg               forces;     // all that waits takes effect
    reg               restep_1, restep_2, restep_3, restep;  // step_log2 changes, or reset: the next step is set
    reg  [19:0]       step_mask;  // from a multiple of a period's length, or a time behind it, to the last tick before the next one
    reg  [SLOT_W-1:0] step_slot, end_slot;
    reg               last_slot;  // the next step is the last one of a period
    reg  [TIME_W+SLOT_W-1:0] step_at;  // its tick, in parts of 2^-SLOT_W: from one slot's step to the next one's are 2^step_log2
    reg               wrote, wrote_seeded;  // `mode` was written, in the clock before,
    reg  [N-1:0]      writes;               // of this slot
    reg  [N-1:0]      end_here;             // a one for end_slot
    wire              any_restart;
    wire [SLOT_W-1:0] lowest_restart;
    reg  [TIME_W+SLOT_W-1:0] step_end;  // the last part before the next step but one, or with `restep` before the next
    wire [TIME_W+SLOT_W-1:0] until_step = last_slot ? {{(TIME_W - 20) {1'b0}}, step_mask, {SLOT_W{1'b1}}}
                                                    : {{(TIME_W + SLOT_W - 20) {1'b0}}, step_mask};
    // Of the next step, or `now`: a step never comes in the clock behind must_end, nor in one of restep_3.
    wire [TIME_W+SLOT_W-1:0] from   = restep_3 || must_end ? {now, {SLOT_W{1'b0}}} : step_at;
    wire [DUE_W-1:0]  step_over = next_step[DUE_W-1:0] - due_tick;
    wire              known     = !due_any || due_valid;  // whether something is due
    wire              is_due    = due_valid && (reached || forces || must_end || (q_runs && q_late) || (q_due && step_late));
    wire              turns     = calm && known && !is_due && !effects && !bubble && !may_effect && !may_step && !may_end;
    wire              lives     = alive[work_slot];
    wire              ends_life = may_end && !op_clear;
    wire              steps     = may_step && !op_clear;
    wire              issues    = takes_token && q_counts;
    wire              pauses    = step_slot == {SLOT_W{1'b0}} && !came && !empty[5];

    assign op_effect   = may_effect && !op_clear;
    assign takes_token = open && !op_clear && !(due_valid && (reached || q_late)) && known && !(q_far && !calm) && q_runs;
    assign op_step     = (steps && (lives || pauses)) || (ends_life && lives);
    assign next_step   = step_at[SLOT_W+:TIME_W];
    assign work_slot   = must_end ? end_slot : step_slot;
    assign work_time   = from[SLOT_W+:TIME_W];
    assign works       = may_step || may_end;
    assign quiet       = state == RUN && !effects && !wrote && !any_restart && !restarts && !must_end && !forces
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

    wire [N-1:0] one = {{(N - 1) {1'b0}}, 1'b1};

    always @(posedge clk) begin
        wrote        <= cfg_valid && cfg_addr == `EVCOT_MREG_MODE && !cfg_rst;
        writes       <= cfg_valid && cfg_addr == `EVCOT_MREG_MODE && !cfg_rst ? one << cfg_slot : {N{1'b0}};
        wrote_seeded <= cfg_data[1:0] == `EVCOT_MODE_SEEDED;
    end

    always @(posedge clk) begin
        seeded  <= (seeded & ~writes) | (writes & {N{wrote_seeded}});
        restart <= (restart & ~(end_here & {N{ends_life}})) | writes;
        if (cfg_rst) {seeded, restart} <= {(2 * N) {1'b0}};
    end

    always @(posedge clk) begin
        may_effect <= is_due && known && ready && !effects && !effects_1 && !effects_2 && ((fast && !stepping) || calm) && !op_effect;
        may_step   <= turns && q_due && !must_end && !restarts && !forces && state == RUN && room;
        may_end    <= turns && must_end && !due_any;
        if (op_clear) {may_step, may_end} <= 2'b00;
        bubble    <= op_effect;
        calm      <= !active && !takes_token && !op_step && !op_effect && !op_clear;
        stepping  <= op_step || (stepping && !calm);
        reached   <= due_event == (issues ? following : issued);
        step_late <= !step_over[DUE_W-1];
        fast      <= due_own && corrects[due_slot] && due_ended == {N{1'b0}};
        open      <= room && state == RUN && !op_effect && !restarts && !must_end && !forces;
        if (op_effect) {effects, e_slot, e_own, e_ended} <= {1'b1, due_slot, due_own, due_ended};
        {effects_2, effects_1} <= {effects_1, effects};
        if (effect_done) effects <= 1'b0;

        if (issues) begin
            issued    <= following;
            following <= following + 8'd1;
        end
        if (d_valid) now <= d_time;
        if (takes_token && q_event) came <= 1'b1;
        if (steps) step_slot <= last_slot ? {SLOT_W{1'b0}} : step_slot + {{(SLOT_W - 1) {1'b0}}, 1'b1};
        if (restep) step_slot <= {SLOT_W{1'b0}};
        last_slot <= restep_2 || step_slot == LAST[SLOT_W-1:0];
        if (steps || ends_life) {job_real, job_pauses, job_ends} <= {lives, steps && pauses, ends_life};
        if (steps && step_slot == {SLOT_W{1'b0}}) begin
            came <= 1'b0;
            if (came) empty <= 6'd0;
            else if (pauses) empty <= empty + 6'd1;
        end

        case (state)
            RUN:
            if (steps) begin
                state <= BEGUN;
                holds <= 1'b1;
            end
            BEGUN: state <= BUSY;
            BUSY: state <= DUE;
            DUE: begin
                holds <= 1'b0;
                state <= RUN;
            end
        endcase

        restarts <= any_restart;
        must_end <= restarts && !ends_life && !forces;
        end_slot <= lowest_restart;
        end_here <= one << lowest_restart;
        if (ends_life) forces <= 1'b1;
        if (forces && turns && !due_any) forces <= 1'b0;

        step_mask <= ~(20'hfffff << step_log2);
        restep_1  <= cfg_valid && cfg_addr == `EVCOT_MREG_STEP_LOG2 && cfg_data != step_log2;
        restep_2  <= restep_1;  // step_mask follows
        restep_3  <= restep_2;
        restep    <= restep_3;
        step_end  <= from | until_step;
        if (steps || restep) step_at <= step_end + {{(TIME_W + SLOT_W - 1) {1'b0}}, 1'b1};

        if (rst) begin
            state     <= RUN;
            bubble    <= 1'b0;
            calm      <= 1'b0;
            stepping  <= 1'b0;
            {may_effect, may_step, may_end} <= 3'b000;
            effects   <= 1'b0;
            open      <= 1'b0;
            holds     <= 1'b0;
            issued    <= 8'd0;
            following <= 8'd1;
            now       <= {TIME_W{1'b0}};
            empty     <= 6'd0;
            came      <= 1'b0;
            restarts  <= 1'b0;
            must_end  <= 1'b0;
            forces    <= 1'b0;
            restep_1  <= 1'b1;
            restep_2  <= 1'b1;
            restep_3  <= 1'b1;
            restep    <= 1'b1;
        end
    end

    wire unused = &{1'b0, step_over};

endmodule

`default_nettype wire
