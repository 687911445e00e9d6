// SPDX-License-Identifier: Apache-2.0
// Ticks from the events' own times: each event carries floor((t - t0) / tick_us) ticks, less those before it.
//
// t0 is the time of the first event since reset. An event whose time runs backwards is kept, with the latest time so far, and
// counted. Ticks that do not fit into one token are sent ahead in tokens without event.
//
// Latency:    4 clocks from s_ to m_.
// Throughput: 1 event per clock if tick_us is 1, or while less than a tick passes between events; T_W + 3 clocks for an event
//             after a longer time (a division), and 1 for each token without event.
// Stall:      a token is held until accepted.
// Reset:      becomes empty; the next event sets t0.
// Combinational paths: none; m_ and s_ready come from registers.
`default_nettype none

module stamp_ticks #(
    parameter T_W     = 48,  // bits of a time, 32..64, enough for a whole run
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter TICK_W  = 20,  // bits of a token's ticks
    parameter COUNT_W = 32   // bits of a counter
) (
    input  wire               clk,
    input  wire               rst,

    input  wire [19:0]        tick_us,  // microseconds of a tick; 0 is taken as 1. Change it under reset alone

    // events in
    input  wire               s_valid,
    output wire               s_ready,
    input  wire [T_W-1:0]     s_t,
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

    output reg  [COUNT_W-1:0] n_backward,  // events whose time ran back
    output wire               idle         // nothing inside
);

    parameter_check #(.OK(T_W >= 32 && T_W <= 64)) T_W_must_be_32_to_64 ();
    parameter_check #(.OK(COUNT_W >= 8 && COUNT_W <= 64)) COUNT_W_must_be_8_to_64 ();

    localparam TICK_US_W = 20;
    localparam NEAR_W = TICK_US_W + 2;  // bits of sums of times of less than a tick, signed

    reg  every_us;  // a tick is a microsecond
    wire near_ready, near_leaves;

    always @(posedge clk) every_us <= tick_us <= 20'd1;

    // ---- how long after the latest event? ----------------------------------------------------------------------------

    reg                begun;
    reg  [T_W-1:0]     latest;
    wire [T_W:0]       since = {1'b0, s_t} - {1'b0, latest};
    wire               backward = begun && since[T_W];

    wire               valid, later, p;  // later: than the latest one
    wire [T_W-1:0]     ahead;            // by how many microseconds, if so
    wire [X_W-1:0]     x;
    wire [Y_W-1:0]     y;
    reg                behind;

    // Ends the path of s_ready.
    skid_buffer #(
        .W(1 + T_W + X_W + Y_W + 1)
    ) u_since (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_valid),
        .s_ready(s_ready),
        .s_data ({begun && !backward, since[T_W-1:0], s_x, s_y, s_p}),
        .m_valid(valid),
        .m_ready(near_ready),
        .m_data ({later, ahead, x, y, p})
    );

    always @(posedge clk) begin
        if (s_valid && s_ready) begin
            begun <= 1'b1;
            if (!backward) latest <= s_t;
        end
        behind <= s_valid && s_ready && backward;
        if (behind) n_backward <= n_backward + 1'b1;
        if (rst) begin
            begun      <= 1'b0;
            behind     <= 1'b0;
            n_backward <= {COUNT_W{1'b0}};
        end
    end

    // ---- that time, and what a tick leaves of it ---------------------------------------------------------------------

    reg                near_valid, near_p, divides;
    reg  [T_W-1:0]     near_passed;
    reg  [NEAR_W-1:0]  less_one;
    reg  [X_W-1:0]     near_x;
    reg  [Y_W-1:0]     near_y;

    wire [T_W-1:0]     passed   = later ? ahead : {T_W{1'b0}};
    reg  [NEAR_W-1:0]  less_none;  // what a tick leaves where nothing has passed: minus tick_us
    wire [T_W:0]       less_now = {1'b0, ahead} + {{(T_W + 1 - NEAR_W) {1'b1}}, less_none};

    assign near_ready = !near_valid || near_leaves;

    always @(posedge clk) begin
        less_none <= {NEAR_W{1'b0}} - {2'b00, tick_us};
        if (near_ready) begin
            near_valid  <= valid;
            near_passed <= passed;
            divides     <= valid && later && !every_us && !less_now[T_W];
            less_one    <= later ? less_now[NEAR_W-1:0] : less_none;
            near_x      <= x;
            near_y      <= y;
            near_p      <= p;
        end
        if (rst) {near_valid, divides} <= 2'b00;
    end

    // ---- how many ticks? After less than one, one or none: that needs no division. -----------------------------------

    reg  [TICK_US_W-1:0] rest;  // microseconds since the last tick
    wire [NEAR_W-1:0]    after_none = {2'd0, rest} + {2'b00, near_passed[TICK_US_W-1:0]};
    wire [NEAR_W-1:0]    after_one  = {2'd0, rest} + less_one;
    wire                 none       = after_one[NEAR_W-1];

    wire                 quotient_valid, output_ready, output_idle, unused_ready;
    wire [T_W:0]         quotient;
    wire [TICK_US_W-1:0] remainder;
    reg                  dividing;

    divider #(
        .NUM_W(T_W + 1),
        .DEN_W(TICK_US_W)
    ) u_divider (
        .clk    (clk),
        .rst    (rst),
        .s_valid(divides && !dividing),
        .s_ready(unused_ready),
        .s_num  ({1'b0, near_passed} + {{(T_W + 1 - TICK_US_W) {1'b0}}, rest}),
        .s_den  (tick_us),
        .m_valid(quotient_valid),
        .m_ready(output_ready),
        .m_quot (quotient),
        .m_rem  (remainder)
    );

    wire ready_to_go = near_valid && (!divides || quotient_valid);
    assign near_leaves = ready_to_go && output_ready;

    always @(posedge clk) begin
        dividing <= divides && !near_leaves;
        if (near_leaves)
            rest <= every_us ? {TICK_US_W{1'b0}} : quotient_valid ? remainder
                  : none ? after_none[TICK_US_W-1:0] : after_one[TICK_US_W-1:0];
        if (rst) begin
            dividing <= 1'b0;
            rest     <= {TICK_US_W{1'b0}};
        end
    end

    tick_splitter #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .WIDE_W(T_W),
        .TICK_W(TICK_W)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(ready_to_go),
        .s_ready(output_ready),
        .s_tick (every_us ? near_passed : quotient_valid ? quotient[T_W-1:0] : {{(T_W - 1) {1'b0}}, !none}),
        .s_event(1'b1),
        .s_skip (1'b0),
        .s_x    (near_x),
        .s_y    (near_y),
        .s_p    (near_p),
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

    assign idle = !valid && !near_valid && output_idle;

    wire unused = &{1'b0, quotient[T_W], after_none[NEAR_W-1:TICK_US_W], after_one[NEAR_W-2:TICK_US_W]};

endmodule

`default_nettype wire
