// SPDX-License-Identifier: Apache-2.0
// Drops the events of pixels that software has marked as hot (docs/filters.md): one bit per pixel in block RAM.
//
// The RAM has one port, so reads and writes never collide: a mark stalls the tokens for a clock. It applies to every token that
// is accepted in the same clock or later; for a token inside, it may apply. Marks beyond WIDTH x HEIGHT are ignored.
//
// Latency:    4 clocks from s_ to m_: the pixel's address, the RAM, which of its blocks, the decision.
// Throughput: 1 token per clock, except for the clock after a mark.
// Stall:      while the output is full, the pipeline stalls.
// Reset:      becomes empty, then unmarks every pixel, one a clock. Meanwhile idle and s_ready are low and marks are lost.
// Combinational paths: mask_valid -> idle; s_ready and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module filter_mask #(
    parameter X_W    = 9,    // bits of an x address
    parameter Y_W    = 9,    // bits of a y address
    parameter TICK_W = 20,   // bits of the tick input
    parameter WIDTH  = 346,  // pixels of the sensor across
    parameter HEIGHT = 260   // pixels of the sensor down
) (
    input  wire              clk,
    input  wire              rst,

    // registers: see filter_regs.v
    input  wire              enable,
    input  wire              mask_valid,  // mark one pixel
    input  wire [15:0]       mask_x,
    input  wire [14:0]       mask_y,
    input  wire              mask_hot,

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

    output wire              idle  // nothing inside, no mark under way, all pixels unmarked after reset
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(WIDTH >= `EVCOT_WIDTH_MIN && WIDTH <= `EVCOT_WIDTH_MAX)) WIDTH_must_be_1_to_65536 ();
    parameter_check #(.OK(HEIGHT >= `EVCOT_HEIGHT_MIN && HEIGHT <= `EVCOT_HEIGHT_MAX)) HEIGHT_must_be_1_to_65536 ();

    localparam PIXELS  = WIDTH * HEIGHT;
    localparam ADDR_W  = (PIXELS > 1) ? $clog2(PIXELS) : 1;
    localparam TOKEN_W = TICK_W + 1 + X_W + Y_W + 1;

    localparam [31:0] LAST    = PIXELS - 1;
    localparam [31:0] COLUMNS = WIDTH;
    localparam [31:0] ROWS    = HEIGHT;

    parameter_check #(.OK({32'd0, COLUMNS} * {32'd0, ROWS} <= 64'd16777216)) WIDTH_times_HEIGHT_must_be_at_most_2_to_the_24 ();

    // ---- marks, and the walk that unmarks all pixels after reset -----------------------------------------------------

    reg walks, marks, mark_hot;
    reg [ADDR_W-1:0] mark_at;

    wire [31:0] mask_column = {16'd0, mask_x};
    wire [31:0] mask_row    = {17'd0, mask_y};
    wire [31:0] mask_at     = mask_row * COLUMNS + mask_column;

    always @(posedge clk) begin
        if (walks) begin
            walks   <= mark_at != LAST[ADDR_W-1:0];
            marks   <= mark_at != LAST[ADDR_W-1:0];
            mark_at <= mark_at + 1'b1;
        end else begin
            marks    <= mask_valid && mask_column < COLUMNS && mask_row < ROWS;
            mark_at  <= mask_at[ADDR_W-1:0];
            mark_hot <= mask_hot;
        end
        if (rst) begin
            walks    <= 1'b1;
            marks    <= 1'b1;
            mark_at  <= {ADDR_W{1'b0}};
            mark_hot <= 1'b0;
        end
    end

    // ---- tokens: address, RAM, decision ------------------------------------------------------------------------------

    reg addressed_valid, addressed_event, addressed_outside;
    reg read_valid, read_event, read_outside;
    reg known_valid, known_event, hot;
    reg [TOKEN_W-1:0] addressed, read, known;
    reg [ADDR_W-1:0] address;
    reg memory [0:PIXELS-1];
    reg marked;

    wire space;
    wire advance = space && !marks;

    wire [31:0] column = {{(32 - X_W) {1'b0}}, s_x};
    wire [31:0] row    = {{(32 - Y_W) {1'b0}}, s_y};
    wire [31:0] at     = row * COLUMNS + column;

    wire [ADDR_W-1:0] port = marks ? mark_at : address;

    always @(posedge clk) begin
        if (marks) memory[port] <= mark_hot;
        else if (space) marked <= memory[port];
    end

    always @(posedge clk) begin
        if (advance) begin
            addressed_valid   <= s_valid;
            addressed_event   <= s_event;
            addressed_outside <= column >= COLUMNS || row >= ROWS;
            addressed         <= {s_tick, s_skip, s_x, s_y, s_p};
            address           <= at[ADDR_W-1:0];
            read_valid        <= addressed_valid;
            read_event        <= addressed_event;
            read_outside      <= addressed_outside;
            read              <= addressed;
            known_valid       <= read_valid;
            known_event       <= read_event;
            known             <= read;
            hot               <= marked || read_outside;
        end
        if (rst) begin
            addressed_valid <= 1'b0;
            read_valid      <= 1'b0;
            known_valid     <= 1'b0;
        end
    end

    wire [TICK_W-1:0] tick;
    wire              skip;
    wire [X_W+Y_W:0]  rest;  // x, y, p
    assign {tick, skip, rest} = known;

    wire drops = known_event && enable && hot;

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(known_valid && !marks),
        .s_ready(space),
        .s_data ({tick, known_event && !drops, skip || drops, rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign s_ready = advance;
    assign idle    = !mask_valid && !marks && !addressed_valid && !read_valid && !known_valid && !m_valid;

    wire unused = &{1'b0, at, mask_at};

endmodule

`default_nettype wire
