// SPDX-License-Identifier: Apache-2.0
// All sources of events that are built; outputs the events of the selected one as tokens, behind the input FIFO.
//
//     events, EVT 2.0, 2.1, 3.0 on one AXI4-Stream; AER; LFSR  ->  the selected one  ->  ticks  ->  overload_fifo
//
// If there are several sources, the multiplexer is followed by a skid buffer, which ends its paths.
//
// Ticks come from the events' own time (stamp_ticks) or from the clock (prescaler): then an event carries the ticks up to the clock in
// which it enters the FIFO. The time of an event of the LFSR is that of its software model,
// sw/evcot/hardware/lfsr_event_source.py: a microsecond per step. Settings may change under reset only.
//
// Latency:    the sum of the parts of the selected source; from a beat of `events` 9 clocks to m_, 2 more for a divider,
//             1 more for several sources.
// Throughput: an event per clock, where source and ticks keep up.
// Stall:      a token is held until accepted; with drop what does not fit is dropped and counted. A source that is not selected accepts
//             nothing.
// Reset:      becomes empty; the AER handshake continues, unless aer_rst is high.
// Combinational paths: rst, and without a divider drop, -> s_axis_tready; active_low -> aer_ack.
`default_nettype none
`include "evcot_regs.vh"

module event_sources #(
    parameter SOURCES = 1,    // sources to build, a bit each: EVCOT_SOURCE_*
    parameter TICKS   = 3,    // what a tick may be, besides 1 us of the events' time, a bit each: 1 tick_us of it, 2 a time of the clock
    parameter X_W     = 9,    // bits of an x address
    parameter Y_W     = 9,    // bits of a y address
    parameter TICK_W  = 20,   // bits of the ticks in a token
    parameter WIDTH   = 346,  // pixels of the sensor across
    parameter HEIGHT  = 260,  // pixels of the sensor down
    parameter DEPTH   = 256   // tokens in the input FIFO
) (
    input  wire              clk,
    input  wire              rst,            // of all but the handshake with an AER chip
    input  wire              aer_rst,        // of the handshake; with rst

    // settings
    input  wire [2:0]        select,
    input  wire              clock_time,
    input  wire              swap_bytes,
    input  wire              swap_halves,
    input  wire              active_low,
    input  wire              word_serial,
    input  wire [19:0]       tick_us,
    input  wire [15:0]       prescale_tick,
    input  wire [15:0]       prescale_us,
    input  wire [31:0]       lfsr_seed,
    input  wire [15:0]       lfsr_gap,
    input  wire [X_W-1:0]    lfsr_x_min,
    input  wire [X_W-1:0]    lfsr_x_span,
    input  wire [Y_W-1:0]    lfsr_y_min,
    input  wire [Y_W-1:0]    lfsr_y_span,

    input  wire              drop,           // a full FIFO drops events

    input  wire              s_axis_tvalid,
    output wire              s_axis_tready,
    input  wire [63:0]       s_axis_tdata,
    input  wire [7:0]        s_axis_tkeep,
    input  wire              s_axis_tlast,

    input  wire              aer_req,
    output wire              aer_ack,
    input  wire              aer_row,
    input  wire [X_W+Y_W:0]  aer_data,

    output wire              m_valid,
    input  wire              m_ready,
    output wire [TICK_W-1:0] m_tick,
    output wire              m_event,
    output wire              m_skip,
    output wire [X_W-1:0]    m_x,
    output wire [Y_W-1:0]    m_y,
    output wire              m_p,

    output wire              dropped,        // an event, this clock
    output wire [31:0]       n_in,
    output wire [31:0]       n_dropped,
    output reg  [31:0]       n_malformed,
    output wire [31:0]       n_backward,
    output wire [15:0]       held,
    output wire              idle            // no event inside
);

    parameter_check #(.OK(SOURCES >= 1 && SOURCES < (2 << `EVCOT_SOURCE_EVT3))) SOURCES_must_be_1_to_63 ();
    parameter_check #(.OK(TICKS >= 0 && TICKS <= 3)) TICKS_must_be_0_to_3 ();

    localparam T_W = 48;
    localparam K   = `EVCOT_SOURCE_EVT3 + 1;
    localparam [31:0]  MASK  = SOURCES;
    localparam [K-1:0] BUILT = MASK[K-1:0];
    localparam SINGLE  = (SOURCES & (SOURCES - 1)) == 0 ? 1 : 0;
    localparam DIVIDES = TICKS % 2;
    localparam CLOCKED = TICKS / 2;

    // ---- the sources: event streams, each with a count of what it skipped ---------------------------------------------

    wire [K-1:0]     valid, ready, p, axis_ready, source_idle;
    wire [K*T_W-1:0] t;
    wire [K*X_W-1:0] x;
    wire [K*Y_W-1:0] y;
    wire [K*32-1:0]  skipped;
    wire [K-1:0]     chosen;

    // What was taken under reset would be lost.
    assign s_axis_tready = |(axis_ready & chosen) && !rst;

    genvar k;
    generate
        for (k = 0; k < K; k = k + 1) begin : g_none
            if (!BUILT[k]) begin : g_absent
                assign valid[k]           = 1'b0;
                assign t[k*T_W +: T_W]    = {T_W{1'b0}};
                assign x[k*X_W +: X_W]    = {X_W{1'b0}};
                assign y[k*Y_W +: Y_W]    = {Y_W{1'b0}};
                assign p[k]               = 1'b0;
                assign skipped[k*32 +: 32] = 32'd0;
                assign source_idle[k]     = 1'b1;
            end
            if (!BUILT[k] || k == `EVCOT_SOURCE_LFSR || k == `EVCOT_SOURCE_AER) begin : g_no_axis
                assign axis_ready[k] = 1'b0;
            end
        end

        if (BUILT[`EVCOT_SOURCE_EVENTS]) begin : g_events
            localparam S = `EVCOT_SOURCE_EVENTS;
            axis_events_in #(
                .T_W   (T_W),
                .X_W   (X_W),
                .Y_W   (Y_W),
                .WIDTH (WIDTH),
                .HEIGHT(HEIGHT)
            ) u_events (
                .clk          (clk),
                .rst          (rst),
                .s_axis_tvalid(s_axis_tvalid && chosen[S]),
                .s_axis_tready(axis_ready[S]),
                .s_axis_tdata (s_axis_tdata),
                .s_axis_tkeep (s_axis_tkeep),
                .s_axis_tlast (s_axis_tlast),
                .m_valid      (valid[S]),
                .m_ready      (ready[S]),
                .m_t          (t[S*T_W +: T_W]),
                .m_x          (x[S*X_W +: X_W]),
                .m_y          (y[S*Y_W +: Y_W]),
                .m_p          (p[S]),
                .n_skipped    (skipped[S*32 +: 32]),
                .idle         (source_idle[S])
            );
        end

        if (BUILT[`EVCOT_SOURCE_LFSR]) begin : g_lfsr
            localparam S      = `EVCOT_SOURCE_LFSR;
            localparam LFSR_W = (X_W + Y_W < 32) ? 32 : 40;

            localparam [31:0] COLUMNS = WIDTH, ROWS = HEIGHT;

            reg           loaded;
            reg [T_W-1:0] steps, steps_before;
            reg [31:0]    n_outside;
            wire          drawn;  // an event, that may lie beyond the sensor
            wire          on_sensor = {{32 - X_W{1'b0}}, x[S*X_W +: X_W]} < COLUMNS && {{32 - Y_W{1'b0}}, y[S*Y_W +: Y_W]} < ROWS;
            wire          takes  = ready[S] || !on_sensor;
            wire          step   = chosen[S] && loaded && (takes || !drawn);
            wire          seed_error, done;
            wire [39:0]   seed = {8'd0, lfsr_seed};

            lfsr_event_source #(
                .X_W   (X_W),
                .Y_W   (Y_W),
                .GAP_W (16),
                .LFSR_W(LFSR_W)
            ) u_lfsr (
                .clk       (clk),
                .rst       (rst),
                .enable    (chosen[S] && loaded),
                .load      (!loaded),
                .seed      (seed[LFSR_W-1:0]),
                .seed_error(seed_error),
                .done      (done),
                .gap       (lfsr_gap),
                .x_min     (lfsr_x_min),
                .x_span    (lfsr_x_span),
                .y_min     (lfsr_y_min),
                .y_span    (lfsr_y_span),
                .m_valid   (drawn),
                .m_ready   (takes),
                .m_x       (x[S*X_W +: X_W]),
                .m_y       (y[S*Y_W +: Y_W]),
                .m_p       (p[S])
            );

            always @(posedge clk) begin
                loaded <= 1'b1;
                if (drawn && !on_sensor) n_outside <= n_outside + 1'b1;
                if (step) begin
                    steps        <= steps + 1'b1;
                    steps_before <= steps;
                end
                if (rst) begin
                    loaded    <= 1'b0;
                    steps     <= {T_W{1'b0}};
                    n_outside <= 32'd0;
                end
            end

            assign valid[S]            = drawn && on_sensor;
            assign t[S*T_W +: T_W]     = steps_before;
            assign skipped[S*32 +: 32] = n_outside;
            assign source_idle[S]      = !drawn;
            wire unused_lfsr = &{1'b0, seed_error, done, seed};
        end

        if (BUILT[`EVCOT_SOURCE_AER]) begin : g_aer
            localparam S = `EVCOT_SOURCE_AER;
            wire [T_W-1:0] t_us;
            wire [31:0]    n_events, n_outside, n_rowless;

            clock_us #(
                .T_W       (T_W),
                .PRESCALE_W(16)
            ) u_clock (
                .clk          (clk),
                .rst          (rst),
                .clocks_per_us(prescale_us),
                .t_us         (t_us)
            );
            aer_in #(
                .T_W   (T_W),
                .X_W   (X_W),
                .Y_W   (Y_W),
                .WIDTH (WIDTH),
                .HEIGHT(HEIGHT)
            ) u_aer (
                .clk        (clk),
                .rst        (aer_rst),
                .flush      (rst || !chosen[S]),
                .active_low (active_low),
                .word_serial(word_serial),
                .t_us       (t_us),
                .aer_req    (aer_req),
                .aer_ack    (aer_ack),
                .aer_row    (aer_row),
                .aer_data   (aer_data),
                .m_valid    (valid[S]),
                .m_ready    (ready[S]),
                .m_t        (t[S*T_W +: T_W]),
                .m_x        (x[S*X_W +: X_W]),
                .m_y        (y[S*Y_W +: Y_W]),
                .m_p        (p[S]),
                .n_events   (n_events),
                .n_outside  (n_outside),
                .n_rowless  (n_rowless),
                .idle       (source_idle[S])
            );
            assign skipped[S*32 +: 32] = n_outside + n_rowless;
            wire unused_aer = &{1'b0, n_events};
        end else begin : g_no_aer
            assign aer_ack = active_low;
            wire unused_aer = &{1'b0, aer_req, aer_row, aer_data, word_serial, prescale_us, aer_rst};
        end

        for (k = `EVCOT_SOURCE_EVT2; k <= `EVCOT_SOURCE_EVT3; k = k + 1) begin : g_evt
            if (BUILT[k]) begin : g_decoder
                evt_source #(
                    .FORMAT(k),
                    .T_W   (T_W),
                    .X_W   (X_W),
                    .Y_W   (Y_W),
                    .WIDTH (WIDTH),
                    .HEIGHT(HEIGHT)
                ) u_evt (
                    .clk          (clk),
                    .rst          (rst),
                    .swap_bytes   (swap_bytes),
                    .swap_halves  (swap_halves),
                    .s_axis_tvalid(s_axis_tvalid && chosen[k]),
                    .s_axis_tready(axis_ready[k]),
                    .s_axis_tdata (s_axis_tdata),
                    .s_axis_tkeep (s_axis_tkeep),
                    .s_axis_tlast (s_axis_tlast),
                    .m_valid      (valid[k]),
                    .m_ready      (ready[k]),
                    .m_t          (t[k*T_W +: T_W]),
                    .m_x          (x[k*X_W +: X_W]),
                    .m_y          (y[k*Y_W +: Y_W]),
                    .m_p          (p[k]),
                    .n_skipped    (skipped[k*32 +: 32]),
                    .idle         (source_idle[k])
                );
            end
        end
    endgenerate

    // ---- the selected one --------------------------------------------------------------------------------------------

    reg  [T_W-1:0] chosen_t;
    reg  [X_W-1:0] chosen_x;
    reg  [Y_W-1:0] chosen_y;
    wire           chosen_ready;

    always @* begin : choose
        integer i;
        chosen_t    = {T_W{1'b0}};
        chosen_x    = {X_W{1'b0}};
        chosen_y    = {Y_W{1'b0}};
        n_malformed = 32'd0;
        for (i = 0; i < K; i = i + 1) if (chosen[i]) begin
            chosen_t    = chosen_t | t[i*T_W +: T_W];
            chosen_x    = chosen_x | x[i*X_W +: X_W];
            chosen_y    = chosen_y | y[i*Y_W +: Y_W];
            n_malformed = n_malformed | skipped[i*32 +: 32];
        end
    end

    assign ready = chosen_ready ? chosen : {K{1'b0}};

    wire           event_valid, event_ready, event_p;
    wire [T_W-1:0] event_t;
    wire [X_W-1:0] event_x;
    wire [Y_W-1:0] event_y;

    generate
        if (SINGLE != 0) begin : g_single
            assign chosen       = BUILT;
            assign event_valid  = |valid;
            assign chosen_ready = event_ready;
            assign {event_t, event_x, event_y, event_p} = {chosen_t, chosen_x, chosen_y, |p};
            wire unused_select = &{1'b0, select};
        end else begin : g_selected
            reg [K-1:0] chosen_reg;
            always @(posedge clk) chosen_reg <= BUILT & ({{(K - 1) {1'b0}}, 1'b1} << select);
            assign chosen = chosen_reg;

            skid_buffer #(
                .W(T_W + X_W + Y_W + 1)
            ) u_chosen (
                .clk    (clk),
                .rst    (rst),
                .s_valid(|(valid & chosen)),
                .s_ready(chosen_ready),
                .s_data ({chosen_t, chosen_x, chosen_y, |(p & chosen)}),
                .m_valid(event_valid),
                .m_ready(event_ready),
                .m_data ({event_t, event_x, event_y, event_p})
            );
        end
    endgenerate

    // ---- ticks -------------------------------------------------------------------------------------------------------

    wire           token_valid, token_ready, token_p, passes, stamp_idle, fifo_idle;
    wire [T_W-1:0] token_tick;
    wire [X_W-1:0] token_x;
    wire [Y_W-1:0] token_y;
    wire [31:0]    n_out;

    stamp_ticks #(
        .T_W    (T_W),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .DIVIDES(DIVIDES)
    ) u_stamp (
        .clk       (clk),
        .rst       (rst),
        .off       (CLOCKED != 0 && clock_time),
        .tick_us   (tick_us),
        .s_valid   (event_valid),
        .s_ready   (event_ready),
        .s_t       (event_t),
        .s_x       (event_x),
        .s_y       (event_y),
        .s_p       (event_p),
        .m_valid   (token_valid),
        .m_ready   (token_ready),
        .m_tick    (token_tick),
        .m_x       (token_x),
        .m_y       (token_y),
        .m_p       (token_p),
        .n_backward(n_backward),
        .idle      (stamp_idle)
    );

    generate
        if (CLOCKED != 0) begin : g_clocked
            reg [15:0] clocks_per_tick;
            always @(posedge clk) clocks_per_tick <= clock_time ? prescale_tick : 16'd0;

            prescaler #(
                .W(16)
            ) u_clock (
                .clk   (clk),
                .rst   (rst),
                .period(clocks_per_tick),
                .pulse (passes)
            );
        end else begin : g_not_clocked
            assign passes = 1'b0;
            wire unused_clock = &{1'b0, clock_time, prescale_tick};
        end
    endgenerate

    // ---- the input FIFO ----------------------------------------------------------------------------------------------

    overload_fifo #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .TICK_W(TICK_W),
        .DEPTH (DEPTH),
        .GAP_W (T_W),
        .HELD_W(16)
    ) u_fifo (
        .clk        (clk),
        .rst        (rst),
        .drop_enable(drop),
        .s_time     (passes),
        .s_valid    (token_valid),
        .s_ready    (token_ready),
        .s_tick     (token_tick),
        .s_event    (1'b1),
        .s_skip     (1'b0),
        .s_x        (token_x),
        .s_y        (token_y),
        .s_p        (token_p),
        .m_valid    (m_valid),
        .m_ready    (m_ready),
        .m_tick     (m_tick),
        .m_event    (m_event),
        .m_skip     (m_skip),
        .m_x        (m_x),
        .m_y        (m_y),
        .m_p        (m_p),
        .dropped    (dropped),
        .n_in       (n_in),
        .n_out      (n_out),
        .n_dropped  (n_dropped),
        .held       (held),
        .idle       (fifo_idle)
    );

    assign idle = &(source_idle | ~chosen) && !event_valid && stamp_idle && fifo_idle;

    wire unused = &{1'b0, n_out, s_axis_tvalid, s_axis_tdata, s_axis_tkeep, s_axis_tlast, axis_ready, ready,
                    swap_halves, swap_bytes, lfsr_seed, lfsr_gap, lfsr_x_min, lfsr_x_span, lfsr_y_min, lfsr_y_span};

endmodule

`default_nettype wire
