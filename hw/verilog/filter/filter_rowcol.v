// SPDX-License-Identifier: Apache-2.0
// Keeps an event when the last events of its own and the neighbouring columns and rows were near it and a short while ago
// (docs/filters.md): the filter of Khodamoradi and Kastner (2018), whose memory grows with WIDTH + HEIGHT.
//
// Two stamp_line.v hold the last event of each column and of each row; stamp_walk.v explains why stamps of STAMP_W bits are exact.
//
// Latency:    10 clocks from s_ to m_: time and place, slot, addresses, RAM, its output, correction in two, ages, comparison, decision.
// Throughput: 1 token per clock; for stalls by the walk over the memory, which are rare, see stamp_walk.v.
// Stall:      while the output is full, the pipeline stalls.
// Reset:      becomes empty and clears the memory: ceil(max(WIDTH, HEIGHT)/4) + 8 clocks with idle and s_ready low.
// RAM:        4 * ceil(max(WIDTH, HEIGHT)/4) * (2 * STAMP_W + X_W + Y_W) bits.
// Combinational paths: none; s_ready comes from registers alone, and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module filter_rowcol #(
    parameter X_W     = 9,    // bits of an x address
    parameter Y_W     = 9,    // bits of a y address
    parameter TICK_W  = 20,   // bits of the tick input
    parameter WIDTH   = 346,  // pixels of the sensor across
    parameter HEIGHT  = 260,  // pixels of the sensor down
    parameter STAMP_W = 20    // bits of a time stamp
) (
    input  wire               clk,
    input  wire               rst,

    // registers: see filter_regs.v
    input  wire               enable,
    input  wire [STAMP_W-2:0] rowcol_ticks,
    input  wire [3:0]         rowcol_radius,
    input  wire [2:0]         rowcol_support,

    // tokens in
    input  wire               s_valid,
    output wire               s_ready,
    input  wire [TICK_W-1:0]  s_tick,
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

    output wire               idle  // nothing at_pixel, memory emptied after reset
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(WIDTH >= `EVCOT_WIDTH_MIN && WIDTH <= `EVCOT_WIDTH_MAX)) WIDTH_must_be_1_to_65536 ();
    parameter_check #(.OK(HEIGHT >= `EVCOT_HEIGHT_MIN && HEIGHT <= `EVCOT_HEIGHT_MAX)) HEIGHT_must_be_1_to_65536 ();
    parameter_check #(.OK(STAMP_W >= `EVCOT_STAMP_W_MIN && STAMP_W <= `EVCOT_STAMP_W_MAX)) STAMP_W_must_be_4_to_32 ();

    localparam LONGER  = WIDTH > HEIGHT ? WIDTH : HEIGHT;
    localparam ROWS    = (LONGER + 3) / 4;  // words of a bank: four columns, and four rows
    localparam ROW_W   = (ROWS > 1) ? $clog2(ROWS) : 1;
    localparam TOKEN_W = TICK_W + X_W + Y_W + 5;
    localparam SEGMENT_W = STAMP_W - 2;     // ages up to 2^(STAMP_W-1) - 1 matter
    // The number of a column's and of a row's word travel with the token: they differ, and a visit has one for both.
    localparam DATA_W  = TOKEN_W + ROW_W;

    localparam [31:0] ACROSS = WIDTH;
    localparam [31:0] DOWN   = HEIGHT;

    wire space;  // for one more token in the output: everything moves

    // ---- time and place ----------------------------------------------------------------------------------------------

    wire [6:0]           access, visits;
    wire [7*ROW_W-1:0]   column_row, line_row;
    wire [7*STAMP_W-1:0] now;
    wire [7*DATA_W-1:0]  data;
    wire [7*X_W-1:0]     places_x;
    wire [7*Y_W-1:0]     places_y;
    wire                 slots_valid, clearing, slots_idle;

    wire [31:0] x         = {{(32 - X_W) {1'b0}}, s_x};
    wire [31:0] y         = {{(32 - Y_W) {1'b0}}, s_y};
    wire        on_sensor = x < ACROSS && y < DOWN;
    wire        unused    = &{1'b0, x, y, data};

    stamp_slots #(
        .STAMP_W  (STAMP_W),
        .SEGMENT_W(SEGMENT_W),
        .STEP_W   (TICK_W),
        .ROWS     (ROWS),
        .ROW_W    (ROW_W),
        .DATA_W   (DATA_W)
    ) u_slots (
        .clk     (clk),
        .rst     (rst),
        .advance (space),
        .s_valid (s_valid),
        .s_ready (s_ready),
        .s_step  (s_tick),
        .s_access(s_event && enable && on_sensor),
        .s_row   (x[2 +: ROW_W]),
        .s_data  ({y[2 +: ROW_W], s_event && enable, on_sensor, s_tick, s_event, s_skip, s_x, s_y, s_p}),
        .access  (access),
        .visits  (visits),
        .row     (column_row),
        .now     (now),
        .data    (data),
        .m_valid (slots_valid),
        .clearing(clearing),
        .idle    (slots_idle)
    );

    // ---- the last events of columns and rows -------------------------------------------------------------------------

    genvar s;
    generate
        for (s = 0; s < 7; s = s + 1) begin : g_stage
            assign places_x[s*X_W +: X_W]     = data[s*DATA_W + 1 + Y_W +: X_W];
            assign places_y[s*Y_W +: Y_W]     = data[s*DATA_W + 1 +: Y_W];
            assign line_row[s*ROW_W +: ROW_W] = visits[s] ? column_row[s*ROW_W +: ROW_W] : data[s*DATA_W + TOKEN_W +: ROW_W];
        end
    endgenerate

    wire [3:0]           column_reached, column_own, row_reached, row_own;
    wire [4*STAMP_W-1:0] column_age, row_age;
    wire [4*(Y_W+1)-1:0] column_apart;
    wire [4*(X_W+1)-1:0] row_apart;

    stamp_line #(
        .PLACES   (WIDTH),
        .PLACE_W  (X_W),
        .OTHER_W  (Y_W),
        .ROWS     (ROWS),
        .ROW_W    (ROW_W),
        .STAMP_W  (STAMP_W),
        .SEGMENT_W(SEGMENT_W)
    ) u_columns (
        .clk     (clk),
        .advance (space),
        .access  (access),
        .visits  (visits),
        .row     (column_row),
        .now     (now),
        .place   (places_x),
        .other   (places_y),
        .clearing(clearing),
        .reached (column_reached),
        .age     (column_age),
        .apart   (column_apart),
        .own     (column_own)
    );

    stamp_line #(
        .PLACES   (HEIGHT),
        .PLACE_W  (Y_W),
        .OTHER_W  (X_W),
        .ROWS     (ROWS),
        .ROW_W    (ROW_W),
        .STAMP_W  (STAMP_W),
        .SEGMENT_W(SEGMENT_W)
    ) u_rows (
        .clk     (clk),
        .advance (space),
        .access  (access),
        .visits  (visits),
        .row     (line_row),
        .now     (now),
        .place   (places_y),
        .other   (places_x),
        .clearing(clearing),
        .reached (row_reached),
        .age     (row_age),
        .apart   (row_apart),
        .own     (row_own)
    );

    // ---- comparison --------------------------------------------------------------------------------------------------

    reg               compared_valid;
    reg [TOKEN_W-1:0] compared;
    reg [7:0]         supporters;

    // Bits to compare a difference of coordinates with a radius of 4 bits: both with a sign.
    localparam DY_W = (Y_W > 4 ? Y_W : 4) + 1;
    localparam DX_W = (X_W > 4 ? X_W : 4) + 1;

    wire [DY_W-1:0] radius_y = {{(DY_W - 4) {1'b0}}, rowcol_radius};
    wire [DX_W-1:0] radius_x = {{(DX_W - 4) {1'b0}}, rowcol_radius};
    wire signed [DY_W-1:0] most_y = radius_y, least_y = -radius_y;
    wire signed [DX_W-1:0] most_x = radius_x, least_x = -radius_x;

    always @(posedge clk) begin : compare
        integer k;
        reg signed [DY_W-1:0] dy;
        reg signed [DX_W-1:0] dx;
        if (space) begin
            compared_valid <= slots_valid;
            compared       <= data[6*DATA_W +: TOKEN_W];
            for (k = 0; k < 4; k = k + 1) begin
                dy = {{(DY_W - Y_W) {column_apart[k*(Y_W+1) + Y_W]}}, column_apart[k*(Y_W+1) +: Y_W]};
                dx = {{(DX_W - X_W) {row_apart[k*(X_W+1) + X_W]}}, row_apart[k*(X_W+1) +: X_W]};
                supporters[k]   <= column_reached[k] && column_age[k*STAMP_W +: STAMP_W] <= {1'b0, rowcol_ticks}
                                   && dy <= most_y && dy >= least_y && !(column_own[k] && dy == {DY_W{1'b0}});
                supporters[k+4] <= row_reached[k] && row_age[k*STAMP_W +: STAMP_W] <= {1'b0, rowcol_ticks}
                                   && dx <= most_x && dx >= least_x && !(row_own[k] && dx == {DX_W{1'b0}});
            end
        end
        if (rst) compared_valid <= 1'b0;
    end

    // ---- count and decision ------------------------------------------------------------------------------------------

    reg [2:0] support;  // 3 columns and 3 rows at most

    always @* begin : add_up
        integer k;
        k       = 0;  // on every path, or it would be a latch
        support = 3'd0;
        for (k = 0; k < 8; k = k + 1) support = support + {2'd0, supporters[k]};
    end

    wire              judged, at_pixel, is_event, skip;
    wire [TICK_W-1:0] tick;
    wire [X_W+Y_W:0]  rest;  // x, y, p
    assign {judged, at_pixel, tick, is_event, skip, rest} = compared;

    wire drops = judged && !(at_pixel && support >= rowcol_support);

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(compared_valid),
        .s_ready(space),
        .s_data ({tick, is_event && !drops, skip || drops, rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign idle = slots_idle && !compared_valid && !m_valid;

endmodule

`default_nettype wire
