// SPDX-License-Identifier: Apache-2.0
// Converts tokens with wide ticks to ticks of TICK_W bits: of ticks that do not fit, 2^(TICK_W - 1) at a time are sent ahead in tokens
// without event.
//
// Latency:    2 clocks from s_ to m_.
// Throughput: 1 output token per clock.
// Stall:      a token is held until accepted.
// Reset:      becomes empty.
// Combinational paths: none; m_ and s_ready come from registers.
`default_nettype none
`include "evcot_defs.vh"

module tick_splitter #(
    parameter X_W    = 9,   // bits of an x address
    parameter Y_W    = 9,   // bits of a y address
    parameter WIDE_W = 48,  // bits of the ticks that come in, at least TICK_W
    parameter TICK_W = 20   // bits of the ticks that go out
) (
    input  wire              clk,
    input  wire              rst,

    // tokens in
    input  wire              s_valid,
    output wire              s_ready,
    input  wire [WIDE_W-1:0] s_tick,
    input  wire              s_event,
    input  wire              s_skip,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    input  wire              s_p,

    // tokens out
    output wire              m_valid,
    input  wire              m_ready,
    output wire [TICK_W-1:0] m_tick,
    output wire              m_event,
    output wire              m_skip,
    output wire [X_W-1:0]    m_x,
    output wire [Y_W-1:0]    m_y,
    output wire              m_p,

    output wire              idle  // nothing inside
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(WIDE_W >= TICK_W)) WIDE_W_must_be_at_least_TICK_W ();

    localparam [TICK_W-1:0] HALF   = {TICK_W{1'b1}} ^ ({TICK_W{1'b1}} >> 1);  // ticks of a token that goes ahead
    localparam              HIGH_W = WIDE_W - TICK_W + 1;  // bits of the number of halves

    reg              valid, is_event, is_skip, p;
    reg [WIDE_W-1:0] left;  // ticks that have not gone out
    reg [X_W-1:0]    x;
    reg [Y_W-1:0]    y;

    wire output_ready;

    // More ticks are left than a token holds, that is, more than one half, and will be when one has gone. In two parts, so that no
    // path from the ticks that come looks at more than half of the bits beyond.
    localparam BEYOND_W = WIDE_W - TICK_W;
    localparam SPLIT_W  = BEYOND_W / 2;

    reg               more_low, more_high;
    wire              more = more_low || more_high;
    wire [WIDE_W+1:0] beyond = {2'b00, s_tick} >> TICK_W;
    wire [HIGH_W-1:0] halves = left[WIDE_W-1 -: HIGH_W];
    wire [HIGH_W+1:0] wide_halves = {2'b00, halves};

    assign s_ready = !valid || (output_ready && !more);

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(valid),
        .s_ready(output_ready),
        .s_data ({more ? HALF : left[TICK_W-1:0], is_event && !more, is_skip && !more, x, y, p}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign idle = !valid && !m_valid;

    always @(posedge clk) begin
        if (output_ready && more) begin
            left[WIDE_W-1 -: HIGH_W] <= halves - 1'b1;
            more_low  <= &wide_halves[1:0];
            more_high <= wide_halves[HIGH_W+1:2] != {HIGH_W{1'b0}};
        end
        if (s_ready) begin
            more_low  <= (beyond & ~({(WIDE_W + 2) {1'b1}} << SPLIT_W)) != {(WIDE_W + 2) {1'b0}};
            more_high <= (beyond >> SPLIT_W) != {(WIDE_W + 2) {1'b0}};
            valid     <= s_valid;
            left      <= s_tick;
            is_event  <= s_event;
            is_skip   <= s_skip;
            x         <= s_x;
            y         <= s_y;
            p         <= s_p;
        end
        if (rst) begin
            valid <= 1'b0;
            {more_low, more_high} <= 2'b00;
        end
    end

endmodule

`default_nettype wire
