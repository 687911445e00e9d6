// SPDX-License-Identifier: Apache-2.0
// Measures the noise of the stream, and gives each token the support that an event then needs: docs/filters.md, "Support that
// follows the noise". A word for each cell of 8 x 8 pixels holds the number of the window in which it last had an event, the
// event's place, and whether another pixel had one, too. A window's end is computed between two tokens.
//
// Latency:    5 clocks from s_ to m_.
// Throughput: 1 token per clock; the end of a window that had events takes NUM_W + 2 MEAN_W + 16 clocks, 101 at 346x260, and one more for each
//             measured window before it, 4 at most.
// Stall:      while the output is full, the pipeline stalls.
// Reset:      becomes empty and clears the cells: (WIDTH / 8) * (HEIGHT / 8) clocks with idle low, in which one token at most is
//             taken.
// RAM:        (WIDTH / 8) * (HEIGHT / 8) * 18 bits.
// Combinational paths: none; s_ready comes from registers alone, and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module noise_support #(
    parameter X_W    = 9,    // bits of an x address
    parameter Y_W    = 9,    // bits of a y address
    parameter TICK_W = 20,   // bits of the tick input
    parameter WIDTH  = 346,  // pixels of the sensor across
    parameter HEIGHT = 260   // pixels of the sensor down
) (
    input  wire              clk,
    input  wire              rst,

    // registers: see filter_regs.v
    input  wire              follow,       // 0: the support is fixed, and nothing is measured
    input  wire [3:0]        fixed,
    input  wire [4:0]        noise_log2,
    output wire [2:0]        noise_asked,  // the low bits of the address of noise_2 ... noise_6
    input  wire [15:0]       noise_least,  // its value

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
    output wire [3:0]        m_support,  // 9: no event has enough

    output wire              idle        // nothing inside, memory emptied after reset
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(WIDTH >= `EVCOT_WIDTH_MIN && WIDTH <= `EVCOT_WIDTH_MAX)) WIDTH_must_be_1_to_65536 ();
    parameter_check #(.OK(HEIGHT >= `EVCOT_HEIGHT_MIN && HEIGHT <= `EVCOT_HEIGHT_MAX)) HEIGHT_must_be_1_to_65536 ();
    parameter_check #(.OK(WIDTH <= 16777216 / HEIGHT)) WIDTH_times_HEIGHT_must_be_at_most_2_to_the_24 ();

    localparam COLS      = (WIDTH >= 8) ? WIDTH / 8 : 1;
    localparam ROWS      = (HEIGHT >= 8) ? HEIGHT / 8 : 1;
    localparam CELLS     = COLS * ROWS;
    localparam ADDR_W    = (CELLS > 1) ? $clog2(CELLS) : 1;
    localparam COUNT_W   = (CELLS > 1) ? $clog2(CELLS + 1) : 2;
    localparam NUMBER_W  = 11;              // of a window
    localparam WORD_W    = NUMBER_W + 1 + 6;
    localparam FRAC      = 8;
    localparam SHORTER   = 6;               // the shortest window is 2^-6 of the longest
    localparam NOW_W     = 20;              // the longest window has at most 2^20 ticks
    localparam SUM_W     = (TICK_W > NOW_W ? TICK_W : NOW_W) + 1;
    localparam EMPTY_W   = COUNT_W + FRAC;
    localparam ALONE_W   = EMPTY_W + SHORTER;
    localparam MEAN_W    = ALONE_W + 1;     // bits of a mean that is computed, with sign
    localparam PLACE_W   = 6;               // of a bit in it
    localparam NUM_W     = ALONE_W + FRAC;
    localparam TOKEN_W   = TICK_W + X_W + Y_W + 3;
    localparam [3:0] UNKNOWN = 4'd9;
    localparam [`EVCOT_FREG_W-1:0] NOISE_2 = `EVCOT_FREG_NOISE_2;
    localparam [`EVCOT_FREG_W-1:0] NOISE_6 = `EVCOT_FREG_NOISE_6;

    localparam [31:0] ACROSS      = WIDTH;
    localparam [31:0] DOWN        = HEIGHT;
    localparam [31:0] COLUMNS     = COLS;
    localparam [31:0] LINES       = ROWS;
    localparam [31:0] ALL_CELLS   = CELLS;
    localparam [31:0] LAST_CELL   = CELLS - 1;

    // ---- input: the product in a cell's address ----------------------------------------------------------------------

    wire [31:0] x       = {{(32 - X_W) {1'b0}}, s_x};
    wire [31:0] y       = {{(32 - Y_W) {1'b0}}, s_y};
    wire [31:0] column  = x >> 3;
    wire [31:0] line    = y >> 3;
    wire [31:0] product = line * COLUMNS;
    wire        counts  = s_event && x < ACROSS && y < DOWN && column < COLUMNS && line < LINES;

    reg                in_valid, in_counts;
    reg  [ADDR_W-1:0]  in_product, in_column;
    reg  [5:0]         in_place;
    reg  [TOKEN_W-1:0] in_token;
    wire [TICK_W-1:0]  in_tick = in_token[TOKEN_W-1 -: TICK_W];
    wire               in_ready;

    assign s_ready = in_ready || !in_valid;

    always @(posedge clk) begin
        if (s_ready) begin
            in_valid   <= s_valid;
            in_counts  <= counts;
            in_product <= product[ADDR_W-1:0];
            in_column  <= column[ADDR_W-1:0];
            in_place   <= {y[2:0], x[2:0]};
            in_token   <= {s_tick, s_event, s_skip, s_x, s_y, s_p};
        end
        if (rst) in_valid <= 1'b0;
    end

    // ---- stages: time, read, held, compared --------------------------------------------------------------------------

    reg               clearing_reg;
    reg [ADDR_W-1:0]  cleared_reg;
    wire              space;  // for one more token in the output

    reg               time_valid, time_counts, time_ends;  // ends: a window ends before this token
    reg               read_valid, read_counts, held_valid, held_counts, same_last, same_second;
    reg [ADDR_W-1:0]  time_address, read_address, held_address, last_address;
    reg [5:0]         time_place, read_place, held_place;
    reg [TOKEN_W-1:0] time_token, read_token, held_token;
    reg [WORD_W-1:0]  last_word, second_word;
    reg               last_counts;

    reg [NOW_W-1:0]    now_reg;
    reg [2:0]          shorter_reg;   // log2 of how much shorter than the longest the open window is
    reg [NUMBER_W-1:0] number_reg;    // of the open window
    reg [COUNT_W-1:0]  touched_reg;   // cells with an event in the open window
    reg [COUNT_W-1:0]  alone_reg;     // those of them with one pixel

    reg  [2:0]       most;            // its limit
    reg  [2:0]       shorter;         // shorter_reg, within that limit
    reg  [4:0]       window_reg;  // log2 of the open window's ticks
    reg  [SUM_W-1:0] above_reg;   // the bits of a tick above it; settled two clocks after a change of `shorter`
    wire [SUM_W-1:0] wide_now = {{(SUM_W - NOW_W) {1'b0}}, now_reg};
    wire [SUM_W-1:0] later    = wide_now + {{(SUM_W - TICK_W) {1'b0}}, in_tick};

    wire goes = time_valid && !time_ends;  // the token in `time` goes on

    assign in_ready = space && !clearing_reg && (!time_valid || goes);

    wire [WORD_W-1:0] held_word;
    wire [WORD_W-1:0] word    = same_last ? last_word : same_second ? second_word : held_word;
    wire              fresh   = word[WORD_W-1 -: NUMBER_W] != number_reg;
    wire              second  = !fresh && !word[6] && word[5:0] != held_place;  // a second pixel of its cell
    wire [WORD_W-1:0] changed = fresh ? {number_reg, 1'b0, held_place} : {word[WORD_W-1:7], word[6] || second, word[5:0]};
    wire              notes   = space && held_valid && held_counts;

    block_memory #(
        .W    (WORD_W),
        .DEPTH(CELLS)
    ) u_cells (
        .clk          (clk),
        .write        (clearing_reg || (notes && (fresh || second))),
        .write_address(clearing_reg ? cleared_reg : held_address),
        .write_data   (clearing_reg ? {WORD_W{1'b0}} : changed),
        .read_enable  (space),
        .read_address (time_address),
        .out_enable   (space),
        .read_data    (held_word)
    );

    always @(posedge clk) begin
        if (space) begin
            if (!time_valid || goes) begin
                time_valid   <= in_valid && in_ready;
                time_counts  <= in_counts && follow;
                time_address <= in_product + in_column;
                time_place   <= in_place;
                time_token   <= in_token;
            end
            read_valid   <= goes;
            read_counts  <= time_counts;
            read_address <= time_address;
            read_place   <= time_place;
            read_token   <= time_token;

            held_valid   <= read_valid;
            held_counts  <= read_counts;
            held_address <= read_address;
            held_place   <= read_place;
            held_token   <= read_token;
            same_last    <= held_valid && held_counts && held_address == read_address;
            same_second  <= last_counts && last_address == read_address;

            last_counts  <= held_valid && held_counts;
            last_address <= held_address;
            last_word    <= changed;
            second_word  <= last_word;
        end
        if (in_valid && in_ready) now_reg <= later[NOW_W-1:0];
        if (clearing_reg) begin
            cleared_reg  <= cleared_reg + 1'b1;
            clearing_reg <= cleared_reg != LAST_CELL[ADDR_W-1:0];
        end
        if (rst) begin
            time_valid   <= 1'b0;
            read_valid   <= 1'b0;
            held_valid   <= 1'b0;
            last_counts  <= 1'b0;
            now_reg      <= {NOW_W{1'b0}};
            clearing_reg <= 1'b1;
            cleared_reg  <= {ADDR_W{1'b0}};
        end
    end

    // ---- the end of a window: means, their quotient, and the thresholds that it reaches --------------------------------

    localparam [3:0] RUNNING  = 4'd0;
    localparam [3:0] BEGIN    = 4'd1;
    localparam [3:0] MEANS    = 4'd2;
    localparam [3:0] SUBTRACT = 4'd3;   // how far the window is from both means, bit by bit
    localparam [3:0] HALVE    = 4'd4;   // a part of that
    localparam [3:0] ADD      = 4'd5;   // is added to the means, bit by bit
    localparam [3:0] DIVIDE   = 4'd6;
    localparam [3:0] COMPARE  = 4'd7;
    localparam [3:0] OPEN     = 4'd8;
    localparam [3:0] SETTLE   = 4'd9;

    reg [3:0]         state_reg;
    reg [2:0]         windows_reg;      // so far, 4 at most
    reg [COUNT_W-1:0] empty_reg;
    reg               dense_reg, sparse_reg, settled_reg;
    reg [15:0]        level_reg;
    reg [3:0]         support_reg;
    reg [2:0]         step_reg;         // in HALVE halvings, in COMPARE the threshold
    reg [PLACE_W-1:0] place_reg;        // in SUBTRACT and ADD, of the bit: 0 is that of 1, so the first one is -FRAC

    assign noise_asked = step_reg;

    wire [COUNT_W+1:0] four_empty   = {empty_reg, 2'b00};
    wire [COUNT_W+1:0] four_touched = {touched_reg, 2'b00};
    wire [COUNT_W+1:0] all_cells    = {2'b00, ALL_CELLS[COUNT_W-1:0]};
    wire               measured     = !dense_reg || shorter == most;
    wire [2:0]         next_shorter = !dense_reg ? shorter - {2'd0, shorter != 3'd0} : shorter + {2'd0, shorter != most};

    localparam [31:0] FIRST = (1 << PLACE_W) - FRAC, LAST = MEAN_W - FRAC - 1;

    wire               last_bit = place_reg == LAST[PLACE_W-1:0];
    wire               subtracts = state_reg == SUBTRACT;
    wire               halves    = state_reg == HALVE && step_reg != windows_reg;
    wire               adds      = state_reg == ADD;
    wire [MEAN_W-1:0]  mean_alone, mean_empty;
    wire [PLACE_W-1:0] alone_place = place_reg - {{(PLACE_W - 3) {1'b0}}, shorter};  // as in the longest window
    wire [(1<<PLACE_W)-1:0] alone_bits = {{((1 << PLACE_W) - COUNT_W) {1'b0}}, alone_reg};
    wire [(1<<PLACE_W)-1:0] empty_bits = {{((1 << PLACE_W) - COUNT_W) {1'b0}}, empty_reg};

    noise_mean #(
        .W(MEAN_W)
    ) u_alone (
        .clk      (clk),
        .rst      (rst),
        .subtracts(subtracts),
        .halves   (halves),
        .adds     (adds),
        .value    (alone_bits[alone_place]),
        .mean     (mean_alone)
    );

    noise_mean #(
        .W(MEAN_W)
    ) u_empty (
        .clk      (clk),
        .rst      (rst),
        .subtracts(subtracts),
        .halves   (halves),
        .adds     (adds),
        .value    (empty_bits[place_reg]),
        .mean     (mean_empty)
    );

    wire             divide_ready, level_valid;
    wire [NUM_W-1:0] quotient;
    wire [EMPTY_W-1:0] remainder;

    divider #(
        .NUM_W(NUM_W),
        .DEN_W(EMPTY_W)
    ) u_divider (
        .clk    (clk),
        .rst    (rst),
        .s_valid(state_reg == DIVIDE),
        .s_ready(divide_ready),
        .s_num  ({mean_alone[ALONE_W-1:0], {FRAC{1'b0}}}),
        .s_den  (mean_empty[EMPTY_W-1:0]),
        .m_valid(level_valid),
        .m_ready(1'b1),
        .m_quot (quotient),
        .m_rem  (remainder)
    );

    always @(posedge clk) begin
        shorter    <= (most < shorter_reg) ? most : shorter_reg;
        most       <= (noise_log2 < 5'd6) ? noise_log2[2:0] : 3'd6;
        window_reg <= noise_log2 - {2'd0, shorter};
        above_reg  <= {SUM_W{1'b1}} << window_reg;
        if (notes) begin
            touched_reg <= touched_reg + {{(COUNT_W - 1) {1'b0}}, fresh};
            alone_reg   <= fresh ? alone_reg + 1'b1 : second ? alone_reg - 1'b1 : alone_reg;
        end
        if (in_valid && in_ready) time_ends <= follow && |((later ^ wide_now) & above_reg);
        case (state_reg)
            RUNNING:  // until the tokens before the window's end are noted
                if (time_valid && time_ends && !read_valid && !held_valid) begin
                    state_reg <= BEGIN;
                    empty_reg <= ALL_CELLS[COUNT_W-1:0] - touched_reg;
                end
            BEGIN: begin
                dense_reg  <= four_empty < all_cells;
                sparse_reg <= four_touched < all_cells;
                step_reg   <= 3'd0;
                if (touched_reg == {COUNT_W{1'b0}}) begin
                    state_reg <= RUNNING;
                    time_ends <= 1'b0;
                end else state_reg <= MEANS;
            end
            MEANS: begin
                place_reg <= FIRST[PLACE_W-1:0];
                state_reg <= measured ? SUBTRACT : OPEN;
            end
            SUBTRACT: begin
                place_reg <= place_reg + 1'b1;
                if (last_bit) state_reg <= HALVE;
            end
            HALVE: begin
                place_reg <= FIRST[PLACE_W-1:0];
                step_reg  <= step_reg + 1'b1;
                if (!halves) state_reg <= ADD;
            end
            ADD: begin
                place_reg <= place_reg + 1'b1;
                if (last_bit) begin
                    windows_reg <= (windows_reg == 3'd4) ? 3'd4 : windows_reg + 1'b1;
                    state_reg   <= DIVIDE;
                end
            end
            DIVIDE: begin
                step_reg <= NOISE_2[2:0];
                if (level_valid) begin
                    level_reg   <= (|quotient[NUM_W-1:16]) ? 16'hffff : quotient[15:0];
                    support_reg <= 4'd1;
                    state_reg   <= COMPARE;
                end
            end
            COMPARE: begin
                if (level_reg >= noise_least) support_reg <= support_reg + 1'b1;
                step_reg <= step_reg + 1'b1;
                if (step_reg == NOISE_6[2:0]) state_reg <= OPEN;
            end
            OPEN: begin
                if (dense_reg || sparse_reg) {shorter_reg, shorter} <= {2{next_shorter}};
                touched_reg <= {COUNT_W{1'b0}};
                alone_reg   <= {COUNT_W{1'b0}};
                number_reg  <= number_reg + 1'b1;
                state_reg   <= SETTLE;
                settled_reg <= 1'b0;
            end
            SETTLE: begin  // until `above_reg` is that of the new window
                settled_reg <= 1'b1;
                if (settled_reg) begin
                    time_ends <= 1'b0;
                    state_reg <= RUNNING;
                end
            end
            default: state_reg <= RUNNING;
        endcase
        if (rst) begin
            state_reg      <= RUNNING;
            time_ends      <= 1'b0;
            touched_reg    <= {COUNT_W{1'b0}};
            alone_reg      <= {COUNT_W{1'b0}};
            number_reg     <= {{(NUMBER_W - 1) {1'b0}}, 1'b1};
            {shorter_reg, shorter} <= 6'd0;
            windows_reg    <= 3'd0;
            support_reg    <= UNKNOWN;
        end
    end

    // ---- output ------------------------------------------------------------------------------------------------------

    skid_buffer #(
        .W(TOKEN_W + 4)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(held_valid),
        .s_ready(space),
        .s_data ({held_token, follow ? support_reg : fixed}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p, m_support})
    );

    assign idle = !clearing_reg && !in_valid && !time_valid && !read_valid && !held_valid && !m_valid;

    // The divider is free when it is asked.
    wire unused = &{1'b0, divide_ready, remainder, NOISE_2, NOISE_6, product, mean_alone[ALONE_W], mean_empty[MEAN_W-1:EMPTY_W]};

endmodule

`default_nettype wire
