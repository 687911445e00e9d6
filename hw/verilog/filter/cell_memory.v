// SPDX-License-Identifier: Apache-2.0
// Stores the last event of each cell of CELL_PX x CELL_PX pixels: its place within the cell, and its time in STAMP_W bits, in
// words of 9 bits if STAMP_W is left alone. Of an event it reads the 9 cells around it at once: 16 banks, by the low two bits of the cell's
// column and row.
//
// Stamps have W = 9 - 2 log2(CELL_PX) bits, 9, 7 or 5, or more. With stamp_walk.v and segments of 2^(W-3) steps every age below
// KEEP = 3 * 2^(W-2) steps, 384, 96 or 24 at least, is exact; an age of KEEP or more means none, or none that matters.
//
// An event whose cell's last stored event was at the same place less than `silence` steps ago is not stored: m_stays is low.
// The decision comes five stages after the read; stamp_bank.v corrects what was read by what the five slots ahead store.
//
// Latency:    9 clocks from s_ to m_: product, and 8 of stamp_slots.v.
// Throughput: 1 token per clock; for stalls by the walk, which are rare, see stamp_walk.v.
// Stall:      while advance is low the pipeline stalls; m_ outputs are held.
// Reset:      no token inside; then all cells are cleared: ceil(WIDTH / 4 CELL_PX) * ceil(HEIGHT / 4 CELL_PX) + 8 clocks with idle
//             low, in which two tokens at most are taken.
// RAM:        16 * ceil(WIDTH / 4 CELL_PX) * ceil(HEIGHT / 4 CELL_PX) words. One read and one write port per bank.
// Combinational paths: none; s_ready comes from registers alone.
`default_nettype none
`include "evcot_defs.vh"

module cell_memory #(
    parameter X_W     = 9,    // bits of an x address
    parameter Y_W     = 9,    // bits of a y address
    parameter WIDTH   = 346,  // pixels of the sensor across
    parameter HEIGHT  = 260,  // pixels of the sensor down
    parameter CELL_PX = 1,    // side of a cell in pixels: 1, 2 or 4
    parameter STEP_W  = 21,   // bits of a token's steps
    parameter DATA_W  = 1,    // bits that travel with a token
    parameter STAMP_W = (CELL_PX == 4) ? 5 : (CELL_PX == 2) ? 7 : 9  // bits of a time stamp, no fewer
) (
    input  wire                  clk,
    input  wire                  rst,
    input  wire                  advance,

    input  wire [STAMP_W-1:0]    silence,    // steps, KEEP at most; 0: every event is stored

    // tokens: s_step steps have passed, then an event to look up and to store, if s_access
    input  wire                  s_valid,
    output wire                  s_ready,
    input  wire [STEP_W-1:0]     s_step,
    input  wire                  s_access,
    input  wire [X_W-1:0]        s_x,
    input  wire [Y_W-1:0]        s_y,
    input  wire [DATA_W-1:0]     s_data,

    // bank 4 * (row % 4) + column % 4: the age of the cell that it holds around the event, in m_age[bank*STAMP_W +: STAMP_W]
    output wire                  m_valid,
    output wire [DATA_W-1:0]     m_data,
    output wire                  m_inside,   // the event lies on the sensor
    output wire                  m_stays,    // it was stored
    output reg  [15:0]           m_reached,  // banks whose last event may support it: all on the sensor, its own if of another pixel
    output reg  [16*STAMP_W-1:0] m_age,

    output wire                  idle        // nothing inside, memory emptied after reset
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(WIDTH >= `EVCOT_WIDTH_MIN && WIDTH <= `EVCOT_WIDTH_MAX)) WIDTH_must_be_1_to_65536 ();
    parameter_check #(.OK(HEIGHT >= `EVCOT_HEIGHT_MIN && HEIGHT <= `EVCOT_HEIGHT_MAX)) HEIGHT_must_be_1_to_65536 ();
    parameter_check #(.OK(WIDTH <= 16777216 / HEIGHT)) WIDTH_times_HEIGHT_must_be_at_most_2_to_the_24 ();
    parameter_check #(.OK(STAMP_W >= ((CELL_PX == 4) ? 5 : (CELL_PX == 2) ? 7 : 9) && STAMP_W <= 32)) STAMP_W_must_hold_the_ages ();
    parameter_check #(.OK(CELL_PX == 1 || CELL_PX == 2 || CELL_PX == 4)) CELL_PX_must_be_1_or_2_or_4 ();

    localparam SHIFT   = (CELL_PX == 4) ? 2 : (CELL_PX == 2) ? 1 : 0;
    localparam WORD_W  = STAMP_W + 2 * SHIFT;
    localparam PLACE_W = (SHIFT == 0) ? 1 : 2 * SHIFT;  // with one pixel in a cell always 0, and not stored
    localparam SEGMENT_W = STAMP_W - 3;

    localparam CELLS_X = (WIDTH + CELL_PX - 1) / CELL_PX;
    localparam CELLS_Y = (HEIGHT + CELL_PX - 1) / CELL_PX;
    localparam COLS    = (CELLS_X + 3) / 4;  // squares of 4 x 4 cells: a word of each bank
    localparam ROWS    = COLS * ((CELLS_Y + 3) / 4);
    localparam ROW_W   = (ROWS > 1) ? $clog2(ROWS) : 1;
    localparam PASS_W  = 32 + PLACE_W + 1 + DATA_W;  // column and row of 16 bits, place, on the sensor, data

    localparam [31:0] ACROSS = WIDTH;
    localparam [31:0] DOWN   = HEIGHT;
    localparam [31:0] END_X  = CELLS_X;
    localparam [31:0] END_Y  = CELLS_Y;
    localparam [31:0] STRIDE = COLS;

    localparam [STAMP_W-1:0] KEEP = {2'b11, {(STAMP_W - 2) {1'b0}}};

    // ---- the event's cell, and the product in its address ------------------------------------------------------------

    wire [31:0] x        = {{(32 - X_W) {1'b0}}, s_x};
    wire [31:0] y        = {{(32 - Y_W) {1'b0}}, s_y};
    wire [31:0] column   = x >> SHIFT;
    wire [31:0] line     = y >> SHIFT;
    wire [31:0] product  = (line >> 2) * STRIDE;
    wire        on_sensor = x < ACROSS && y < DOWN;

    wire [PLACE_W-1:0] place;
    generate
        if (SHIFT == 0) begin : g_pixel
            assign place = 1'b0;
        end else begin : g_cell
            assign place = {y[SHIFT-1:0], x[SHIFT-1:0]};
        end
    endgenerate

    localparam MADE_W = 1 + STEP_W + PASS_W + 2 * ROW_W;

    wire              made_valid, made_ready, made_access;
    wire [STEP_W-1:0] made_step;
    wire [PASS_W-1:0] made;
    wire [ROW_W-1:0]  made_product;
    wire [ROW_W-1:0]  made_square;  // across

    skid_buffer #(
        .W(MADE_W)
    ) u_made (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_valid),
        .s_ready(s_ready),
        .s_data ({s_access && on_sensor, s_step, line[15:0], column[15:0], place, on_sensor, s_data, product[ROW_W-1:0],
                  column[2 +: ROW_W]}),
        .m_valid(made_valid),
        .m_ready(made_ready),
        .m_data ({made_access, made_step, made, made_product, made_square})
    );

    // ---- slots -------------------------------------------------------------------------------------------------------

    wire [6:0]           access, visits;
    wire [7*ROW_W-1:0]   row;
    wire [7*STAMP_W-1:0] now;
    wire [7*PASS_W-1:0]  pass;
    wire                 clearing, slots_idle;

    stamp_slots #(
        .STAMP_W  (STAMP_W),
        .SEGMENT_W(SEGMENT_W),
        .STEP_W   (STEP_W),
        .ROWS     (ROWS),
        .ROW_W    (ROW_W),
        .DATA_W   (PASS_W)
    ) u_slots (
        .clk     (clk),
        .rst     (rst),
        .advance (advance),
        .s_valid (made_valid),
        .s_ready (made_ready),
        .s_step  (made_step),
        .s_access(made_access),
        .s_row   (made_product + made_square),
        .s_data  (made),
        .access  (access),
        .visits  (visits),
        .row     (row),
        .now     (now),
        .data    (pass),
        .m_valid (m_valid),
        .clearing(clearing),
        .idle    (slots_idle)
    );

    wire [7*16-1:0]      columns, lines;
    wire [7*PLACE_W-1:0] places;

    genvar s;
    generate
        for (s = 0; s < 7; s = s + 1) begin : g_stage
            assign lines[s*16 +: 16]            = pass[s*PASS_W + DATA_W + 1 + PLACE_W + 16 +: 16];
            assign columns[s*16 +: 16]          = pass[s*PASS_W + DATA_W + 1 + PLACE_W +: 16];
            assign places[s*PLACE_W +: PLACE_W] = pass[s*PASS_W + DATA_W + 1 +: PLACE_W];
        end
    endgenerate

    // ---- which of the five slots ahead is at a cell that the slot in `ask` reads, and which at its own ---------------

    reg  [4:0] at_column, at_line, at_row;  // of the slot in `read` with the five ahead of it, the next in bit 0
    wire [4:0] meets_read = visits[1] ? at_row : at_column & at_line;
    reg  [3:0] meets_found;
    reg  [2:0] meets_held;
    reg  [1:0] meets_taken;
    reg        meets_then;
    reg  [1:0] same_read, same_found, same_held, same_taken;  // with the two slots next ahead
    reg        same_then;

    function beside;  // or equal
        input [15:0] one, other;
        reg   [16:0] difference;
        begin
            difference = {1'b0, one} - {1'b0, other};
            beside     = difference == 17'd0 || difference == 17'd1 || (&difference);
        end
    endfunction

    always @(posedge clk) begin : meets
        integer k;
        if (advance) begin
            for (k = 1; k < 6; k = k + 1) begin
                at_column[k-1] <= access[k] && beside(columns[k*16 +: 16], columns[15:0]);
                at_line[k-1]   <= access[k] && beside(lines[k*16 +: 16], lines[15:0]);
                at_row[k-1]    <= access[k] && row[k*ROW_W +: ROW_W] == row[ROW_W-1:0];
            end
            meets_found <= meets_read[3:0];
            meets_held  <= meets_found[2:0];
            meets_taken <= meets_held[1:0];
            meets_then  <= meets_taken[0];
            for (k = 1; k < 3; k = k + 1)
                same_read[k-1] <= access[k] && columns[k*16 +: 16] == columns[15:0] && lines[k*16 +: 16] == lines[15:0];
            same_found  <= same_read;
            same_held   <= same_found;
            same_taken  <= same_held;
            same_then   <= same_taken[0];
        end
    end

    // ---- the event's own cell: whether it stays ----------------------------------------------------------------------

    wire [16*WORD_W-1:0] taken;  // of all banks

    reg                  young;     // in `age`: its place had a stored event less than `silence` ago
    wire                 stays      = access[6] && !young;
    wire [STAMP_W-1:0]   age_now    = now[6*STAMP_W +: STAMP_W];
    wire [PLACE_W-1:0]   age_place  = places[6*PLACE_W +: PLACE_W];
    wire [STAMP_W-1:0]   then_now   = now[5*STAMP_W +: STAMP_W];
    wire [PLACE_W-1:0]   then_place = places[5*PLACE_W +: PLACE_W];
    wire [WORD_W:0]      stored     = {{(WORD_W + 1 - STAMP_W - PLACE_W) {1'b0}}, age_place, visits[6] ? age_now - KEEP : age_now};
    wire [WORD_W-1:0]    write_word = stored[WORD_W-1:0];
    reg  [WORD_W-1:0]    last_word, second_word;

    wire [3:0]           taken_bank = {lines[4*16 +: 2], columns[4*16 +: 2]};
    reg  [WORD_W-1:0]    own_then;
    wire [WORD_W:0]      own        = {1'b0, own_then};
    wire [PLACE_W-1:0]   own_place  = own[STAMP_W +: PLACE_W];
    wire [STAMP_W-1:0]   own_age    = then_now - own_then[STAMP_W-1:0];
    wire [STAMP_W-1:0]   apart      = then_now - age_now;  // of the slot in `then` from the one in `age`
    wire                 follows    = same_then && stays;
    reg                  elsewhere;  // in `age`: the last event of its cell was of another pixel

    always @(posedge clk)
        if (advance) begin
            last_word   <= write_word;
            second_word <= last_word;
            own_then    <= (same_taken[1] && stays) ? write_word : taken[taken_bank*WORD_W +: WORD_W];
            young       <= follows ? age_place == then_place && apart < silence
                                   : own_place == then_place && own_age < silence;
            elsewhere   <= follows ? age_place != then_place : own_place != then_place;
        end

    // ---- banks -------------------------------------------------------------------------------------------------------

    wire [31:0] taken_column = {16'd0, columns[4*16 +: 16]};
    wire [31:0] taken_line   = {16'd0, lines[4*16 +: 16]};
    wire [1:0]  then_column  = columns[5*16 +: 2];
    wire [1:0]  then_line    = lines[5*16 +: 2];
    reg         then_left, then_right, then_above, then_below;  // a cell beside it is on the sensor

    always @(posedge clk)
        if (advance) begin
            then_left  <= taken_column != 32'd0;
            then_right <= taken_column + 32'd1 < END_X;
            then_above <= taken_line != 32'd0;
            then_below <= taken_line + 32'd1 < END_Y;
        end

    // Which columns and lines of banks hold the slot's own cell in `then`, and which one beside it too.
    wire [3:0]  own_column  = 4'd1 << then_column;
    wire [3:0]  own_line    = 4'd1 << then_line;
    wire [3:0]  near_column = own_column | ({own_column[2:0], own_column[3]} & {4{then_right}})
                                         | ({own_column[0], own_column[3:1]} & {4{then_left}});
    wire [3:0]  near_line   = own_line | ({own_line[2:0], own_line[3]} & {4{then_below}})
                                       | ({own_line[0], own_line[3:1]} & {4{then_above}});
    wire [15:0] own_bank    = {4{own_column}} & {{4{own_line[3]}}, {4{own_line[2]}}, {4{own_line[1]}}, {4{own_line[0]}}};
    wire [15:0] near_bank   = {4{near_column}} & {{4{near_line[3]}}, {4{near_line[2]}}, {4{near_line[1]}}, {4{near_line[0]}}};
    reg  [15:0] age_around, age_own;

    always @(posedge clk)
        if (advance) begin
            age_own    <= own_bank;
            age_around <= near_bank & ~own_bank;
        end

    reg [15:0] writes;  // of the slot in `age`: a visit empties what is too old

    always @* begin : which
        integer k;
        k      = 0;  // on every path, or it would be a latch
        writes = age_own & {16{stays}};
        if (visits[6])
            for (k = 0; k < 16; k = k + 1) writes[k] = clearing || (&m_age[k*STAMP_W + SEGMENT_W + 1 +: 2]);
    end

    // The word that the neighbour in a bank lies in; where there is none on the sensor, any.
    wire [ROW_W-1:0] right = {{(ROW_W - 1) {1'b0}}, !visits[0] && columns[1:0] == 2'd3};
    wire [ROW_W-1:0] left  = {ROW_W{!visits[0] && columns[1:0] == 2'd0}};
    wire [ROW_W-1:0] below = {ROW_W{!visits[0] && lines[1:0] == 2'd3}} & STRIDE[ROW_W-1:0];
    wire [ROW_W-1:0] above = {ROW_W{!visits[0] && lines[1:0] == 2'd0}} & ({ROW_W{1'b0}} - STRIDE[ROW_W-1:0]);

    genvar b;
    generate
        for (b = 0; b < 16; b = b + 1) begin : g_bank
            localparam [31:0] BANK = b;
            localparam [1:0]  COL  = BANK[1:0];
            localparam [1:0]  LINE = BANK[3:2];

            wire [ROW_W-1:0] aside   = COL == 2'd0 ? right : COL == 2'd3 ? left : {ROW_W{1'b0}};
            wire [ROW_W-1:0] astride = LINE == 2'd0 ? below : LINE == 2'd3 ? above : {ROW_W{1'b0}};

            reg  [ROW_W-1:0]  read_row;
            wire [WORD_W-1:0] was;
            wire              unused  = &{1'b0, was};

            stamp_bank #(
                .ROWS  (ROWS),
                .ROW_W (ROW_W),
                .WORD_W(WORD_W)
            ) u_bank (
                .clk        (clk),
                .advance    (advance),
                .read_row   (read_row),
                .writes     (writes[b]),
                .write_row  (row[6*ROW_W +: ROW_W]),
                .write_word (write_word),
                .last_word  (last_word),
                .second_word(second_word),
                .meets      ({meets_read[4], meets_found[3], meets_held[2], meets_taken[1], meets_then}),
                .taken      (taken[b*WORD_W +: WORD_W]),
                .was        (was)
            );

            always @(posedge clk)
                if (advance) begin
                    read_row                    <= row[ROW_W-1:0] + aside + astride;
                    m_age[b*STAMP_W +: STAMP_W] <= then_now - was[STAMP_W-1:0];
                end
        end
    endgenerate

    always @* m_reached = age_around | (age_own & {16{elsewhere}});

    wire   unused   = &{1'b0, access[0], visits[5:1], pass, places, column, line, product, stored, own, row, now, columns, lines};
    assign m_data   = pass[6*PASS_W +: DATA_W];
    assign m_inside = pass[6*PASS_W + DATA_W];
    assign m_stays  = stays;
    assign idle     = slots_idle && !made_valid;

endmodule

`default_nettype wire
