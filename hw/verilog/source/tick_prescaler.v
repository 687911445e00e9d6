// SPDX-License-Identifier: Apache-2.0
// Ticks from a prescaler: one every `prescale` clocks, merged with the events in the order of their arrival.
//
// An event carries the ticks of all clocks before the one in which it is accepted, less those already sent. Ticks are sent as
// soon as possible, with or without an event, and accumulate while the output stalls: none is lost within 2^48.
//
// Latency:    2 clocks from s_ to m_, 3 from a tick.
// Throughput: 1 token per clock; ticks that do not fit into one token take one more for every 2^TICK_W - 1.
// Stall:      a token is held until accepted. An event that has to wait gets the time at which it is accepted.
// Reset:      becomes empty, the prescaler starts over.
// Combinational paths: none; m_ and s_ready come from registers.
`default_nettype none

module tick_prescaler #(
    parameter X_W        = 9,   // bits of an x address
    parameter Y_W        = 9,   // bits of a y address
    parameter TICK_W     = 20,  // bits of a token's ticks
    parameter PRESCALE_W = 16   // bits of prescale, at least 1
) (
    input  wire                  clk,
    input  wire                  rst,

    input  wire [PRESCALE_W-1:0] prescale,  // clocks of a tick; 0: time stands still

    // events in
    input  wire                  s_valid,
    output wire                  s_ready,
    input  wire [X_W-1:0]        s_x,
    input  wire [Y_W-1:0]        s_y,
    input  wire                  s_p,

    // tokens out
    output wire                  m_valid,
    input  wire                  m_ready,
    output wire [TICK_W-1:0]     m_tick,
    output wire                  m_event,
    output wire                  m_skip,
    output wire [X_W-1:0]        m_x,
    output wire [Y_W-1:0]        m_y,
    output wire                  m_p,

    output wire                  idle  // no token inside; ticks that have not become one do not count
);

    localparam WAITING_W = 48;

    reg  [WAITING_W-1:0] waiting;  // ticks that no token carries yet
    wire                 tick;
    wire                 token_valid = s_valid || waiting != {WAITING_W{1'b0}};

    prescaler #(
        .W(PRESCALE_W)
    ) u_prescaler (
        .clk   (clk),
        .rst   (rst),
        .period(prescale),
        .pulse (tick)
    );

    tick_splitter #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .WIDE_W(WAITING_W),
        .TICK_W(TICK_W)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(token_valid),
        .s_ready(s_ready),
        .s_tick (waiting),
        .s_event(s_valid),
        .s_skip (1'b0),
        .s_x    (s_x),
        .s_y    (s_y),
        .s_p    (s_p),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_tick (m_tick),
        .m_event(m_event),
        .m_skip (m_skip),
        .m_x    (m_x),
        .m_y    (m_y),
        .m_p    (m_p),
        .idle   (idle)
    );

    always @(posedge clk) begin
        if (s_ready) waiting <= {{(WAITING_W - 1) {1'b0}}, tick};
        else if (tick) waiting <= waiting + 1'b1;
        if (rst) waiting <= {WAITING_W{1'b0}};
    end

endmodule

`default_nettype wire
