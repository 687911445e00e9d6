// SPDX-License-Identifier: Apache-2.0
// Which owned events count, when windows close, and the queue of closed windows: rules W and Q of docs/recognition.md.
//
// An event is decided in the clock in which it is offered. The queue is a ring with four pointers, in this order: windows leave it
// at `released_to` (rule Q2), have been evaluated up to `evaluated_to`, can be evaluated up to `settled_to`, and enter at
// `closed_to`.
//
// Latency:    none from s_ to `counts`, `first` and `young`; SETTLE + 1 clocks from a closing event to head_valid.
// Throughput: 1 event per clock.
// Stall:      none.
// Reset:      all slots are fresh, the queue is empty. Counts and the contents of the queue are not reset.
// Combinational paths: from enable, s_valid, s_slot and s_visible to counts, first, young and quiet.
`default_nettype none

module classifier_windows #(
    parameter N      = 8,   // slots of the tracker
    parameter ID_W   = 16,  // bits of a track id
    parameter SEQ_W  = 32,  // bits of an event's number
    parameter SETTLE = 23,  // clocks after which the closing event is in the image
    parameter SLOT_W = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire              clk,
    input  wire              rst,

    // registers; restart: all windows begin anew, while `quiet`
    input  wire              restart,
    input  wire              enable,
    input  wire [3:0]        window_log2,
    output wire              quiet,        // no window waits for its evaluation, and none can close in this clock

    // owned events: first a clock ahead
    input  wire              ahead_valid,
    input  wire [SLOT_W-1:0] ahead_slot,
    input  wire              s_valid,
    input  wire [SLOT_W-1:0] s_slot,
    input  wire              s_visible,
    input  wire [ID_W-1:0]   s_id,
    input  wire [SEQ_W-1:0]  s_seq,
    output wire              counts,
    output wire              first,        // of its window
    output wire              young,        // in the first window of its track: stage 0

    // the first window to evaluate
    output wire              head_valid,
    output wire [SLOT_W-1:0] head_slot,
    output wire              head_young,
    output wire [ID_W-1:0]   head_id,
    output wire [SEQ_W-1:0]  head_seq,
    input  wire              head_done     // it has been evaluated
);

    parameter_check #(.OK(N >= 1 && N <= 64)) N_must_be_1_to_64 ();
    parameter_check #(.OK(SETTLE >= 2)) SETTLE_must_be_at_least_2 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    // ---- state of the slots ------------------------------------------------------------------------------------------

    // A slot without events since the last restart is fresh, whatever its memory says.
    wire [N-1:0] used;
    wire [N-1:0] pending;
    reg [N-1:0] released;                       // no longer pending
    reg         was_released;                   // s_slot
    reg [14:0]  state [0:N-1];
    reg [N-1:0] slot_bit;                       // of s_slot
    wire        was_open, was_young, was_last;  // open: events were counted; last: this one closes the window
    wire [11:0] left;                           // events to come behind this one's successor

    assign {was_open, was_young, was_last, left} = state[s_slot];

    reg  [SLOT_W:0]   released_to, evaluated_to, settled_to, closed_to;
    reg               is_due;    // the next event releases a window
    reg               restarted;
    reg  [SETTLE-1:0] settling;  // windows that closed so many clocks ago
    wire [SLOT_W-1:0] released_slot;

    wire was_used = |(used & slot_bit);

    assign counts = s_valid && enable && s_visible && (was_released || !(|(pending & slot_bit)));
    assign first  = !(was_used && was_open);
    assign young  = !was_used || was_young;

    // K - 2 in binary is ones and a zero, as many as window_log2 says, at least 8.
    wire [3:0]  beyond = {window_log2 == 4'd12, window_log2 >= 4'd11, window_log2 >= 4'd10, window_log2 >= 4'd9};
    wire [12:0] left_next;
    wire        full   = !first && was_last;
    wire        closes = counts && full;
    wire        writes = counts || (s_valid && !s_visible);

    array_sum #(
        .W    (13),
        .ROUND(0)
    ) u_left (
        .a     (13'h1FFF),
        .choice(first),
        .one   ({1'b0, beyond, 7'h7F, 2'b00}),
        .other ({was_last, left, 1'b0}),
        .y     (left_next)
    );

    function [N-1:0] one_slot;
        input [SLOT_W-1:0] slot;
        integer n;
        for (n = 0; n < N; n = n + 1) one_slot[n] = slot == n[SLOT_W-1:0];
    endfunction

    assign quiet      = evaluated_to == closed_to && !(s_valid && full);
    assign head_valid = evaluated_to != settled_to;

    always @(posedge clk) begin
        if (writes) state[s_slot] <= {s_visible && !full, !s_visible || (young && !full), left_next};
    end

    classifier_flags #(
        .N(N)
    ) u_used (
        .clk     (clk),
        .rst     (rst || restart),
        .sets    (writes),
        .set_slot(slot_bit),
        .clears  ({N{1'b0}}),
        .flags   (used)
    );

    classifier_flags #(
        .N(N)
    ) u_pending (
        .clk     (clk),
        .rst     (rst || restart),
        .sets    (closes),
        .set_slot(slot_bit),
        .clears  (released),
        .flags   (pending)
    );

    // ---- rule Q2; a window is released a clock before the event that does it is decided ------------------------------

    // A maximal-length shift register counts events: from 768 in busy to 2, in which the next event makes it 1.
    localparam [9:0] BUSY_768 = 10'd1, BUSY_2 = 10'd784;

    reg  [9:0] busy;
    wire       waits    = released_to != closed_to;
    wire       will_be_due = s_valid ? waits && busy == BUSY_2 : is_due;
    wire       releases = ahead_valid && will_be_due;

    always @(posedge clk) begin
        is_due <= will_be_due;
        if (s_valid) begin
            busy <= {busy[8:0], busy[9] ^ busy[6]};
            if (is_due || !waits) busy <= BUSY_768;
        end
        slot_bit <= one_slot(ahead_slot);
        was_released <= releases && released_slot == ahead_slot;
        released <= one_slot(released_slot);
        if (!releases) released <= {N{1'b0}};
        if (s_valid && is_due) released_to <= released_to + 1'b1;
        if (closes) closed_to <= closed_to + 1'b1;
        if (head_done) evaluated_to <= evaluated_to + 1'b1;
        settling <= {settling[SETTLE-2:0], closes};
        if (settling[SETTLE-1]) settled_to <= settled_to + 1'b1;
        restarted <= restart;
        if (restarted) released_to <= closed_to;  // a clock late: no window closes so soon
        if (rst) begin
            released_to  <= {(SLOT_W + 1) {1'b0}};
            evaluated_to <= {(SLOT_W + 1) {1'b0}};
            settled_to   <= {(SLOT_W + 1) {1'b0}};
            closed_to    <= {(SLOT_W + 1) {1'b0}};
            settling     <= {SETTLE{1'b0}};
            restarted    <= 1'b0;
        end
        if (restarted || rst) is_due <= 1'b0;
    end

    // ---- the queue ---------------------------------------------------------------------------------------------------

    localparam DEPTH = 1 << SLOT_W;

    reg [SLOT_W+ID_W+SEQ_W:0] queue [0:DEPTH-1];
    reg [SLOT_W-1:0]          release_queue [0:DEPTH-1];  // its slots once more, for the second reader

    assign {head_young, head_slot, head_id, head_seq} = queue[evaluated_to[SLOT_W-1:0]];
    assign released_slot = release_queue[released_to[SLOT_W-1:0]];

    always @(posedge clk) begin
        if (closes) begin
            queue[closed_to[SLOT_W-1:0]]         <= {young, s_slot, s_id, s_seq};
            release_queue[closed_to[SLOT_W-1:0]] <= s_slot;
        end
    end

endmodule

`default_nettype wire
