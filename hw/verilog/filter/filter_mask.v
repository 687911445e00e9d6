// SPDX-License-Identifier: Apache-2.0
// Drops the events of pixels that software has marked as hot (docs/filters.md): one bit per pixel in block RAM.
//
// The RAM has one port, so reads and writes never collide: a mark stalls the tokens for a clock. It applies to every token that
// is accepted in the same clock or later; for a token inside, it may apply. Marks beyond WIDTH x HEIGHT are ignored.
//
// Latency:    6 clocks from s_ to m_: product, the pixel's address, the RAM and its output, which of its parts, the decision.
// Throughput: 1 token per clock, except for the second clock after a mark.
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
    localparam PART_W  = 14;  // log2 of the pixels in a block RAM
    localparam PARTS   = (PIXELS + (1 << PART_W) - 1) >> PART_W;

    localparam [31:0] LAST    = PIXELS - 1;
    localparam [31:0] COLUMNS = WIDTH;
    localparam [31:0] ROWS    = HEIGHT;

    parameter_check #(.OK({32'd0, COLUMNS} * {32'd0, ROWS} <= 64'd16777216)) WIDTH_times_HEIGHT_must_be_at_most_2_to_the_24 ();

    // ---- marks, and the walk that unmarks all pixels after reset -----------------------------------------------------

    reg              walks, marks, mark_hot, comes, comes_hot;
    reg [ADDR_W-1:0] mark_at, comes_product, comes_column;

    wire [31:0] mask_column  = {16'd0, mask_x};
    wire [31:0] mask_row     = {17'd0, mask_y};
    wire [31:0] mask_product = mask_row * COLUMNS;

    always @(posedge clk) begin
        comes         <= mask_valid && !walks && mask_column < COLUMNS && mask_row < ROWS;
        comes_hot     <= mask_hot;
        comes_product <= mask_product[ADDR_W-1:0];
        comes_column  <= mask_column[ADDR_W-1:0];
        if (walks) begin
            walks    <= mark_at != LAST[ADDR_W-1:0];
            marks    <= mark_at != LAST[ADDR_W-1:0];
            mark_at  <= mark_at + 1'b1;
        end else begin
            marks    <= comes;
            mark_at  <= comes_product + comes_column;
            mark_hot <= comes_hot;
        end
        if (rst) begin
            comes    <= 1'b0;
            walks    <= 1'b1;
            marks    <= 1'b1;
            mark_at  <= {ADDR_W{1'b0}};
            mark_hot <= 1'b0;
        end
    end

    // ---- tokens: product, address, RAM and its output, which part, decision ------------------------------------------

    reg [4:0]           valid, is_event;  // by stage
    reg [3:0]           outside;
    reg [5*TOKEN_W-1:0] token;
    reg [ADDR_W-1:0]    product, across, address;
    reg                 hot;

    wire space;
    wire advance = space && !marks;

    wire [31:0] column   = {{(32 - X_W) {1'b0}}, s_x};
    wire [31:0] row      = {{(32 - Y_W) {1'b0}}, s_y};
    wire [31:0] row_base = row * COLUMNS;

    wire [PARTS-1:0] marked;     // what each part holds
    wire             is_marked;  // the part with the pixel

    genvar p;
    generate
        for (p = 0; p < PARTS; p = p + 1) begin : g_part
            localparam WORDS = (p == PARTS - 1) ? PIXELS - (p << PART_W) : 1 << PART_W;
            localparam AT_W  = (WORDS > 1) ? $clog2(WORDS) : 1;
            wire here;

            block_memory #(
                .W    (1),
                .DEPTH(WORDS)
            ) u_memory (
                .clk          (clk),
                .write        (marks && here),
                .write_address(mark_at[AT_W-1:0]),
                .write_data   (mark_hot),
                .read_enable  (advance),
                .read_address (address[AT_W-1:0]),
                .out_enable   (advance),
                .read_data    (marked[p])
            );

            if (PARTS == 1) begin : g_only
                assign here = 1'b1;
            end else begin : g_one_of
                localparam [31:0] PART = p;
                assign here = mark_at[ADDR_W-1:PART_W] == PART[ADDR_W-PART_W-1:0];
            end
        end
        if (PARTS == 1) begin : g_one
            assign is_marked = marked;
        end else begin : g_choice
            reg [ADDR_W-PART_W-1:0] read_part, held_part;
            always @(posedge clk)
                if (advance) begin
                    read_part <= address[ADDR_W-1:PART_W];
                    held_part <= read_part;
                end
            assign is_marked = marked[held_part];
        end
    endgenerate

    always @(posedge clk) begin
        if (advance) begin
            valid    <= {valid[3:0], s_valid};
            is_event <= {is_event[3:0], s_event};
            outside  <= {outside[2:0], column >= COLUMNS || row >= ROWS};
            token    <= {token[4*TOKEN_W-1:0], s_tick, s_skip, s_x, s_y, s_p};
            product  <= row_base[ADDR_W-1:0];
            across   <= column[ADDR_W-1:0];
            address  <= product + across;
            hot      <= is_marked || outside[3];
        end
        if (rst) valid <= 5'd0;
    end

    wire [TICK_W-1:0] tick;
    wire              skip;
    wire [X_W+Y_W:0]  rest;  // x, y, p
    assign {tick, skip, rest} = token[4*TOKEN_W +: TOKEN_W];

    wire drops = is_event[4] && enable && hot;

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(valid[4] && !marks),
        .s_ready(space),
        .s_data ({tick, is_event[4] && !drops, skip || drops, rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign s_ready = advance;
    assign idle    = !mask_valid && !comes && !marks && valid == 5'd0 && !m_valid;

    wire unused = &{1'b0, row_base, mask_product};

endmodule

`default_nettype wire
