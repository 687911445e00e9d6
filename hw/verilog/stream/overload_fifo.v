// SPDX-License-Identifier: Apache-2.0
// A bounded queue of tokens for sources that cannot wait: an event that arrives while it is full is dropped, its time is not.
//
// The newest event is dropped: its ticks are added to the next token that is kept, so every kept event has its correct
// time, and a waiting output token never changes. (Dropping the oldest would withdraw a waiting token, and a burst would
// displace the history that the trackers need to follow it.) Ticks without event use no entry while an event waits: they accumulate,
// and leave with the next event, or as soon as the queue is empty. Dropped events get no number.
// With drop_enable low the queue is a plain one: s_ready falls while it is full.
//
// Ticks may also come one by one at any clock, without a token (s_time): they go with the next event that is accepted.
//
// Latency:    6 clocks from s_ to m_ when empty, 7 of ticks without an event.
// Throughput: 1 token per clock; with DEPTH below 4, DEPTH tokens in four clocks.
// Stall:      a token is held until accepted; s_ready stays high while drop_enable is.
// Reset:      becomes empty, counts from 0.
// Counters:   n_in = n_out + n_dropped + held, at every clock. They count events, skipped ones included, a clock after the one in
//             which they come, go or are dropped, and wrap around.
// Combinational paths: drop_enable -> s_ready.
`default_nettype none

module overload_fifo #(
    parameter X_W     = 9,    // bits of an x address
    parameter Y_W     = 9,    // bits of a y address
    parameter TICK_W  = 20,   // bits of a token's ticks
    parameter DEPTH   = 256,  // events that wait, at least 1, any number; 4 more are on their way out
    parameter GAP_W   = 48,   // bits of the ticks that come, and are kept with an event: a stall must be shorter
    parameter COUNT_W = 32,   // bits of a counter
    parameter HELD_W  = $clog2(DEPTH + 5)  // bits of held, which counts up to DEPTH + 4
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               drop_enable,

    input  wire               s_time,     // a tick passes; s_tick must stay 0 from reset on where this is used

    // tokens in
    input  wire               s_valid,
    output wire               s_ready,
    input  wire [GAP_W-1:0]   s_tick,
    input  wire               s_event,
    input  wire               s_skip,
    input  wire [X_W-1:0]     s_x,
    input  wire [Y_W-1:0]     s_y,
    input  wire               s_p,

    // tokens out
    output wire               m_valid,
    input  wire               m_ready,
    output wire [TICK_W-1:0]  m_tick,
    output wire               m_event,
    output wire               m_skip,
    output wire [X_W-1:0]     m_x,
    output wire [Y_W-1:0]     m_y,
    output wire               m_p,

    output reg                dropped,    // for a clock after each event dropped
    output reg  [COUNT_W-1:0] n_in,       // came
    output reg  [COUNT_W-1:0] n_out,      // taken from m_
    output reg  [COUNT_W-1:0] n_dropped,
    output reg  [HELD_W-1:0]  held,       // inside
    output wire               idle        // nothing inside, and no ticks
);

    parameter_check #(.OK(GAP_W > TICK_W)) GAP_W_must_exceed_TICK_W ();
    parameter_check #(.OK(GAP_W <= 48)) GAP_W_must_be_at_most_48 ();
    parameter_check #(.OK(COUNT_W >= 8 && COUNT_W <= 64)) COUNT_W_must_be_8_to_64 ();
    parameter_check #(.OK(HELD_W >= $clog2(DEPTH + 5))) HELD_W_must_hold_DEPTH_and_4_more ();

    localparam TOKEN_W = GAP_W + X_W + Y_W + 3;

    reg  [GAP_W-1:0] waiting;  // ticks of what was dropped, and of tokens of ticks alone
    reg              waits;    // there are any: known without looking at all of them
    wire [GAP_W-1:0] ticks;
    wire             some  = waits || (s_valid && s_tick != {GAP_W{1'b0}}) || s_time;

    // waiting, s_tick if there is a token, and s_time, which is the carry.
    array_sum #(
        .W(GAP_W)
    ) u_ticks (
        .a     (waiting),
        .choice(s_valid),
        .one   ({s_tick, s_time}),
        .other ({{GAP_W{1'b0}}, s_time}),
        .y     (ticks)
    );

    wire room, queue_valid, queue_ready, queue_event, queue_skip, queue_p, output_idle;
    wire [GAP_W-1:0]   queue_tick;
    wire [X_W-1:0]     queue_x;
    wire [Y_W-1:0]     queue_y;
    wire [$clog2(DEPTH+1)-1:0] level;

    wire empty = level == {($clog2(DEPTH + 1)) {1'b0}};

    assign s_ready = drop_enable || room;

    // With room s_ready is high, and an empty queue has room: neither keeps nor flushes has to look at drop_enable.
    wire comes   = s_valid && (s_event || s_skip);
    wire arrives = comes && s_ready;
    wire keeps   = comes && room;
    wire drops   = arrives && !room;
    wire flushes = !comes && empty && waits;  // ticks that come now go with those of before, or in the next clock
    wire gives   = m_valid && m_ready && (m_event || m_skip);

    fifo #(
        .W    (TOKEN_W),
        .DEPTH(DEPTH),
        .BLOCK(1)
    ) u_queue (
        .clk    (clk),
        .rst    (rst),
        .s_valid(keeps || flushes),
        .s_ready(room),
        .s_data ({ticks, keeps && s_event, keeps && s_skip, s_x, s_y, s_p}),
        .m_valid(queue_valid),
        .m_ready(queue_ready),
        .m_data ({queue_tick, queue_event, queue_skip, queue_x, queue_y, queue_p}),
        .level  (level)
    );

    tick_splitter #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .WIDE_W(GAP_W),
        .TICK_W(TICK_W)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(queue_valid),
        .s_ready(queue_ready),
        .s_tick (queue_tick),
        .s_event(queue_event),
        .s_skip (queue_skip),
        .s_x    (queue_x),
        .s_y    (queue_y),
        .s_p    (queue_p),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_tick (m_tick),
        .m_event(m_event),
        .m_skip (m_skip),
        .m_x    (m_x),
        .m_y    (m_y),
        .m_p    (m_p),
        .idle   (output_idle)
    );

    reg arrived, kept, given;  // an event, a clock ago: see dropped

    assign idle = !waits && empty && !queue_valid && output_idle;

    always @(posedge clk) begin
        if (keeps || flushes) begin
            waiting <= {GAP_W{1'b0}};
            waits   <= 1'b0;
        end else if (s_ready || s_time) begin
            waiting <= ticks;
            waits   <= some;
        end
        dropped <= drops;
        arrived <= arrives;
        kept    <= keeps;
        given   <= gives;
        if (arrived) n_in <= n_in + 1'b1;
        if (dropped) n_dropped <= n_dropped + 1'b1;
        if (given) n_out <= n_out + 1'b1;
        if (kept != given) held <= held + {{(HELD_W - 1) {given}}, 1'b1};
        if (rst) begin
            waiting   <= {GAP_W{1'b0}};
            waits     <= 1'b0;
            {arrived, dropped, kept, given} <= 4'b0000;
            n_in      <= {COUNT_W{1'b0}};
            n_out     <= {COUNT_W{1'b0}};
            n_dropped <= {COUNT_W{1'b0}};
            held      <= {HELD_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
