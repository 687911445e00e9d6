// SPDX-License-Identifier: Apache-2.0
// The published tracker: one cluster, 4-phase handshakes, and the arithmetic of the hardware that the paper was measured on,
// with all its deviations from the paper. docs/published.md is its contract; use cot.v unless you need to match that hardware.
//
// Latency:    clocks from the one before the edge that first sees the request, every output acknowledged at once: acknowledge
//             1, event out (owned or rejected) 3, centre out 7; the N-th event is output before its centre, at 6.
// Throughput: idle again after 4 clocks, or 8 after a centre.
// Stall:      an output waits until it is acknowledged; an event, until its request is released, too. The average is updated
//             at every clock of such a wait.
// Reset:      leads to INIT_CELL, as does the end of a life: it acknowledges every request and drops the event.
//             Registers must not change except under reset.
// Combinational paths: s_high, s_low -> m_pass_high, m_pass_low, which are wires. All other outputs depend on registers alone.
`default_nettype none

module cot_published (
    input  wire        clk,
    input  wire        rst,

    // registers
    input  wire [7:0]  init_cm_high,
    input  wire [7:0]  init_cm_low,
    input  wire [7:0]  init_radix,
    input  wire [2:0]  radix_th,
    input  wire [2:0]  radix_step,
    input  wire [7:0]  radix_min,
    input  wire [7:0]  radix_max,
    input  wire [31:0] max_time,       // clocks
    input  wire [7:0]  nev_th,
    input  wire [3:0]  hist_avg,       // 1..8

    // events
    input  wire        s_req_n,
    output wire        s_ack_n,
    input  wire [7:0]  s_high,
    input  wire [7:0]  s_low,

    // events outside the window
    output wire        m_pass_req_n,
    input  wire        m_pass_ack_n,
    output wire [7:0]  m_pass_high,
    output wire [7:0]  m_pass_low,

    // events of the cluster
    output wire        m_event_req_n,
    input  wire        m_event_ack_n,
    output wire [7:0]  m_event_high,
    output wire [7:0]  m_event_low,

    // its centres
    output wire        m_centre_req_n,
    input  wire        m_centre_ack_n,
    output wire [7:0]  m_centre_high,
    output wire [7:0]  m_centre_low
);

    localparam [3:0] INIT_CELL    = 4'd0;
    localparam [3:0] IDLE         = 4'd1;
    localparam [3:0] REQ_RECEIVED = 4'd2;
    localparam [3:0] EV_DISCRI    = 4'd3;
    localparam [3:0] EV_PASS_TH   = 4'd4;
    localparam [3:0] EV_NO_PROC   = 4'd5;
    localparam [3:0] EV_PROC      = 4'd6;   // radius
    localparam [3:0] PROC_TIMING  = 4'd7;
    localparam [3:0] PROC_NEV     = 4'd8;
    localparam [3:0] PROC_CENTRE  = 4'd9;
    localparam [3:0] PROC_SEND    = 4'd10;

    localparam [2:0] QUIET_TOP    = 3'd7;   // quiet updates after which the next one shrinks the window

    reg [3:0]  state;

    reg [7:0]  ev_high, ev_low;             // the event being decided
    reg [7:0]  lo_high, hi_high, lo_low, hi_low;
    reg        inside_window;

    reg [7:0]  cm_high, cm_low, av_high, av_low;
    reg [7:0]  g;
    reg [7:0]  n_ev, count;
    reg        updated;                     // this life has had a centre update
    reg [2:0]  quiet;

    reg [31:0] tc;                          // clocks since the last centre update
    reg        expired;                     // tc was max_time since the life began
    reg [31:0] tc2;                         // clocks since the life began
    reg [31:0] tc2_1, tc2_2;                // what it was one and two updates ago
    reg [31:0] diff, last_diff;

    // ---- handshakes ------------------------------------------------------------------------------------------------

    assign s_ack_n        = state == IDLE || state == PROC_SEND;
    assign m_pass_req_n   = state != EV_PASS_TH;
    assign m_pass_high    = s_high;
    assign m_pass_low     = s_low;
    assign m_event_req_n  = state != EV_NO_PROC && state != PROC_CENTRE;
    assign m_event_high   = ev_high;
    assign m_event_low    = ev_low;
    assign m_centre_req_n = state != PROC_SEND;
    assign m_centre_high  = cm_high;
    assign m_centre_low   = cm_low;

    // ---- window: registered while idle, its ends and so the addresses 0 and 255 left out ---------------------------

    wire [8:0] radius   = {1'b0, g} + {6'd0, radix_th};
    wire [8:0] top_high = {1'b0, cm_high} + radius;  // 9 bits: wraps at 512
    wire [8:0] top_low  = {1'b0, cm_low} + radius;

    wire is_inside = ev_high > lo_high && ev_high < hi_high && ev_low > lo_low && ev_low < hi_low;

    // ---- average and centre: one step towards a target per axis ----------------------------------------------------

    wire       moves = state == PROC_CENTRE;
    wire [7:0] next_high, next_low;

    approach #(
        .W   (8),
        .FRAC(0)
    ) u_approach_high (
        .value (moves ? cm_high : av_high),
        .target(moves ? av_high : ev_high),
        .k     (hist_avg),
        .result(next_high)
    );
    approach #(
        .W   (8),
        .FRAC(0)
    ) u_approach_low (
        .value (moves ? cm_low : av_low),
        .target(moves ? av_low : ev_low),
        .k     (hist_avg),
        .result(next_low)
    );

    // ---- radius ----------------------------------------------------------------------------------------------------

    // The far end of the low coordinate never counts.
    wire beyond = {1'b0, ev_high} + {1'b0, g} < {1'b0, cm_high} || {1'b0, ev_high} > {1'b0, cm_high} + {1'b0, g}
               || {1'b0, ev_low} + {1'b0, g} < {1'b0, cm_low};
    wire [8:0] grown = {1'b0, g} + {6'd0, radix_step};
    wire       undershoots = {1'b0, g} < {1'b0, radix_min} + {6'd0, radix_step};

    // ---- N_ev ------------------------------------------------------------------------------------------------------

    wire slower = diff > {last_diff[30:0], 1'b0};  // the doubled difference loses its highest bit
    wire faster = diff < {1'b0, last_diff[31:1]};

    // ---- FSM -------------------------------------------------------------------------------------------------------

    wire event_done = !m_event_ack_n && s_req_n;

    always @(posedge clk) begin
        tc      <= (state == EV_PROC) ? 32'd0 : tc + 32'd1;
        tc2     <= (state == INIT_CELL) ? 32'd0 : tc2 + 32'd1;
        expired <= state != INIT_CELL && (expired || tc == max_time);

        case (state)
            // Acknowledges, and waits until there is no request.
            INIT_CELL: begin
                cm_high   <= init_cm_high;
                cm_low    <= init_cm_low;
                av_high   <= init_cm_high;
                av_low    <= init_cm_low;
                g         <= init_radix;
                n_ev      <= nev_th;
                count     <= 8'd0;
                updated   <= 1'b0;
                quiet     <= 3'd0;
                tc2_1     <= 32'd0;
                tc2_2     <= 32'd0;
                last_diff <= 32'd0;
                if (s_req_n) state <= IDLE;
            end

            // Waits for the end of the life, or for a request once the last centre's acknowledge is released.
            IDLE: begin
                ev_high <= s_high;
                ev_low  <= s_low;
                lo_high <= ({1'b0, cm_high} > radius) ? cm_high - radius[7:0] : 8'd0;
                lo_low  <= ({1'b0, cm_low} > radius) ? cm_low - radius[7:0] : 8'd0;
                hi_high <= top_high[8] ? 8'd255 : top_high[7:0];
                hi_low  <= top_low[8] ? 8'd255 : top_low[7:0];
                if (expired) state <= INIT_CELL;
                else if (!s_req_n && m_centre_ack_n) state <= REQ_RECEIVED;
            end

            REQ_RECEIVED: begin
                inside_window <= is_inside;
                count  <= count + {7'd0, is_inside};
                state  <= EV_DISCRI;
            end

            EV_DISCRI: state <= !inside_window ? EV_PASS_TH : (count >= n_ev) ? EV_PROC : EV_NO_PROC;

            // Offers the event to the next tracker until it is acknowledged and its own request is released.
            EV_PASS_TH: if (!m_pass_ack_n && s_req_n) state <= IDLE;

            // Offers the event, and waits likewise; the average takes it in at every clock of the wait.
            EV_NO_PROC: begin
                av_high <= next_high;
                av_low  <= next_low;
                if (event_done) state <= IDLE;
            end

            // A life that has ended ends here, too, with its update.
            EV_PROC: begin
                count   <= 8'd0;
                updated <= 1'b1;
                if (!updated) g <= init_radix;
                else if (beyond) begin
                    g     <= (grown > {1'b0, radix_max}) ? radix_max : grown[7:0];
                    quiet <= 3'd0;
                end else if (quiet == QUIET_TOP) begin
                    g     <= undershoots ? radix_min : g - {5'd0, radix_step};
                    quiet <= 3'd0;
                end else quiet <= quiet + 3'd1;
                state <= expired ? INIT_CELL : PROC_TIMING;
            end

            PROC_TIMING: begin
                if (tc2 > tc2_2) diff <= tc2 - tc2_2;
                tc2_1 <= tc2;
                tc2_2 <= tc2_1;
                state <= PROC_NEV;
            end

            PROC_NEV: begin
                if (slower && n_ev > 8'd1) n_ev <= {1'b0, n_ev[7:1]};
                else if (faster && n_ev < 8'd128) n_ev <= {n_ev[6:0], 1'b0};
                else if (n_ev <= 8'd1) n_ev <= 8'd2;
                else if (n_ev >= 8'd128) n_ev <= 8'd255;
                last_diff <= diff;
                state     <= PROC_CENTRE;
            end

            // Offers the N-th event as those before it, then moves the centre once.
            PROC_CENTRE: if (event_done) begin
                cm_high <= next_high;
                cm_low  <= next_low;
                state   <= PROC_SEND;
            end

            // Offers the centre until it is acknowledged.
            PROC_SEND: if (!m_centre_ack_n) state <= IDLE;

            default: state <= INIT_CELL;
        endcase

        if (rst) begin
            state   <= INIT_CELL;
            tc      <= 32'd0;
            expired <= 1'b0;
        end
    end

endmodule

`default_nettype wire
