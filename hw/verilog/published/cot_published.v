// SPDX-License-Identifier: Apache-2.0
// The published tracker: one cluster, 4-phase handshakes, and the arithmetic of the hardware that the paper was measured on,
// with all its deviations from the paper. docs/published.md is its contract; use cot.v unless you need to match that hardware.
//
// Clocks from the one before the edge that first sees the request, every output acknowledged at once: acknowledge 1, event
// out (owned or rejected) 3, centre out 7, idle again 4, or 8 after a centre. An output waits until it is acknowledged, and
// the tracker with it.
// Reset, and every new life, goes through INIT_CELL, which acknowledges every request and drops the event.
// Registers must not change except under reset. s_ack_n depends combinationally on s_req_n where the request is released late.
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
    input  wire [3:0]  hist_avg,

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

    // events of the cluster, and its centres
    output wire        m_req_n,
    input  wire        m_ack_n,
    output wire        m_event,        // 1: an event, 0: a centre
    output wire [7:0]  m_high,
    output wire [7:0]  m_low
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
    reg        taken;                       // the request that waits was served already: it only has to be released

    reg [7:0]  ev_high, ev_low;             // the event being decided
    reg [7:0]  lo_high, hi_high, lo_low, hi_low;
    reg        inside_window;

    reg [7:0]  cm_high, cm_low, av_high, av_low;
    reg [7:0]  g;
    reg [7:0]  n_ev, count;
    reg        updated;                     // this life has had a centre update
    reg [2:0]  quiet;

    reg [31:0] tc;                          // clocks since the last centre update
    reg [31:0] tc2;                         // clocks since the life began
    reg [31:0] tc2_1, tc2_2;                // what it was one and two updates ago
    reg [31:0] diff, last_diff;

    // ---- handshakes ------------------------------------------------------------------------------------------------

    assign s_ack_n      = !(state == INIT_CELL || state == REQ_RECEIVED || (taken && !s_req_n));
    assign m_pass_req_n = state != EV_PASS_TH;
    assign m_pass_high  = ev_high;
    assign m_pass_low   = ev_low;
    assign m_req_n      = state != EV_NO_PROC && state != PROC_SEND;
    assign m_event      = state == EV_NO_PROC;
    assign m_high       = m_event ? ev_high : cm_high;
    assign m_low        = m_event ? ev_low : cm_low;

    // ---- window: registered while idle, its ends and so the addresses 0 and 255 left out ---------------------------

    wire [8:0] radius = {1'b0, g} + {6'd0, radix_th};
    wire [7:0] new_lo_high, new_hi_high, new_lo_low, new_hi_low, pixel_high, pixel_low;

    cot_window #(
        .W   (8),
        .FRAC(0),
        .R_W (9)
    ) u_window_high (
        .centre(cm_high),
        .radius(radius),
        .pixel (pixel_high),
        .lo    (new_lo_high),
        .hi    (new_hi_high)
    );
    cot_window #(
        .W   (8),
        .FRAC(0),
        .R_W (9)
    ) u_window_low (
        .centre(cm_low),
        .radius(radius),
        .pixel (pixel_low),
        .lo    (new_lo_low),
        .hi    (new_hi_low)
    );

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

    // The top edge (the far end of the high coordinate) never counts.
    wire beyond = {1'b0, ev_low} + {1'b0, g} < {1'b0, cm_low} || {1'b0, ev_low} > {1'b0, cm_low} + {1'b0, g}
               || {1'b0, ev_high} + {1'b0, g} < {1'b0, cm_high};
    wire [8:0] grown = {1'b0, g} + {6'd0, radix_step};
    wire       undershoots = {1'b0, g} < {1'b0, radix_min} + {6'd0, radix_step};

    // ---- N_ev ------------------------------------------------------------------------------------------------------

    wire slower = {1'b0, diff} > {last_diff, 1'b0};
    wire faster = diff < {1'b0, last_diff[31:1]};

    // ---- FSM -------------------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        taken <= !s_req_n && (taken || state == REQ_RECEIVED);
        tc    <= (state == EV_PROC) ? 32'd0 : tc + 32'd1;
        tc2   <= (state == INIT_CELL) ? 32'd0 : tc2 + 32'd1;

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

            // Waits for a request, or for the clock at which TC is exactly MaxTime.
            IDLE: begin
                ev_high <= s_high;
                ev_low  <= s_low;
                lo_high <= new_lo_high;
                hi_high <= new_hi_high;
                lo_low  <= new_lo_low;
                hi_low  <= new_hi_low;
                if (tc == max_time) state <= INIT_CELL;
                else if (!s_req_n && !taken) state <= REQ_RECEIVED;
            end

            REQ_RECEIVED: begin
                inside_window <= is_inside;
                count  <= count + {7'd0, is_inside};
                state  <= EV_DISCRI;
            end

            EV_DISCRI: state <= !inside_window ? EV_PASS_TH : (count >= n_ev) ? EV_PROC : EV_NO_PROC;

            // Offers the event to the next tracker until it is acknowledged.
            EV_PASS_TH: if (!m_pass_ack_n) state <= IDLE;

            // Offers the event until it is acknowledged; the average takes it in at every clock of the wait.
            EV_NO_PROC: begin
                av_high <= next_high;
                av_low  <= next_low;
                if (!m_ack_n) state <= IDLE;
            end

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
                state <= PROC_TIMING;
            end

            PROC_TIMING: begin
                diff  <= tc2 - tc2_2;
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

            PROC_CENTRE: begin
                cm_high <= next_high;
                cm_low  <= next_low;
                state   <= PROC_SEND;
            end

            // Offers the centre until it is acknowledged.
            PROC_SEND: if (!m_ack_n) state <= IDLE;

            default: state <= INIT_CELL;
        endcase

        if (rst) begin
            state <= INIT_CELL;
            taken <= 1'b0;
            tc    <= 32'd0;
        end
    end

    wire unused = &{1'b0, pixel_high, pixel_low};

endmodule

`default_nettype wire
