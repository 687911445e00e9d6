// SPDX-License-Identifier: Apache-2.0
// Jobs on their way to the unit that computes them, and what takes effect later: docs/motion.md, rules J1 to J5.
//
// Jobs are computed in the order in which they came. With a seed or a correction a slot begins to wait, and with a step if it does not
// wait already. The slots that wait form a queue of their own, since a slot that began earlier is due earlier. Of a slot that begins
// anew, or that another one ends, the entry before stays in the queue, and is skipped.
//
// Of an event's number and of a tick, a job stores the lower 16 bits; the rest follows from the job that came last. Until then a slot
// that a job computes something of has not taken effect, so it is at most two times 64 events and 256 ticks old.
//
// Slots that end with the slot that is due are found one by one: all slots are gone through until a whole round finds no more.
//
// Latency:    3 clocks from j_valid to job_valid, 4 to job_seq and job_time, and 4 to due_valid; 2 from job_done to `ready`, or where slots end with others, a round.
// Throughput: a job per clock comes in. From job_done to the next job_valid 1 clock, from due_taken to the next due_valid 2.
// Stall:      none: jobs may come while there is `room`, and at most 12 that were on their way.
// Reset:      no job, and no slot waits.
// Combinational paths: none.
`default_nettype none

module motion_jobs #(
    parameter N      = 8,
    parameter SLOT_W = 3,
    parameter X_W    = 9,
    parameter Y_W    = 9,
    parameter SIDE_W = 25,
    parameter SUP_W  = 16,
    parameter SEQ_W  = 48,
    parameter TIME_W = 48,
    parameter DUE_W  = 24,   // bits of a tick that count
    parameter EVENTS = 64,   // a job is due so many events after its cause,
    parameter TICKS  = 256   // or ticks
) (
    input  wire                clk,
    input  wire                rst,

    // a job
    input  wire                j_valid,
    input  wire                j_real,     // else it only says that a period was empty
    input  wire                j_flag,     // of a correction: its event is within a burst; of a step: a period was empty
    input  wire [1:0]          j_kind,     // 0 a correction, 1 a seed, 2 a step, 3 the end of a life
    input  wire [SLOT_W-1:0]   j_slot,
    input  wire [X_W-1:0]      j_x,        // of a seed
    input  wire [Y_W-1:0]      j_y,
    input  wire [4*SIDE_W-1:0] j_sides,    // of a seed 0
    input  wire [3:0]          j_marks,
    input  wire [SUP_W-1:0]    j_owned,
    input  wire [SEQ_W-1:0]    j_seq,
    input  wire [TIME_W-1:0]   j_time,
    output reg                 room,

    // the next one to be computed; it stays until it is done
    output reg                 job_valid,
    input  wire                job_done,   // not before the 2nd clock after job_valid
    output wire                job_real,
    output wire                job_flag,
    output wire [1:0]          job_kind,
    output wire [SLOT_W-1:0]   job_slot,
    output wire                job_waits,  // the slot waited already
    output wire [X_W-1:0]      job_x,
    output wire [Y_W-1:0]      job_y,
    output wire [4*SIDE_W-1:0] job_sides,
    output wire [3:0]          job_marks,
    output wire [SUP_W-1:0]    job_owned,
    output reg  [SEQ_W-1:0]    job_seq,    // a clock later
    output reg  [TIME_W-1:0]   job_time,
    input  wire                finish,     // it is, and something was computed
    input  wire                ends,       // it ends
    input  wire [SLOT_W-1:0]   ends_slot,  // this slot
    input  wire                mask,       // the box of job_slot is being written to masks, from the next clock on
    input  wire                mask_busy,  // as long as this is high: it may not take effect
    output wire                idle,       // no job

    // the slot that is due next
    output reg                 due_valid,
    output wire                due_any,    // it comes, if it is not there yet
    output wire [SLOT_W-1:0]   due_slot,
    output wire [7:0]          due_event,  // lower bits of the number of the event
    output wire [DUE_W-1:0]    due_tick,
    output reg                 ready,      // all its jobs are done
    output reg                 due_own,    // and something was computed
    output reg  [N-1:0]        due_ended,  // slots that end with it, and with those
    input  wire                due_taken   // it takes effect; only while `ready`
);

    localparam SEQ_LOW  = SEQ_W < 16 ? SEQ_W : 16;  // stored bits of a job's number
    localparam TIME_LOW = 16;                       // and of its tick; TIME_W is more
    localparam JOB_W   = 4 + SLOT_W + 1 + X_W + Y_W + 4 * SIDE_W + 4 + SUP_W + SEQ_LOW + TIME_LOW;
    localparam DEPTH_W = 7;  // more than 64 words, for block RAM on every device
    localparam WAIT_W  = 8;  // a slot waits for 64 events at most; beside slots that events made wait, each slot may by a step
    localparam [7:0]       LATER = EVENTS;
    localparam [DUE_W-1:0] UNTIL = TICKS;
    localparam [DEPTH_W:0] MOST  = 112;

    localparam [31:0]      ROUND = N;
    localparam [31:0]      FINAL = N - 1;

    reg  [DEPTH_W:0]  tail, head;       // jobs: the next one's place, and that of the one that is computed
    reg  [DEPTH_W:0]  following;        // of the one that is read next
    reg               fetched;          // the one before has been read, up to the output register
    reg  [WAIT_W-1:0] last, first;      // of the slots that wait: the next one's place, and the first one's,
    reg  [WAIT_W-1:0] second;           // and that of the one that is read next
    reg  [N-1:0]      waits;
    reg  [N-1:0]      pending;          // jobs of the slot are not done
    reg  [DEPTH_W:0]  last_jobs[0:(1<<SLOT_W)-1];  // of these the place of the last,
    reg  [WAIT_W-1:0] places[0:(1<<SLOT_W)-1];     // of the slot's entry, if it waits
    reg  [SLOT_W-1:0] work_slot;        // job_slot, a clock later,
    reg               is_last;          // and whether its job is the last one of it
    reg  [N-1:0]      computed;         // something was, and has not taken effect
    reg  [N-1:0]      seeded;           // a seed of the slot is among the jobs
    reg  [N-1:0]      ending;           // another slot ends it,
    reg  [SLOT_W-1:0] end_with[0:(1<<SLOT_W)-1];   // as this one takes effect
    reg               any_ending;
    reg  [SLOT_W-1:0] mask_slot;
    reg  [TIME_W-1:TIME_LOW-1] last_time;  // of the job that came last
    wire [SEQ_LOW-1:0]  seq_low;
    wire [TIME_LOW-1:0] time_low;
    reg               due_fetched, due_there, due_read, is_first;
    reg  [SLOT_W-1:0] slot;             // due_slot, a clock later: what is found of it
    wire              skips = due_read && !is_first;
    wire              pops  = due_taken || skips;
    wire              due_gives = due_fetched && (!due_there || pops);
    wire              due_reads = second != last && (!due_fetched || due_gives);
    wire              any_job = following != tail;
    wire              gives   = fetched && (!job_valid || job_done);
    wire              reads   = any_job && (!fetched || gives);
    wire              begins  = j_valid && j_real && (!j_kind[1] || !waits[j_slot]);
    wire              seeds   = j_valid && j_kind == 2'd1;
    wire [N-1:0]      one     = {{(N - 1) {1'b0}}, 1'b1};
    wire [N-1:0]      begun   = begins ? one << j_slot : {N{1'b0}};
    reg  [N-1:0]      slot_here, work_here;  // a one for `slot`, for work_slot
    wire [N-1:0]      taken   = due_taken ? due_ended | slot_here : {N{1'b0}};
    reg  [SLOT_W-1:0] asked;   // of this slot it is seen whether it ends with due_slot,
    reg  [N-1:0]      asked_here;  // a one for it,
    reg  [SLOT_W:0]   unfound; // and so many before it were no more to be found
    wire [SLOT_W-1:0] asked_with = end_with[asked];
    wire              finds      = |(ending & ~due_ended & asked_here) && (asked_with == slot || due_ended[asked_with]);
    wire              steady     = !any_ending || unfound == ROUND[SLOT_W:0];  // due_ended is all of them
    wire [N-1:0]      job_here   = job_done ? work_here : {N{1'b0}};
    wire [N-1:0]      come       = j_valid ? one << j_slot : {N{1'b0}};

    assign idle    = head == tail;
    assign due_any = first != last;

    block_memory #(
        .W    (JOB_W),
        .DEPTH(1 << DEPTH_W)
    ) u_jobs (
        .clk          (clk),
        .write        (j_valid),
        .write_address(tail[DEPTH_W-1:0]),
        .write_data   ({j_real, j_flag, j_kind, j_slot, waits[j_slot], j_x, j_y, j_sides, j_marks, j_owned, j_seq[SEQ_LOW-1:0], j_time[TIME_LOW-1:0]}),
        .read_enable  (reads),
        .read_address (following[DEPTH_W-1:0]),
        .out_enable   (gives),
        .read_data    ({job_real, job_flag, job_kind, job_slot, job_waits, job_x, job_y, job_sides, job_marks, job_owned, seq_low, time_low})
    );

    block_memory #(
        .W    (SLOT_W + 8 + DUE_W),
        .DEPTH(1 << WAIT_W)
    ) u_waiting (
        .clk          (clk),
        .write        (begins),
        .write_address(last),
        .write_data   ({j_slot, j_seq[7:0] + LATER, j_time[DUE_W-1:0] + UNTIL}),
        .read_enable  (due_reads),
        .read_address (second),
        .out_enable   (due_gives),
        .read_data    ({due_slot, due_event, due_tick})
    );

    // What was stored is behind what came last if its upper bit is set and that one's is not.
    wire earlier_time = time_low[TIME_LOW-1] && !last_time[TIME_LOW-1];

    always @(posedge clk) begin
        if (j_valid) last_time <= j_time[TIME_W-1:TIME_LOW-1];
        job_time <= {last_time[TIME_W-1:TIME_LOW] - {{(TIME_W - TIME_LOW - 1) {1'b0}}, earlier_time}, time_low};
    end

    generate
        if (SEQ_W > SEQ_LOW) begin : g_seq
            reg  [SEQ_W-1:SEQ_LOW-1] last_seq;
            wire earlier_seq = seq_low[SEQ_LOW-1] && !last_seq[SEQ_LOW-1];

            always @(posedge clk) begin
                if (j_valid) last_seq <= j_seq[SEQ_W-1:SEQ_LOW-1];
                job_seq <= {last_seq[SEQ_W-1:SEQ_LOW] - {{(SEQ_W - SEQ_LOW - 1) {1'b0}}, earlier_seq}, seq_low};
            end
        end else begin : g_whole_seq
            always @(posedge clk) job_seq <= seq_low;
        end
    endgenerate

    always @(posedge clk) begin
        if (mask) mask_slot <= job_slot;
        if (j_valid) tail <= tail + {{DEPTH_W{1'b0}}, 1'b1};
        if (job_done) head <= head + {{DEPTH_W{1'b0}}, 1'b1};
        if (reads) following <= following + {{DEPTH_W{1'b0}}, 1'b1};
        fetched   <= reads || (fetched && !gives);
        job_valid <= gives || (job_valid && !job_done);
        room      <= tail - head < MOST;

        if (begins) last <= last + {{(WAIT_W - 1) {1'b0}}, 1'b1};
        if (pops) first <= first + {{(WAIT_W - 1) {1'b0}}, 1'b1};
        if (due_reads) second <= second + {{(WAIT_W - 1) {1'b0}}, 1'b1};
        due_fetched <= due_reads || (due_fetched && !due_gives);
        due_there   <= due_gives || (due_there && !pops);
        due_valid   <= due_there && !pops;
        due_read    <= due_valid && !pops;
        slot      <= due_slot;
        slot_here <= one << due_slot;
        work_slot <= job_slot;
        work_here <= one << job_slot;
        is_last   <= last_jobs[work_slot] == head && !(j_valid && j_real && j_slot == work_slot);

        waits    <= (waits | begun) & ~taken;
        computed <= (computed | (finish ? job_here : {N{1'b0}})) & ~taken;
        seeded   <= (seeded & ~(job_kind == 2'd1 ? job_here : {N{1'b0}})) | (seeds ? come : {N{1'b0}});
        pending  <= (pending & ~(job_real && is_last ? job_here : {N{1'b0}})) | (j_real ? come : {N{1'b0}});
        ending   <= (ending | (ends ? (one << ends_slot) & ~seeded : {N{1'b0}}))
                  & ~(due_taken ? due_ended : {N{1'b0}}) & ~(seeds ? come : {N{1'b0}});
        if (j_valid && j_real) last_jobs[j_slot] <= tail;
        if (begins) places[j_slot] <= last;
        if (ends) end_with[ends_slot] <= job_slot;

        any_ending <= ending != {N{1'b0}};
        asked      <= asked == FINAL[SLOT_W-1:0] ? {SLOT_W{1'b0}} : asked + {{(SLOT_W - 1) {1'b0}}, 1'b1};
        if (unfound != ROUND[SLOT_W:0]) unfound <= unfound + {{SLOT_W{1'b0}}, 1'b1};
        asked_here <= asked == FINAL[SLOT_W-1:0] ? one : asked_here << 1;
        if (finds) due_ended <= due_ended | asked_here;
        if (finds || ends) unfound <= {(SLOT_W + 1) {1'b0}};
        if (!due_read || pops || seeds) begin
            due_ended <= {N{1'b0}};
            unfound   <= {(SLOT_W + 1) {1'b0}};
        end
        is_first <= waits[slot] && places[slot] == first;
        due_own  <= computed[slot];
        ready    <= due_read && !pops && is_first && !pending[slot] && !j_valid && !ends && !(mask_busy && slot == mask_slot) && steady;

        if (rst) begin
            tail      <= {(DEPTH_W + 1) {1'b0}};
            following <= {(DEPTH_W + 1) {1'b0}};
            fetched   <= 1'b0;
            head      <= {(DEPTH_W + 1) {1'b0}};
            last      <= {WAIT_W{1'b0}};
            first     <= {WAIT_W{1'b0}};
            waits     <= {N{1'b0}};
            computed  <= {N{1'b0}};
            seeded    <= {N{1'b0}};
            ending    <= {N{1'b0}};
            room      <= 1'b0;
            due_there <= 1'b0;
            job_valid <= 1'b0;
            due_valid <= 1'b0;
            due_read  <= 1'b0;
            ready     <= 1'b0;
            due_fetched <= 1'b0;
            second    <= {WAIT_W{1'b0}};
            pending   <= {N{1'b0}};
            asked     <= {SLOT_W{1'b0}};
            asked_here <= one;
        end
    end

endmodule

`default_nettype wire
