// SPDX-License-Identifier: Apache-2.0
// The eight filters in series, in the order of docs/filters.md: each sees only the events that the previous ones kept.
//
// HAS says which filters are built; one that is not passes its tokens on by wire, and its bit in `enable` has no effect.
//
// Latency:    the sum of those of the filters that are built, enabled or not: 52 clocks from s_ to m_ for all eight. With CELL_PX
//             > 0, filter_cells is in the place of refractory and activity, behind noise_support if activity is built, and decay
//             takes as long as its header says.
// Throughput: that of the slowest filter: 1 token per clock, with the rare stalls of stamp_walk.v and a clock for each mark.
// Stall:      a token is held until accepted; back-pressure fills the filters one by one.
// Reset:      disables all filters and empties all memories, pixel by pixel. Until that is done idle is low, tokens wait
//             in front of the filter concerned, and marks of hot pixels are lost.
// Combinational paths: none; with HAS = 0, by wire, from every s_ to its m_ and from m_ready to s_ready.
`default_nettype none
`include "evcot_defs.vh"

module filter_chain #(
    parameter HAS          = 255,  // filters to build, one bit each in the order of EVCOT_FILTER_*
    parameter X_W          = 9,    // bits of an x address
    parameter Y_W          = 9,    // bits of a y address
    parameter TICK_W       = 20,   // bits of the tick input
    parameter WIDTH        = 346,  // pixels of the sensor across
    parameter HEIGHT       = 260,  // pixels of the sensor down
    parameter STAMP_W      = 20,   // bits of a time stamp in a filter's memory
    parameter RECENT_DEPTH = 32,   // events in the FIFO of recent events
    parameter CELL_PX      = 0,    // side of a cell in pixels: 1, 2 or 4; 0: a time stamp per pixel and filter
    parameter CELL_STAMP_W = 0     // bits of a time stamp in a cell of refractory and activity; 0: as many as 9 bits hold
) (
    input  wire              clk,
    input  wire              rst,

    // registers: see filter_regs.v
    input  wire              cfg_valid,
    input  wire [`EVCOT_FREG_W-1:0] cfg_addr,
    input  wire [31:0]       cfg_data,

    // tokens in
    input  wire              s_valid,
    output wire              s_ready,
    input  wire [TICK_W-1:0] s_tick,
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

    output wire              idle  // nothing inside, no mark under way, all memories empty after reset
);

    parameter_check #(.OK(HAS >= 0 && HAS <= 255)) HAS_must_be_0_to_255 ();
    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(WIDTH >= `EVCOT_WIDTH_MIN && WIDTH <= `EVCOT_WIDTH_MAX)) WIDTH_must_be_1_to_65536 ();
    parameter_check #(.OK(HEIGHT >= `EVCOT_HEIGHT_MIN && HEIGHT <= `EVCOT_HEIGHT_MAX)) HEIGHT_must_be_1_to_65536 ();
    parameter_check #(.OK(STAMP_W >= `EVCOT_STAMP_W_MIN && STAMP_W <= `EVCOT_STAMP_W_MAX)) STAMP_W_must_be_4_to_32 ();
    parameter_check #(
        .OK(RECENT_DEPTH >= `EVCOT_RECENT_DEPTH_MIN && RECENT_DEPTH <= `EVCOT_RECENT_DEPTH_MAX)
    ) RECENT_DEPTH_must_be_1_to_256 ();

    parameter_check #(
        .OK(CELL_PX == `EVCOT_CELL_PX_MIN || CELL_PX == 1 || CELL_PX == 2 || CELL_PX == `EVCOT_CELL_PX_MAX)
    ) CELL_PX_must_be_0_to_4_and_not_3 ();

    parameter_check #(
        .OK(CELL_STAMP_W == 0 || (CELL_STAMP_W <= `EVCOT_CELL_STAMP_W_MAX &&
            CELL_STAMP_W >= ((CELL_PX == 1) ? 9 : (CELL_PX == 2) ? 7 : (CELL_PX == 4) ? 5 : 33)))
    ) CELL_STAMP_W_must_be_0_or_hold_the_ages ();

    localparam [31:0] FILTERS = HAS;
    localparam [7:0]  BUILT   = FILTERS[7:0];

    localparam REGION     = `EVCOT_FILTER_REGION;
    localparam POLARITY   = `EVCOT_FILTER_POLARITY;
    localparam MASK       = `EVCOT_FILTER_MASK;
    localparam REFRACTORY = `EVCOT_FILTER_REFRACTORY;
    localparam ACTIVITY   = `EVCOT_FILTER_ACTIVITY;
    localparam RECENT     = `EVCOT_FILTER_RECENT;
    localparam DECAY      = `EVCOT_FILTER_DECAY;
    localparam ROWCOL     = `EVCOT_FILTER_ROWCOL;

    // With cells the filters refractory and activity are one, in the place of refractory (or of activity, if that is built alone).
    localparam JOINED = CELL_PX != 0 && BUILT[REFRACTORY];

    // ---- registers ---------------------------------------------------------------------------------------------------

    wire [7:0]         enable;
    wire [15:0]        region_x0, region_x1, region_y0, region_y1;
    wire               polarity;
    wire [STAMP_W-2:0] refractory_ticks, activity_ticks, recent_ticks, rowcol_ticks;
    wire [3:0]         activity_support, recent_radius, rowcol_radius;
    wire [2:0]         rowcol_support;
    wire [3:0]         stamp_shift;
    wire [4:0]         noise_log2;
    wire [2:0]         noise_asked;
    wire [15:0]        noise_least;
    wire [8:0]         recent_support;
    wire [24:0]        decay_rate;
    wire [7:0]         decay_epsilon;
    wire [11:0]        decay_support;
    wire               mask_valid, mask_hot;
    wire [15:0]        mask_x;
    wire [14:0]        mask_y;

    filter_regs #(
        .STAMP_W(STAMP_W)
    ) u_regs (
        .clk             (clk),
        .rst             (rst),
        .cfg_valid       (cfg_valid),
        .cfg_addr        (cfg_addr),
        .cfg_data        (cfg_data),
        .enable          (enable),
        .region_x0       (region_x0),
        .region_x1       (region_x1),
        .region_y0       (region_y0),
        .region_y1       (region_y1),
        .polarity        (polarity),
        .refractory_ticks(refractory_ticks),
        .activity_ticks  (activity_ticks),
        .activity_support(activity_support),
        .recent_ticks    (recent_ticks),
        .recent_radius   (recent_radius),
        .recent_support  (recent_support),
        .decay_rate      (decay_rate),
        .decay_epsilon   (decay_epsilon),
        .decay_support   (decay_support),
        .rowcol_ticks    (rowcol_ticks),
        .rowcol_radius   (rowcol_radius),
        .rowcol_support  (rowcol_support),
        .stamp_shift     (stamp_shift),
        .noise_log2      (noise_log2),
        .noise_asked     (noise_asked),
        .noise_least     (noise_least),
        .mask_valid      (mask_valid),
        .mask_x          (mask_x),
        .mask_y          (mask_y),
        .mask_hot        (mask_hot)
    );

    // ---- the row: what leaves a filter enters the next ---------------------------------------------------------------

    wire [7:0]          in_valid, in_ready, in_event, in_skip, in_p;
    wire [7:0]          out_valid, out_ready, out_event, out_skip, out_p;
    wire [8*TICK_W-1:0] in_tick, out_tick;
    wire [8*X_W-1:0]    in_x, out_x;
    wire [8*Y_W-1:0]    in_y, out_y;
    wire [7:0]          filter_idle;

    assign {m_valid, in_valid}  = {out_valid, s_valid};
    assign {out_ready, s_ready} = {m_ready, in_ready};
    assign {m_tick, in_tick}    = {out_tick, s_tick};
    assign {m_event, in_event}  = {out_event, s_event};
    assign {m_skip, in_skip}    = {out_skip, s_skip};
    assign {m_x, in_x}          = {out_x, s_x};
    assign {m_y, in_y}          = {out_y, s_y};
    assign {m_p, in_p}          = {out_p, s_p};
    assign idle                 = &filter_idle;

    genvar k;
    generate
        for (k = 0; k < 8; k = k + 1) begin : g_wire
            if (!BUILT[k] || (k == ACTIVITY && JOINED)) begin : g_past
                assign out_valid[k]                 = in_valid[k];
                assign in_ready[k]                  = out_ready[k];
                assign out_tick[k*TICK_W +: TICK_W] = in_tick[k*TICK_W +: TICK_W];
                assign out_event[k]                 = in_event[k];
                assign out_skip[k]                  = in_skip[k];
                assign out_x[k*X_W +: X_W]          = in_x[k*X_W +: X_W];
                assign out_y[k*Y_W +: Y_W]          = in_y[k*Y_W +: Y_W];
                assign out_p[k]                     = in_p[k];
                assign filter_idle[k]               = 1'b1;
            end
        end
        if (CELL_PX == 0 || !BUILT[ACTIVITY]) begin : g_no_noise
            assign noise_asked = 3'd0;
        end
        if (BUILT[REGION]) begin : g_region
            filter_region #(
                .X_W   (X_W),
                .Y_W   (Y_W),
                .TICK_W(TICK_W)
            ) u_region (
                .clk      (clk),
                .rst      (rst),
                .enable   (enable[REGION]),
                .region_x0(region_x0),
                .region_x1(region_x1),
                .region_y0(region_y0),
                .region_y1(region_y1),
                .s_valid  (in_valid[REGION]),
                .s_ready  (in_ready[REGION]),
                .s_tick   (in_tick[REGION*TICK_W +: TICK_W]),
                .s_event  (in_event[REGION]),
                .s_skip   (in_skip[REGION]),
                .s_x      (in_x[REGION*X_W +: X_W]),
                .s_y      (in_y[REGION*Y_W +: Y_W]),
                .s_p      (in_p[REGION]),
                .m_valid  (out_valid[REGION]),
                .m_ready  (out_ready[REGION]),
                .m_tick   (out_tick[REGION*TICK_W +: TICK_W]),
                .m_event  (out_event[REGION]),
                .m_skip   (out_skip[REGION]),
                .m_x      (out_x[REGION*X_W +: X_W]),
                .m_y      (out_y[REGION*Y_W +: Y_W]),
                .m_p      (out_p[REGION]),
                .idle     (filter_idle[REGION])
            );
        end
        if (BUILT[POLARITY]) begin : g_polarity
            filter_polarity #(
                .X_W   (X_W),
                .Y_W   (Y_W),
                .TICK_W(TICK_W)
            ) u_polarity (
                .clk     (clk),
                .rst     (rst),
                .enable  (enable[POLARITY]),
                .polarity(polarity),
                .s_valid (in_valid[POLARITY]),
                .s_ready (in_ready[POLARITY]),
                .s_tick  (in_tick[POLARITY*TICK_W +: TICK_W]),
                .s_event (in_event[POLARITY]),
                .s_skip  (in_skip[POLARITY]),
                .s_x     (in_x[POLARITY*X_W +: X_W]),
                .s_y     (in_y[POLARITY*Y_W +: Y_W]),
                .s_p     (in_p[POLARITY]),
                .m_valid (out_valid[POLARITY]),
                .m_ready (out_ready[POLARITY]),
                .m_tick  (out_tick[POLARITY*TICK_W +: TICK_W]),
                .m_event (out_event[POLARITY]),
                .m_skip  (out_skip[POLARITY]),
                .m_x     (out_x[POLARITY*X_W +: X_W]),
                .m_y     (out_y[POLARITY*Y_W +: Y_W]),
                .m_p     (out_p[POLARITY]),
                .idle    (filter_idle[POLARITY])
            );
        end
        if (BUILT[MASK]) begin : g_mask
            filter_mask #(
                .X_W   (X_W),
                .Y_W   (Y_W),
                .TICK_W(TICK_W),
                .WIDTH (WIDTH),
                .HEIGHT(HEIGHT)
            ) u_mask (
                .clk       (clk),
                .rst       (rst),
                .enable    (enable[MASK]),
                .mask_valid(mask_valid),
                .mask_x    (mask_x),
                .mask_y    (mask_y),
                .mask_hot  (mask_hot),
                .s_valid   (in_valid[MASK]),
                .s_ready   (in_ready[MASK]),
                .s_tick    (in_tick[MASK*TICK_W +: TICK_W]),
                .s_event   (in_event[MASK]),
                .s_skip    (in_skip[MASK]),
                .s_x       (in_x[MASK*X_W +: X_W]),
                .s_y       (in_y[MASK*Y_W +: Y_W]),
                .s_p       (in_p[MASK]),
                .m_valid   (out_valid[MASK]),
                .m_ready   (out_ready[MASK]),
                .m_tick    (out_tick[MASK*TICK_W +: TICK_W]),
                .m_event   (out_event[MASK]),
                .m_skip    (out_skip[MASK]),
                .m_x       (out_x[MASK*X_W +: X_W]),
                .m_y       (out_y[MASK*Y_W +: Y_W]),
                .m_p       (out_p[MASK]),
                .idle      (filter_idle[MASK])
            );
        end
        if (BUILT[REFRACTORY] && CELL_PX == 0) begin : g_refractory
            filter_refractory #(
                .X_W    (X_W),
                .Y_W    (Y_W),
                .TICK_W (TICK_W),
                .WIDTH  (WIDTH),
                .HEIGHT (HEIGHT),
                .STAMP_W(STAMP_W)
            ) u_refractory (
                .clk             (clk),
                .rst             (rst),
                .enable          (enable[REFRACTORY]),
                .refractory_ticks(refractory_ticks),
                .s_valid         (in_valid[REFRACTORY]),
                .s_ready         (in_ready[REFRACTORY]),
                .s_tick          (in_tick[REFRACTORY*TICK_W +: TICK_W]),
                .s_event         (in_event[REFRACTORY]),
                .s_skip          (in_skip[REFRACTORY]),
                .s_x             (in_x[REFRACTORY*X_W +: X_W]),
                .s_y             (in_y[REFRACTORY*Y_W +: Y_W]),
                .s_p             (in_p[REFRACTORY]),
                .m_valid         (out_valid[REFRACTORY]),
                .m_ready         (out_ready[REFRACTORY]),
                .m_tick          (out_tick[REFRACTORY*TICK_W +: TICK_W]),
                .m_event         (out_event[REFRACTORY]),
                .m_skip          (out_skip[REFRACTORY]),
                .m_x             (out_x[REFRACTORY*X_W +: X_W]),
                .m_y             (out_y[REFRACTORY*Y_W +: Y_W]),
                .m_p             (out_p[REFRACTORY]),
                .idle            (filter_idle[REFRACTORY])
            );
        end
        if (CELL_PX != 0 && (BUILT[REFRACTORY] || BUILT[ACTIVITY])) begin : g_cells
            localparam AT = JOINED ? REFRACTORY : ACTIVITY;

            wire              cells_valid, cells_ready, cells_event, cells_skip, cells_p, noise_idle, cells_idle;
            wire [TICK_W-1:0] cells_tick;
            wire [X_W-1:0]    cells_x;
            wire [Y_W-1:0]    cells_y;
            wire [3:0]        cells_support;

            assign filter_idle[AT] = noise_idle && cells_idle;

            if (BUILT[ACTIVITY]) begin : g_noise
                noise_support #(
                    .X_W   (X_W),
                    .Y_W   (Y_W),
                    .TICK_W(TICK_W),
                    .WIDTH (WIDTH),
                    .HEIGHT(HEIGHT)
                ) u_noise (
                    .clk        (clk),
                    .rst        (rst),
                    .follow     (enable[ACTIVITY] && activity_support == 4'd0),
                    .fixed      (activity_support),
                    .noise_log2 (noise_log2),
                    .noise_asked(noise_asked),
                    .noise_least(noise_least),
                    .s_valid    (in_valid[AT]),
                    .s_ready    (in_ready[AT]),
                    .s_tick     (in_tick[AT*TICK_W +: TICK_W]),
                    .s_event    (in_event[AT]),
                    .s_skip     (in_skip[AT]),
                    .s_x        (in_x[AT*X_W +: X_W]),
                    .s_y        (in_y[AT*Y_W +: Y_W]),
                    .s_p        (in_p[AT]),
                    .m_valid    (cells_valid),
                    .m_ready    (cells_ready),
                    .m_tick     (cells_tick),
                    .m_event    (cells_event),
                    .m_skip     (cells_skip),
                    .m_x        (cells_x),
                    .m_y        (cells_y),
                    .m_p        (cells_p),
                    .m_support  (cells_support),
                    .idle       (noise_idle)
                );
            end else begin : g_past
                assign cells_valid   = in_valid[AT];
                assign in_ready[AT]  = cells_ready;
                assign cells_tick    = in_tick[AT*TICK_W +: TICK_W];
                assign cells_event   = in_event[AT];
                assign cells_skip    = in_skip[AT];
                assign cells_x       = in_x[AT*X_W +: X_W];
                assign cells_y       = in_y[AT*Y_W +: Y_W];
                assign cells_p       = in_p[AT];
                assign cells_support = 4'd0;
                assign noise_idle    = 1'b1;
            end

            filter_cells #(
                .X_W    (X_W),
                .Y_W    (Y_W),
                .TICK_W (TICK_W),
                .WIDTH  (WIDTH),
                .HEIGHT (HEIGHT),
                .STAMP_W(STAMP_W),
                .CELL_PX(CELL_PX),
                .CELL_STAMP_W(CELL_STAMP_W)
            ) u_cells (
                .clk              (clk),
                .rst              (rst),
                .changes          (cfg_valid),
                .enable_refractory(enable[REFRACTORY] && BUILT[REFRACTORY]),
                .enable_activity  (enable[ACTIVITY] && BUILT[ACTIVITY]),
                .refractory_ticks (refractory_ticks),
                .activity_ticks   (activity_ticks),
                .stamp_shift      (stamp_shift),
                .s_valid          (cells_valid),
                .s_ready          (cells_ready),
                .s_tick           (cells_tick),
                .s_event          (cells_event),
                .s_skip           (cells_skip),
                .s_x              (cells_x),
                .s_y              (cells_y),
                .s_p              (cells_p),
                .s_support        (cells_support),
                .m_valid          (out_valid[AT]),
                .m_ready          (out_ready[AT]),
                .m_tick           (out_tick[AT*TICK_W +: TICK_W]),
                .m_event          (out_event[AT]),
                .m_skip           (out_skip[AT]),
                .m_x              (out_x[AT*X_W +: X_W]),
                .m_y              (out_y[AT*Y_W +: Y_W]),
                .m_p              (out_p[AT]),
                .idle             (cells_idle)
            );
        end
        if (BUILT[ACTIVITY] && CELL_PX == 0) begin : g_activity
            filter_activity #(
                .X_W    (X_W),
                .Y_W    (Y_W),
                .TICK_W (TICK_W),
                .WIDTH  (WIDTH),
                .HEIGHT (HEIGHT),
                .STAMP_W(STAMP_W)
            ) u_activity (
                .clk             (clk),
                .rst             (rst),
                .enable          (enable[ACTIVITY]),
                .activity_ticks  (activity_ticks),
                .activity_support(activity_support),
                .s_valid         (in_valid[ACTIVITY]),
                .s_ready         (in_ready[ACTIVITY]),
                .s_tick          (in_tick[ACTIVITY*TICK_W +: TICK_W]),
                .s_event         (in_event[ACTIVITY]),
                .s_skip          (in_skip[ACTIVITY]),
                .s_x             (in_x[ACTIVITY*X_W +: X_W]),
                .s_y             (in_y[ACTIVITY*Y_W +: Y_W]),
                .s_p             (in_p[ACTIVITY]),
                .m_valid         (out_valid[ACTIVITY]),
                .m_ready         (out_ready[ACTIVITY]),
                .m_tick          (out_tick[ACTIVITY*TICK_W +: TICK_W]),
                .m_event         (out_event[ACTIVITY]),
                .m_skip          (out_skip[ACTIVITY]),
                .m_x             (out_x[ACTIVITY*X_W +: X_W]),
                .m_y             (out_y[ACTIVITY*Y_W +: Y_W]),
                .m_p             (out_p[ACTIVITY]),
                .idle            (filter_idle[ACTIVITY])
            );
        end
        if (BUILT[RECENT]) begin : g_recent
            filter_recent #(
                .X_W    (X_W),
                .Y_W    (Y_W),
                .TICK_W (TICK_W),
                .STAMP_W(STAMP_W),
                .DEPTH  (RECENT_DEPTH)
            ) u_recent (
                .clk           (clk),
                .rst           (rst),
                .enable        (enable[RECENT]),
                .recent_ticks  (recent_ticks),
                .recent_radius (recent_radius),
                .recent_support(recent_support),
                .s_valid       (in_valid[RECENT]),
                .s_ready       (in_ready[RECENT]),
                .s_tick        (in_tick[RECENT*TICK_W +: TICK_W]),
                .s_event       (in_event[RECENT]),
                .s_skip        (in_skip[RECENT]),
                .s_x           (in_x[RECENT*X_W +: X_W]),
                .s_y           (in_y[RECENT*Y_W +: Y_W]),
                .s_p           (in_p[RECENT]),
                .m_valid       (out_valid[RECENT]),
                .m_ready       (out_ready[RECENT]),
                .m_tick        (out_tick[RECENT*TICK_W +: TICK_W]),
                .m_event       (out_event[RECENT]),
                .m_skip        (out_skip[RECENT]),
                .m_x           (out_x[RECENT*X_W +: X_W]),
                .m_y           (out_y[RECENT*Y_W +: Y_W]),
                .m_p           (out_p[RECENT]),
                .idle          (filter_idle[RECENT])
            );
        end
        if (BUILT[DECAY]) begin : g_decay
            filter_decay #(
                .X_W    (X_W),
                .Y_W    (Y_W),
                .TICK_W (TICK_W),
                .WIDTH  (WIDTH),
                .HEIGHT (HEIGHT),
                .CELL_PX(CELL_PX)
            ) u_decay (
                .clk          (clk),
                .rst          (rst),
                .enable       (enable[DECAY]),
                .decay_rate   (decay_rate),
                .decay_epsilon(decay_epsilon),
                .decay_support(decay_support),
                .s_valid      (in_valid[DECAY]),
                .s_ready      (in_ready[DECAY]),
                .s_tick       (in_tick[DECAY*TICK_W +: TICK_W]),
                .s_event      (in_event[DECAY]),
                .s_skip       (in_skip[DECAY]),
                .s_x          (in_x[DECAY*X_W +: X_W]),
                .s_y          (in_y[DECAY*Y_W +: Y_W]),
                .s_p          (in_p[DECAY]),
                .m_valid      (out_valid[DECAY]),
                .m_ready      (out_ready[DECAY]),
                .m_tick       (out_tick[DECAY*TICK_W +: TICK_W]),
                .m_event      (out_event[DECAY]),
                .m_skip       (out_skip[DECAY]),
                .m_x          (out_x[DECAY*X_W +: X_W]),
                .m_y          (out_y[DECAY*Y_W +: Y_W]),
                .m_p          (out_p[DECAY]),
                .idle         (filter_idle[DECAY])
            );
        end
        if (BUILT[ROWCOL]) begin : g_rowcol
            filter_rowcol #(
                .X_W    (X_W),
                .Y_W    (Y_W),
                .TICK_W (TICK_W),
                .WIDTH  (WIDTH),
                .HEIGHT (HEIGHT),
                .STAMP_W(STAMP_W)
            ) u_rowcol (
                .clk           (clk),
                .rst           (rst),
                .enable        (enable[ROWCOL]),
                .rowcol_ticks  (rowcol_ticks),
                .rowcol_radius (rowcol_radius),
                .rowcol_support(rowcol_support),
                .s_valid       (in_valid[ROWCOL]),
                .s_ready       (in_ready[ROWCOL]),
                .s_tick        (in_tick[ROWCOL*TICK_W +: TICK_W]),
                .s_event       (in_event[ROWCOL]),
                .s_skip        (in_skip[ROWCOL]),
                .s_x           (in_x[ROWCOL*X_W +: X_W]),
                .s_y           (in_y[ROWCOL*Y_W +: Y_W]),
                .s_p           (in_p[ROWCOL]),
                .m_valid       (out_valid[ROWCOL]),
                .m_ready       (out_ready[ROWCOL]),
                .m_tick        (out_tick[ROWCOL*TICK_W +: TICK_W]),
                .m_event       (out_event[ROWCOL]),
                .m_skip        (out_skip[ROWCOL]),
                .m_x           (out_x[ROWCOL*X_W +: X_W]),
                .m_y           (out_y[ROWCOL*Y_W +: Y_W]),
                .m_p           (out_p[ROWCOL]),
                .idle          (filter_idle[ROWCOL])
            );
        end
    endgenerate

    // What the filters that are not built would read.
    wire unused = &{1'b0, enable, region_x0, region_x1, region_y0, region_y1, polarity, refractory_ticks, activity_ticks,
                    activity_support, recent_ticks, recent_radius, recent_support, decay_rate, decay_epsilon, decay_support,
                    rowcol_ticks, rowcol_radius, rowcol_support, stamp_shift, noise_log2, noise_least, mask_valid, mask_x, mask_y, mask_hot};

endmodule

`default_nettype wire
