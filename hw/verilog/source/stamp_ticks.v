// SPDX-License-Identifier: Apache-2.0
// Ticks from the events' own times: each event carries floor((t - t0) / tick_us) ticks, less those before it.
//
// t0 is the time of the first event since reset. An event whose time runs backwards is kept, with the latest time so far, and
// counted. With `off`, every event carries 0 ticks and no time is compared.
//
// Latency:    1 clock from s_ to m_; 3 with DIVIDES.
// Throughput: 1 event per clock if a tick is 1 us, or while less than two ticks pass between events; T_W + 3 clocks for an event
//             after a longer time (a division).
// Stall:      an event is held until accepted.
// Reset:      becomes empty; the next event sets t0.
// Combinational paths: none with DIVIDES; without, m_ready -> s_ready.
`default_nettype none

module stamp_ticks #(
    parameter T_W     = 48,  // bits of a time and of its ticks, 32..64, enough for a whole run
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter DIVIDES = 1,   // 0: a tick is 1 us, without divider
    parameter COUNT_W = 32   // bits of a counter
) (
    input  wire               clk,
    input  wire               rst,

    // change both under reset alone
    input  wire               off,      // no ticks
    input  wire [19:0]        tick_us,  // microseconds of a tick; 0 is taken as 1

    // events in
    input  wire               s_valid,
    output wire               s_ready,
    input  wire [T_W-1:0]     s_t,
    input  wire [X_W-1:0]     s_x,
    input  wire [Y_W-1:0]     s_y,
    input  wire               s_p,

    // events with ticks out
    output wire               m_valid,
    input  wire               m_ready,
    output wire [T_W-1:0]     m_tick,
    output wire [X_W-1:0]     m_x,
    output wire [Y_W-1:0]     m_y,
    output wire               m_p,

    output reg  [COUNT_W-1:0] n_backward,  // events whose time ran back
    output wire               idle         // nothing inside
);

    parameter_check #(.OK(T_W >= 32 && T_W <= 64)) T_W_must_be_32_to_64 ();
    parameter_check #(.OK(DIVIDES == 0 || DIVIDES == 1)) DIVIDES_must_be_0_or_1 ();
    parameter_check #(.OK(COUNT_W >= 8 && COUNT_W <= 64)) COUNT_W_must_be_8_to_64 ();

    localparam TICK_US_W = 20;
    localparam NEAR_W = TICK_US_W + 2;  // bits of sums of times of less than a tick, signed

    // ---- microseconds since the latest event -------------------------------------------------------------------------

    reg            begun;
    reg  [T_W-1:0] latest;
    wire [T_W:0]   since = {1'b0, s_t} - {1'b0, latest};
    wire           backward = begun && since[T_W];
    wire           takes = s_valid && s_ready;

    reg            since_valid, since_p;
    reg  [T_W-1:0] passed;
    reg  [X_W-1:0] since_x;
    reg  [Y_W-1:0] since_y;
    reg            behind;
    wire           since_leaves;

    assign s_ready = since_leaves || !since_valid;

    always @(posedge clk) begin
        if (takes) begin
            begun <= !off;
            if (!backward) latest <= s_t;
        end
        behind <= takes && backward;
        if (behind) n_backward <= n_backward + 1'b1;
        if (s_ready) begin
            since_valid <= s_valid;
            passed      <= since[T_W-1:0];
            since_x     <= s_x;
            since_y     <= s_y;
            since_p     <= s_p;
            if (!begun || backward) passed <= {T_W{1'b0}};
        end
        if (rst) begin
            begun       <= 1'b0;
            behind      <= 1'b0;
            since_valid <= 1'b0;
            n_backward  <= {COUNT_W{1'b0}};
        end
    end

    generate
        if (DIVIDES == 0) begin : g_microseconds
            assign since_leaves = m_ready;
            assign m_valid      = since_valid;
            assign m_tick       = passed;
            assign {m_x, m_y, m_p} = {since_x, since_y, since_p};
            assign idle         = !since_valid;

            wire unused = &{1'b0, tick_us};
        end else begin : g_divided
            // ---- that time less a tick -------------------------------------------------------------------------------

            reg                every_us;  // a tick is a microsecond
            reg                near_valid, near_p, divides;
            reg  [T_W-1:0]     near_passed;
            reg  [NEAR_W-1:0]  less_one;
            reg  [X_W-1:0]     near_x;
            reg  [Y_W-1:0]     near_y;
            reg  [T_W:0]       minus_tick;
            wire [T_W:0]       less_now = {1'b0, passed} + minus_tick;
            wire               near_leaves;

            assign since_leaves = near_leaves || !near_valid;

            always @(posedge clk) begin
                every_us   <= tick_us <= 20'd1;
                minus_tick <= {(T_W + 1) {1'b0}} - {{(T_W + 1 - TICK_US_W) {1'b0}}, tick_us};
                if (since_leaves) begin
                    near_valid  <= since_valid;
                    near_passed <= passed;
                    divides     <= since_valid && !every_us && !less_now[T_W];
                    less_one    <= less_now[NEAR_W-1:0];
                    near_x      <= since_x;
                    near_y      <= since_y;
                    near_p      <= since_p;
                end
                if (rst) {near_valid, divides} <= 2'b00;
            end

            // ---- how many ticks? After less than one, one or none: that needs no division. ---------------------------

            reg  [TICK_US_W-1:0] rest;  // microseconds since the last tick
            wire [NEAR_W-1:0]    after_none = {2'd0, rest} + {2'b00, near_passed[TICK_US_W-1:0]};
            wire [NEAR_W-1:0]    after_one  = {2'd0, rest} + less_one;
            wire                 none       = after_one[NEAR_W-1];

            wire                 quotient_valid, unused_ready, counted, counted_ready;
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
                .m_ready(counted_ready),
                .m_quot (quotient),
                .m_rem  (remainder)
            );

            assign counted     = near_valid && (!divides || quotient_valid);
            assign near_leaves = counted && counted_ready;
            assign idle        = !since_valid && !near_valid && !m_valid;

            skid_buffer #(
                .W(T_W + X_W + Y_W + 1)
            ) u_output (
                .clk    (clk),
                .rst    (rst),
                .s_valid(counted),
                .s_ready(counted_ready),
                .s_data ({every_us ? near_passed : quotient_valid ? quotient[T_W-1:0] : {{(T_W - 1) {1'b0}}, !none},
                          near_x, near_y, near_p}),
                .m_valid(m_valid),
                .m_ready(m_ready),
                .m_data ({m_tick, m_x, m_y, m_p})
            );

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

            wire unused = &{1'b0, quotient[T_W], after_none[NEAR_W-1:TICK_US_W], after_one[NEAR_W-2:TICK_US_W]};
        end
    endgenerate

endmodule

`default_nettype wire
