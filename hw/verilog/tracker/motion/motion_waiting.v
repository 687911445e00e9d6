// SPDX-License-Identifier: Apache-2.0
// Slots that wait for a correction, or for a candidate to begin in them: first for the work that is to be done, then for the event from
// which on what was found is in force.
//
// Slots are worked on, and put in force, in the order in which they came: two places in one ring.
//
// Latency:    2 clocks from s_valid to job_valid, 1 from job_done to that of the next slot; 3 to what is in block RAM, and to reached; 2
//             from job_done to put_valid, and from put_done to the next one's put_slot, which is not reached until then.
// Throughput: a slot per clock.
// Stall:      none: there is an entry for each slot, and a slot does not come again before it is in force.
// Reset:      becomes empty.
// Combinational paths: none.
`default_nettype none

module motion_waiting #(
    parameter SLOT_W = 3,
    parameter X_W    = 9,
    parameter Y_W    = 9,
    parameter SUP_W  = 16,  // bits of a support count
    parameter SEQ_W  = 48,
    parameter TIME_W = 48,
    parameter AFTER  = 64   // in force so many events later
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              s_valid,
    input  wire              s_seed,     // a candidate begins
    input  wire [SLOT_W-1:0] s_slot,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    input  wire [SUP_W-1:0]  s_support,
    input  wire [TIME_W-1:0] s_time,
    input  wire [SEQ_W-1:0]  s_seq,

    // the next one to be worked on
    output reg               job_valid,
    input  wire              job_done,
    output reg               job_seed,
    output reg  [SLOT_W-1:0] job_slot,
    output wire [X_W-1:0]    job_x,       // from here on, of a memory: two clocks behind it at most
    output wire [Y_W-1:0]    job_y,
    output wire [SUP_W-1:0]  job_support,
    output wire [TIME_W-1:0] job_time,
    output wire [SEQ_W-1:0]  job_seq,

    // the next one to be in force
    input  wire [7:0]        issued,     // lower bits of the number of the event that comes next
    input  wire [7:0]        following,  // those of the one behind it
    input  wire              issues,     // it comes in this clock
    output reg               reached,    // it must be before that event
    output reg               put_valid,  // it can be, a clock late
    output reg               put_seed,
    output reg  [SLOT_W-1:0] put_slot,
    input  wire              put_done,

    output wire              empty
);

    localparam JOB_W = X_W + Y_W + SUP_W + TIME_W + SEQ_W;
    localparam [7:0] LATER = AFTER;
    localparam ADDR_W = SLOT_W > 7 ? SLOT_W : 7;  // more than 64 words, for block RAM on every device

    reg [SLOT_W:0]     slots[0:(1<<SLOT_W)-1];  // and whether a candidate begins
    reg [SLOT_W+8:0]   puts [0:(1<<SLOT_W)-1];
    reg [SLOT_W:0]     tail, job, head;         // modulo twice the depth
    reg [SLOT_W:0]     job_1;                   // the one behind `job`
    reg  [7:0]         put_event;
    reg                waits;                   // the entry that was read is one
    wire               is_now   = put_event == issued;
    wire               is_later = put_event == following;

    wire [SLOT_W:0]    job_next = job_done ? job_1 : job;

    assign empty = head == tail;

    block_memory #(
        .W    (JOB_W),
        .DEPTH(1 << ADDR_W)
    ) u_jobs (
        .clk          (clk),
        .write        (s_valid),
        .write_address({{(ADDR_W - SLOT_W) {1'b0}}, tail[SLOT_W-1:0]}),
        .write_data   ({s_x, s_y, s_support, s_time, s_seq}),
        .read_enable  (1'b1),
        .read_address ({{(ADDR_W - SLOT_W) {1'b0}}, job[SLOT_W-1:0]}),
        .out_enable   (1'b1),
        .read_data    ({job_x, job_y, job_support, job_time, job_seq})
    );

    always @(posedge clk) begin
        if (s_valid) begin
            slots[tail[SLOT_W-1:0]] <= {s_seed, s_slot};
            puts[tail[SLOT_W-1:0]]  <= {s_seed, s_slot, s_seq[7:0] + LATER};
            tail                    <= tail + {{SLOT_W{1'b0}}, 1'b1};
        end
        job       <= job_next;
        job_valid <= job_done ? job_1 != tail : job != tail;
        {job_seed, job_slot} <= slots[job_next[SLOT_W-1:0]];
        if (job_done) job_1 <= job_1 + {{SLOT_W{1'b0}}, 1'b1};
        if (put_done) head <= head + {{SLOT_W{1'b0}}, 1'b1};
        {put_seed, put_slot, put_event} <= puts[head[SLOT_W-1:0]];
        put_valid <= head != job;
        waits     <= head != tail && !put_done;
        reached   <= waits && !put_done && (issues ? is_later : is_now);
        if (rst) begin
            tail      <= {(SLOT_W + 1) {1'b0}};
            job       <= {(SLOT_W + 1) {1'b0}};
            job_1     <= {{SLOT_W{1'b0}}, 1'b1};
            head      <= {(SLOT_W + 1) {1'b0}};
            job_valid <= 1'b0;
            put_valid <= 1'b0;
            waits     <= 1'b0;
            reached   <= 1'b0;
        end
    end

endmodule

`default_nettype wire
