// SPDX-License-Identifier: Apache-2.0
// Stores the last event of each cell of CELL_PX x CELL_PX pixels: its place within the cell, and its time in STAMP_W bits, in
// words of 9 bits if STAMP_W is left alone. For an event it compares the 9 cells around it at once: 16 banks, by the low two bits of
// the cell's column and row.
//
// Stamps have W = 9 - 2 log2(CELL_PX) bits, 9, 7 or 5, or more. With stamp_walk.v and segments of 2^(W-3) steps every age below
// KEEP = 3 * 2^(W-2) steps, 384, 96 or 24 at least, is exact; an age of KEEP or more means none, or none that matters.
//
// An event whose cell's last stored event was at the same place less than `silence` steps ago is not stored: m_stays is low.
// The decision comes five stages after the read. What the five slots ahead store in the meantime is corrected: of the event's own
// cell in the word, of the others in the bit that tells that a cell supports.
//
// Latency:    9 clocks from s_ to m_: product, and 8 of stamp_slots.v.
// Throughput: 1 token per clock; for stalls by the walk, which are rare, see stamp_walk.v.
// Stall:      while advance is low the pipeline stalls; m_ outputs are held.
// Reset:      no token inside; then all cells are cleared: ceil(WIDTH / 4 CELL_PX) * ceil(HEIGHT / 4 CELL_PX) + 8 clocks with idle
//             low, in which one token at most is taken.
// RAM:        16 * ceil(WIDTH / 4 CELL_PX) * ceil(HEIGHT / 4 CELL_PX) words. One read and one write port per bank.
// Combinational paths: advance -> s_ready.
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
    parameter AGES    = 0,    // 1: with m_age
    parameter STAMP_W = (CELL_PX == 4) ? 5 : (CELL_PX == 2) ? 7 : 9  // bits of a time stamp, no fewer
) (
    input  wire                  clk,
    input  wire                  rst,
    input  wire                  advance,

    input  wire [STAMP_W-1:0]    silence,    // steps, KEEP at most; 0: every event is stored
    input  wire [STAMP_W-1:0]    window,     // steps, fewer than KEEP: a cell's last event supports one that is no later than that

    // tokens: s_step steps have passed, then an event to look up and to store, if s_access
    input  wire                  s_valid,
    output wire                  s_ready,
    input  wire [STEP_W-1:0]     s_step,
    input  wire                  s_access,
    input  wire [X_W-1:0]        s_x,
    input  wire [Y_W-1:0]        s_y,
    input  wire [DATA_W-1:0]     s_data,

    output wire                  m_valid,
    output wire [DATA_W-1:0]     m_data,
    output wire                  m_inside,   // the event lies on the sensor
    output wire                  m_stays,    // it was stored
    // cells around it whose last event supports it, its own if that was of another pixel: bank 4 * (row % 4) + column % 4
    output wire [15:0]           m_supports,
    output wire [16*STAMP_W-1:0] m_age,      // with AGES, of what supports; `window` must then be KEEP / 3 or more

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
    localparam LINES   = (CELLS_Y + 3) / 4;
    localparam ROWS    = COLS * LINES;
    localparam ROW_W   = (ROWS > 1) ? $clog2(ROWS) : 1;
    localparam SQUARE_X_W = (COLS > 1) ? $clog2(COLS) : 1;
    localparam SQUARE_Y_W = (LINES > 1) ? $clog2(LINES) : 1;
    localparam COLUMN_W   = SQUARE_X_W + 2;  // of a cell
    localparam LINE_W     = SQUARE_Y_W + 2;
    localparam PASS_W  = 1 + DATA_W;  // on the sensor, data

    localparam [31:0] ACROSS = WIDTH;
    localparam [31:0] DOWN   = HEIGHT;
    localparam [31:0] LAST_X = CELLS_X - 1;
    localparam [31:0] LAST_Y = CELLS_Y - 1;
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

    reg                 made_valid, made_access;
    reg  [STEP_W-1:0]   made_step;
    reg  [PASS_W-1:0]   made;
    reg  [ROW_W-1:0]    made_product;
    reg  [COLUMN_W-1:0] made_column;
    reg  [LINE_W-1:0]   made_line;
    reg  [PLACE_W-1:0]  made_place;
    wire                made_ready;
    wire [COLUMN_W+ROW_W-1:0] wide_column = {{ROW_W{1'b0}}, made_column};

    assign s_ready = made_ready || !made_valid;

    always @(posedge clk) begin
        if (s_ready) begin
            made_valid   <= s_valid;
            made_access  <= s_access && on_sensor;
            made_step    <= s_step;
            made         <= {on_sensor, s_data};
            made_product <= product[ROW_W-1:0];
            made_column  <= column[COLUMN_W-1:0];
            made_line    <= line[LINE_W-1:0];
            made_place   <= place;
        end
        if (rst) made_valid <= 1'b0;
    end

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
        .s_row   (made_product + wide_column[2 +: ROW_W]),
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

    // The cell of the token in each stage.
    reg  [7*COLUMN_W-1:0] columns;
    reg  [7*LINE_W-1:0]   lines;
    reg  [7*PLACE_W-1:0]  places;
    reg  [COLUMN_W-1:0]   entering_column;  // in front of `ask`
    reg  [LINE_W-1:0]     entering_line;
    reg  [PLACE_W-1:0]    entering_place;

    always @(posedge clk) begin
        if (made_ready) begin
            entering_column <= made_column;
            entering_line   <= made_line;
            entering_place  <= made_place;
        end
        if (advance) begin
            columns <= {columns[6*COLUMN_W-1:0], entering_column};
            lines   <= {lines[6*LINE_W-1:0], entering_line};
            places  <= {places[6*PLACE_W-1:0], entering_place};
        end
    end

    // ---- the square that a visit in `ask` is at ---------------------------------------------------------------------

    reg  [SQUARE_X_W-1:0] visit_column;
    reg  [SQUARE_Y_W-1:0] visit_line;
    wire                  column_ends = visit_column == LAST_X[2 +: SQUARE_X_W];
    wire                  line_ends   = visit_line == LAST_Y[2 +: SQUARE_Y_W];

    always @(posedge clk) begin
        if (advance && visits[0]) begin
            visit_column <= column_ends ? {SQUARE_X_W{1'b0}} : visit_column + 1'b1;
            if (column_ends) visit_line <= line_ends ? {SQUARE_Y_W{1'b0}} : visit_line + 1'b1;
        end
        if (rst) begin
            visit_column <= {SQUARE_X_W{1'b0}};
            visit_line   <= {SQUARE_Y_W{1'b0}};
        end
    end

    // ---- which of the five slots ahead is at a cell that the slot in `ask` reads, and which at its own ---------------

    // A cell is that of a bank and a square. A slot meets one ahead in whose bank it reads the same square: the own one, or the next
    // one at which its cell lies. Banks that it does not need may meet anything. A visit needs its own square of all banks.
    wire [SQUARE_X_W-1:0] column_own  = visits[0] ? visit_column : columns[2 +: SQUARE_X_W];
    wire [SQUARE_Y_W-1:0] line_own    = visits[0] ? visit_line : lines[2 +: SQUARE_Y_W];
    wire [SQUARE_X_W-1:0] column_next = columns[1] ? column_own + 1'b1 : column_own - 1'b1;
    wire [SQUARE_Y_W-1:0] line_next   = lines[1] ? line_own + 1'b1 : line_own - 1'b1;

    // An event ahead supports a token if it is not too old. In five slots time goes on by less than two segments: then the two high
    // bits of a difference tell that it is negative.
    wire [STAMP_W-1:0] oldest = now[STAMP_W-1:0] - window;  // time of an event that just supports the one in `ask`

    reg  [4:0] at_column, at_line, at_place, in_time;  // of the slot in `read` with the five ahead of it, the next in bit 0
    wire [4:0] meets_read = at_column & at_line & in_time;
    wire [4:0] same_read  = at_column & at_line & at_place;
    reg  [3:0] meets_found;
    reg  [2:0] meets_held;
    reg  [1:0] meets_taken;
    reg        meets_then;
    reg  [3:0] same_found;
    reg  [2:0] same_held;
    reg  [1:0] same_taken;
    reg        same_then;

    function crosses;  // from the event's column or line of banks to that of another one: to the next square
        input [1:0] own, other;
        crosses = (own == 2'd0 && other == 2'd3) || (own == 2'd3 && other == 2'd0);
    endfunction

    always @(posedge clk) begin : meets
        integer k;
        reg [STAMP_W-1:0] left;  // steps until the event ahead no longer supports
        if (advance) begin
            for (k = 1; k < 6; k = k + 1) begin
                left           = now[k*STAMP_W +: STAMP_W] - oldest;
                in_time[k-1]   <= visits[0] || (left >> STAMP_W - 2) != (KEEP >> STAMP_W - 2);
                at_column[k-1] <= access[k] && columns[k*COLUMN_W+2 +: SQUARE_X_W]
                               == (!visits[0] && crosses(columns[1:0], columns[k*COLUMN_W +: 2]) ? column_next : column_own);
                at_line[k-1]   <= lines[k*LINE_W+2 +: SQUARE_Y_W]
                               == (!visits[0] && crosses(lines[1:0], lines[k*LINE_W +: 2]) ? line_next : line_own);
                at_place[k-1]  <= columns[k*COLUMN_W +: 2] == columns[1:0] && lines[k*LINE_W +: 2] == lines[1:0];
            end
            meets_found <= meets_read[3:0];
            meets_held  <= meets_found[2:0];
            meets_taken <= meets_held[1:0];
            meets_then  <= meets_taken[0];
            same_found  <= same_read[3:0];
            same_held   <= same_found[2:0];
            same_taken  <= same_held[1:0];
            same_then   <= same_taken[0];
        end
    end

    // ---- the event's own cell: whether it stays ----------------------------------------------------------------------

    reg                  young;     // in `age`: its place had a stored event less than `silence` ago
    wire                 stays      = access[6] && !young;
    wire [STAMP_W-1:0]   age_now    = now[6*STAMP_W +: STAMP_W];
    wire [PLACE_W-1:0]   age_place  = places[6*PLACE_W +: PLACE_W];
    wire [STAMP_W-1:0]   then_now   = now[5*STAMP_W +: STAMP_W];
    wire [PLACE_W-1:0]   then_place = places[5*PLACE_W +: PLACE_W];
    wire [1:0]           written    = age_now[STAMP_W-1 -: 2] + {1'b0, visits[6]};  // the high bits; a visit's stamp is of age KEEP
    wire [WORD_W:0]      stored     = {{(WORD_W + 1 - STAMP_W - PLACE_W) {1'b0}}, age_place, written, age_now[STAMP_W-3:0]};
    wire [WORD_W-1:0]    write_word = stored[WORD_W-1:0];

    // What slots ahead have stored in the slot's own cell since it read, the newest.
    reg                  new_found, new_held, new_taken;
    reg  [WORD_W-1:0]    word_found, word_held, word_taken;

    wire [16*WORD_W-1:0] taken;  // of all banks
    wire [4*WORD_W-1:0]  taken_own;  // of those in the columns of the own bank
    wire [WORD_W-1:0]    own_word;
    reg  [WORD_W-1:0]    own_then;
    wire [WORD_W:0]      own        = {1'b0, own_then};
    wire [PLACE_W-1:0]   own_place  = own[STAMP_W +: PLACE_W];
    wire [STAMP_W-1:0]   own_age    = then_now - own_then[STAMP_W-1:0];
    wire [STAMP_W-1:0]   apart      = then_now - age_now;  // of the slot in `then` from the one in `age`
    wire                 follows    = same_then && stays;
    reg                  elsewhere;  // in `age`: the last event of its cell was of another pixel

    always @(posedge clk)
        if (advance) begin
            new_found  <= same_read[4] && stays;
            word_found <= write_word;
            new_held   <= new_found || (same_found[3] && stays);
            word_held  <= (same_found[3] && stays) ? write_word : word_found;
            new_taken  <= new_held || (same_held[2] && stays);
            word_taken <= (same_held[2] && stays) ? write_word : word_held;
            own_then   <= (same_taken[1] && stays) ? write_word : new_taken ? word_taken : own_word;
            young      <= follows ? age_place == then_place && apart < silence
                                  : own_place == then_place && own_age < silence;
            elsewhere  <= follows ? age_place != then_place : own_place != then_place;
        end

    genvar t;
    generate
        for (t = 0; t < 4; t = t + 1) begin : g_taken
            mux4 #(
                .W(WORD_W)
            ) u_column (
                .select(columns[4*COLUMN_W +: 2]),
                .words (taken[4*t*WORD_W +: 4*WORD_W]),
                .y     (taken_own[t*WORD_W +: WORD_W])
            );
        end
    endgenerate

    mux4 #(
        .W(WORD_W)
    ) u_line (
        .select(lines[4*LINE_W +: 2]),
        .words (taken_own),
        .y     (own_word)
    );

    // ---- banks -------------------------------------------------------------------------------------------------------

    wire [COLUMN_W-1:0] taken_column = columns[4*COLUMN_W +: COLUMN_W];
    wire [LINE_W-1:0]   taken_line   = lines[4*LINE_W +: LINE_W];
    wire [1:0]  then_column  = columns[5*COLUMN_W +: 2];
    wire [1:0]  then_line    = lines[5*LINE_W +: 2];
    reg         then_left, then_right, then_above, then_below;  // a cell beside it is on the sensor

    always @(posedge clk)
        if (advance) begin
            then_left  <= taken_column != {COLUMN_W{1'b0}};
            then_right <= taken_column != LAST_X[COLUMN_W-1:0];
            then_above <= taken_line != {LINE_W{1'b0}};
            then_below <= taken_line != LAST_Y[LINE_W-1:0];
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

    // Banks in which a slot ahead has written since the slot read, by the slot's stage. A word that is younger than one within
    // `window` is within it, too: so it need not be known, nor which of several is the newest.
    wire [15:0] stores = age_own & {16{stays}};
    reg  [15:0] newer_found, newer_held, newer_taken, newer_then, newer_age;

    always @(posedge clk)
        if (advance) begin
            newer_found <= stores & {16{meets_read[4]}};
            newer_held  <= newer_found | (stores & {16{meets_found[3]}});
            newer_taken <= newer_held | (stores & {16{meets_held[2]}});
            newer_then  <= newer_taken | (stores & {16{meets_taken[1]}});
            newer_age   <= newer_then | (stores & {16{meets_then}});
        end

    // What a visit finds older than KEEP - 1 steps it empties. No token behind it has to know: it has found the same.
    reg  [15:0] recent;  // the word that was read, of the slot in `age`
    wire [15:0] young_age = recent | newer_age;
    wire [15:0] writes    = visits[6] ? ~young_age | {16{clearing}} : stores;

    // How long ago the slot in `age` was, for each stage; for the one in `found` where it was in `read`.
    wire [7*STAMP_W-1:0] since;
    reg  [STAMP_W-1:0]   since_found;

    genvar s;
    generate
        for (s = 0; s < 7; s = s + 1) begin : g_since
            assign since[s*STAMP_W +: STAMP_W] = now[s*STAMP_W +: STAMP_W] - age_now;
        end
    endgenerate

    always @(posedge clk) if (advance) since_found <= since[STAMP_W +: STAMP_W];

    reg  [STAMP_W-1:0] limit;  // complement of that of an age that is within, of the slot in `then`

    always @(posedge clk) if (advance) limit <= ~(visits[4] ? KEEP - 1'b1 : window);

    // The word that the neighbour in a bank lies in; where there is none on the sensor, any.
    wire [ROW_W-1:0] right = {{(ROW_W - 1) {1'b0}}, !visits[0] && columns[1:0] == 2'd3};
    wire [ROW_W-1:0] left  = {ROW_W{!visits[0] && columns[1:0] == 2'd0}};
    wire [ROW_W-1:0] below = {ROW_W{!visits[0] && lines[1:0] == 2'd3}} & STRIDE[ROW_W-1:0];
    wire [ROW_W-1:0] above = {ROW_W{!visits[0] && lines[1:0] == 2'd0}} & ({ROW_W{1'b0}} - STRIDE[ROW_W-1:0]);

    genvar b, l;
    generate
        for (l = 0; l < 4; l = l + 1) begin : g_line
            wire [ROW_W-1:0] ask_row = row[ROW_W-1:0] + (l == 0 ? below : l == 3 ? above : {ROW_W{1'b0}});
            reg  [ROW_W-1:0] read_first, read_inner, read_last;  // of the banks of column 0, of columns 1 and 2, of column 3

            always @(posedge clk)
                if (advance) begin
                    read_first <= ask_row + right;
                    read_inner <= ask_row;
                    read_last  <= ask_row + left;
                end
        end
        for (b = 0; b < 16; b = b + 1) begin : g_bank
            wire [ROW_W-1:0]  read_row = (b % 4 == 0) ? g_line[b/4].read_first : (b % 4 == 3) ? g_line[b/4].read_last : g_line[b/4].read_inner;
            wire [WORD_W-1:0] held;
            reg  [WORD_W-1:0] word;  // in `taken`
            reg  [STAMP_W-1:0] age;  // in `then`
            wire [STAMP_W:0]  beyond = {1'b1, limit} + {1'b0, age};  // by how much it is more, less 1: negative where it is within
            wire              unused = &{1'b0, beyond};

            block_memory #(
                .W    (WORD_W),
                .DEPTH(ROWS)
            ) u_memory (
                .clk          (clk),
                .write        (advance && writes[b]),
                .write_address(row[6*ROW_W +: ROW_W]),
                .write_data   (write_word),
                .read_enable  (advance),
                .read_address (read_row),
                .out_enable   (advance),
                .read_data    (held)
            );

            assign taken[b*WORD_W +: WORD_W] = word;

            always @(posedge clk)
                if (advance) begin
                    word      <= held;
                    age       <= now[4*STAMP_W +: STAMP_W] - word[STAMP_W-1:0];
                    recent[b] <= beyond[STAMP_W];
                end

            if (AGES != 0) begin : g_age
                // Of the newest that slots ahead have stored since the slot read, by the slot's stage.
                reg [STAMP_W-1:0] age_held, age_taken, age_then, age_newest;

                always @(posedge clk)
                    if (advance) begin
                        age_held   <= (stores[b] && meets_found[3]) ? since[2*STAMP_W +: STAMP_W] : since_found;
                        age_taken  <= (stores[b] && meets_held[2]) ? since[3*STAMP_W +: STAMP_W] : age_held;
                        age_then   <= (stores[b] && meets_taken[1]) ? since[4*STAMP_W +: STAMP_W] : age_taken;
                        age_newest <= (stores[b] && meets_then) ? since[5*STAMP_W +: STAMP_W] : newer_then[b] ? age_then : age;
                    end

                assign m_age[b*STAMP_W +: STAMP_W] = age_newest;
            end else begin : g_no_age
                assign m_age[b*STAMP_W +: STAMP_W] = {STAMP_W{1'b0}};
            end
        end
    endgenerate

    assign m_supports = young_age & (age_around | (age_own & {16{elsewhere}}));

    wire   unused   = &{1'b0, since, since_found, access[0], visits[5:1], pass, places, wide_column, column, line, product, stored, own, row, now, columns, lines};
    assign m_data   = pass[6*PASS_W +: DATA_W];
    assign m_inside = pass[6*PASS_W + DATA_W];
    assign m_stays  = stays;
    assign idle     = slots_idle && !made_valid;

endmodule

`default_nettype wire
