// SPDX-License-Identifier: Apache-2.0
// Keeps an event when the last events of its 8 neighbours, each with a weight that decays as exp(-age / tau), add up to
// enough (docs/filters.md): the paper's activity memory with decaying weights.
//
// Time is measured in units of 1/32 of a half-life, in which the stamps are stored. A weight is halved once per 32 units, so after 257
// it is 0, and stamps of 9 bits, exact below an age of 384, are sufficient for any rate: see stamp_walk.v.
//
// With CELL_PX > 0 the memory is cell_memory.v: stamps of 9, 7 or 5 bits of cells of 1, 2 or 4 pixels, in units of 1/32, 1/8 or
// 1/2 of a half-life; the 9 cells around an event count, its own if that cell's last event was on another pixel.
//
// Latency:    13 clocks from s_ to m_: products and sum of the clock, 6 of the memory, table, halving, sums, sum, decision; with
//             CELL_PX > 0 it is 16, 9 of the memory.
// Throughput: 1 token per clock; for stalls by the walk over the memory, which are rare, see stamp_walk.v.
// Stall:      while the output is full, the pipeline stalls.
// Reset:      becomes empty and clears the memory: ceil(WIDTH/4) * ceil(HEIGHT/4) + 6 clocks with idle low, in which two
//             tokens at most are taken.
// RAM:        16 * ceil(WIDTH/4) * ceil(HEIGHT/4) * 9 bits; with cells as many bits for WIDTH and HEIGHT in cells. Two multipliers, TICK_W x 13 and TICK_W x 12 bits.
// Combinational paths: none; s_ready comes from registers alone, and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module filter_decay #(
    parameter X_W    = 9,    // bits of an x address
    parameter Y_W    = 9,    // bits of a y address
    parameter TICK_W = 20,   // bits of the tick input
    parameter WIDTH  = 346,  // pixels of the sensor across
    parameter HEIGHT = 260,  // pixels of the sensor down
    parameter CELL_PX = 0    // side of a cell in pixels: 1, 2 or 4; 0: a time stamp per pixel
) (
    input  wire              clk,
    input  wire              rst,

    // registers: see filter_regs.v
    input  wire              enable,
    input  wire [24:0]       decay_rate,
    input  wire [7:0]        decay_epsilon,
    input  wire [11:0]       decay_support,

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

    output wire              idle  // nothing inside, memory emptied after reset
);

    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();

`include "decay_table.vh"

    localparam TOKEN_W   = TICK_W + X_W + Y_W + 4;
    localparam PRODUCT_W = TICK_W + 25;
    localparam COARSE    = (CELL_PX == 4) ? 4 : (CELL_PX == 2) ? 2 : 0;  // log2 of the units of 1/32 half-life in a step of a stamp
    localparam FRAC      = CLOCK_FRAC + COARSE;
    localparam CLOCK_W   = (PRODUCT_W > FRAC ? PRODUCT_W : FRAC) + 1;
    localparam UNITS_W   = CLOCK_W - FRAC;              // of one token
    localparam STAMP_W   = 9 - COARSE;

    // ---- how many units pass -----------------------------------------------------------------------------------------

    reg                  scaled_valid, passed_valid;
    reg [TOKEN_W-1:0]    scaled, passed;
    reg [TICK_W+12:0]    low_product;
    reg [TICK_W+11:0]    high_product;
    reg [FRAC-1:0]       fraction;  // of a unit, that has passed so far
    reg [UNITS_W-1:0]    units;

    wire               memory_ready;
    wire               moves = memory_ready || !passed_valid;
    wire [CLOCK_W-1:0] clock = {{UNITS_W{1'b0}}, fraction} + {{(CLOCK_W - TICK_W - 13) {1'b0}}, low_product}
                             + {{(CLOCK_W - PRODUCT_W) {1'b0}}, high_product, 13'd0};

    assign s_ready = moves;

    always @(posedge clk) begin
        if (moves) begin
            scaled_valid <= s_valid;
            scaled       <= {s_event && enable, s_tick, s_event, s_skip, s_x, s_y, s_p};
            low_product  <= {13'd0, s_tick} * {{TICK_W{1'b0}}, decay_rate[12:0]};
            high_product <= {12'd0, s_tick} * {{TICK_W{1'b0}}, decay_rate[24:13]};

            passed_valid <= scaled_valid;
            passed       <= scaled;
            units        <= clock[CLOCK_W-1:FRAC];
            if (scaled_valid) fraction <= clock[FRAC-1:0];
        end
        if (rst) begin
            scaled_valid <= 1'b0;
            passed_valid <= 1'b0;
            fraction     <= {FRAC{1'b0}};
        end
    end

    // ---- the neighbours ----------------------------------------------------------------------------------------------

    wire                  space;  // for one more token in the output: everything behind moves
    wire                  old_valid, old_inside, memory_idle;
    wire [TOKEN_W-1:0]    old;
    wire [15:0]           near;
    wire [16*STAMP_W-1:0] age;

    generate
        if (CELL_PX == 0) begin : g_pixels
            stamp_memory #(
                .X_W      (X_W),
                .Y_W      (Y_W),
                .WIDTH    (WIDTH),
                .HEIGHT   (HEIGHT),
                .STAMP_W  (STAMP_W),
                .SEGMENT_W(6),
                .STEP_W   (UNITS_W),
                .DATA_W   (TOKEN_W)
            ) u_memory (
                .clk     (clk),
                .rst     (rst),
                .advance (space),
                .s_valid (passed_valid),
                .s_ready (memory_ready),
                .s_step  (units),
                .s_access(passed[TOKEN_W-1]),
                .s_x     (passed[Y_W+1 +: X_W]),
                .s_y     (passed[1 +: Y_W]),
                .s_data  (passed),
                .m_valid (old_valid),
                .m_data  (old),
                .m_inside(old_inside),
                .m_near  (near),
                .m_age   (age),
                .idle    (memory_idle)
            );
        end else begin : g_cells
            localparam [STAMP_W-1:0] LONGEST = {2'b10, {(STAMP_W - 2) {1'b1}}};  // age that is exact; its weight is 0

            wire stays;
            wire unused = &{1'b0, stays};

            cell_memory #(
                .X_W    (X_W),
                .Y_W    (Y_W),
                .WIDTH  (WIDTH),
                .HEIGHT (HEIGHT),
                .CELL_PX(CELL_PX),
                .STEP_W (UNITS_W),
                .DATA_W (TOKEN_W),
                .AGES   (1)
            ) u_memory (
                .clk      (clk),
                .rst      (rst),
                .advance  (space),
                .silence  ({STAMP_W{1'b0}}),
                .window   (LONGEST),
                .s_valid  (passed_valid),
                .s_ready  (memory_ready),
                .s_step   (units),
                .s_access (passed[TOKEN_W-1]),
                .s_x      (passed[Y_W+1 +: X_W]),
                .s_y      (passed[1 +: Y_W]),
                .s_data   (passed),
                .m_valid  (old_valid),
                .m_data   (old),
                .m_inside (old_inside),
                .m_stays  (stays),
                .m_supports(near),
                .m_age    (age),
                .idle     (memory_idle)
            );
        end
    endgenerate

    wire [16*5-1:0] fine;  // the ages' units of 1/32 half-life within one

    genvar b;
    generate
        for (b = 0; b < 16; b = b + 1) begin : g_fine
            if (COARSE == 0) begin : g_all
                assign fine[b*5 +: 5] = age[b*STAMP_W +: 5];
            end else begin : g_some
                assign fine[b*5 +: 5] = {age[b*STAMP_W +: 5 - COARSE], {COARSE{1'b0}}};
            end
        end
    endgenerate

    // ---- their weights -----------------------------------------------------------------------------------------------

    reg               tabled_valid, tabled_inside, weighed_valid, weighed_inside, added_valid, added_inside;
    reg [TOKEN_W-1:0] tabled, weighed, added;
    reg [16*9-1:0]    full;      // weight before it is halved, 0 of what is no neighbour
    reg [16*4-1:0]    halvings;
    reg [16*9-1:0]    weight;
    reg [4*11-1:0]    sums;      // of four weights each
    reg               total_valid, total_inside;
    reg [TOKEN_W-1:0] total;
    reg [11:0]        support;   // 8 neighbours of 256 at most

    always @(posedge clk) begin : weigh
        integer k;
        reg [8:0] halved;
        if (space) begin
            for (k = 0; k < 16; k = k + 1) begin
                full[k*9 +: 9]     <= near[k] ? decay_weight(fine[k*5 +: 5]) : 9'd0;
                halvings[k*4 +: 4] <= near[k] ? age[k*STAMP_W + 5 - COARSE +: 4] : 4'd0;  // else never read, perhaps

                halved = full[k*9 +: 9] >> halvings[k*4 +: 4];
                weight[k*9 +: 9] <= (halved > {1'b0, decay_epsilon}) ? halved : 9'd0;
            end
            for (k = 0; k < 4; k = k + 1)
                sums[k*11 +: 11] <= ({2'd0, weight[k*36 +: 9]} + {2'd0, weight[k*36 + 9 +: 9]})
                                  + ({2'd0, weight[k*36 + 18 +: 9]} + {2'd0, weight[k*36 + 27 +: 9]});
            support <= ({1'b0, sums[10:0]} + {1'b0, sums[21:11]}) + ({1'b0, sums[32:22]} + {1'b0, sums[43:33]});
        end
    end

    always @(posedge clk) begin
        if (space) begin
            tabled_valid   <= old_valid;
            tabled_inside  <= old_inside;
            tabled         <= old;
            weighed_valid  <= tabled_valid;
            weighed_inside <= tabled_inside;
            weighed        <= tabled;
            added_valid    <= weighed_valid;
            added_inside   <= weighed_inside;
            added          <= weighed;
            total_valid    <= added_valid;
            total_inside   <= added_inside;
            total          <= added;
        end
        if (rst) begin
            tabled_valid  <= 1'b0;
            weighed_valid <= 1'b0;
            added_valid   <= 1'b0;
            total_valid   <= 1'b0;
        end
    end

    // ---- decision ----------------------------------------------------------------------------------------------------

    wire              judged, is_event, skip;
    wire [TICK_W-1:0] tick;
    wire [X_W+Y_W:0]  rest;  // x, y, p
    assign {judged, tick, is_event, skip, rest} = total;

    wire drops = judged && !(total_inside && support >= decay_support);

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(total_valid),
        .s_ready(space),
        .s_data ({tick, is_event && !drops, skip || drops, rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign idle = memory_idle && !scaled_valid && !passed_valid && !tabled_valid && !weighed_valid && !added_valid && !total_valid
                  && !m_valid;

endmodule

`default_nettype wire
