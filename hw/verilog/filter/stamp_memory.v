// SPDX-License-Identifier: Apache-2.0
// Stores the time of each pixel's last event, and reads all 8 neighbours of a pixel at once: 16 banks of block RAM, by the low two bits
// of x and of y, so that the pixels of any 3 x 3 square lie in nine different ones.
//
// An event reads the banks of its neighbours and is written to its own in the same clock, so it sees every event before it
// and not itself. stamp_walk.v keeps stamps exact while they wrap: m_age is exact below KEEP = 2^STAMP_W - 2^(SEGMENT_W+1);
// KEEP or more means that the pixel had no event, or none of an age that matters.
// A visit reads a row of all banks and writes it back three clocks later. If an event needs the port in that clock, or has
// written to the row in between, the visit is repeated. So no cell is ever read and written in one clock, except in
// the bank of an event's own pixel, whose read data is not used.
//
// Latency:    6 clocks from s_ to m_: address, time, addresses of the banks, RAM, its output, ages.
// Throughput: 1 token per clock; for stalls by the walk, which are rare, see stamp_walk.v.
// Stall:      while advance is low the pipeline stalls; m_ outputs are held.
// Reset:      no token inside; then all cells are cleared, which takes as many clocks as a bank has cells, and 5 more.
//             Meanwhile idle and s_ready are low.
// RAM:        16 * ceil(WIDTH/4) * ceil(HEIGHT/4) * STAMP_W bits. One read and one write port per bank, contents not reset.
// Combinational paths: advance -> s_ready.
`default_nettype none
`include "evcot_defs.vh"

module stamp_memory #(
    parameter X_W       = 9,    // bits of an x address
    parameter Y_W       = 9,    // bits of a y address
    parameter WIDTH     = 346,  // pixels of the sensor across
    parameter HEIGHT    = 260,  // pixels of the sensor down
    parameter STAMP_W   = 20,   // bits of a stamp
    parameter SEGMENT_W = 18,   // log2 of the steps between two visits: see stamp_walk.v
    parameter STEP_W    = 20,   // bits of a token's steps
    parameter DATA_W    = 1     // bits that travel with a token
) (
    input  wire                  clk,
    input  wire                  rst,
    input  wire                  advance,

    // tokens: s_step steps have passed, then an event to look up and to remember, if s_access
    input  wire                  s_valid,
    output wire                  s_ready,
    input  wire [STEP_W-1:0]     s_step,
    input  wire                  s_access,
    input  wire [X_W-1:0]        s_x,
    input  wire [Y_W-1:0]        s_y,
    input  wire [DATA_W-1:0]     s_data,

    // bank 4 * (y % 4) + x % 4: the age of what it holds near the event, if it was looked up, in m_age[bank*STAMP_W +: STAMP_W]
    output wire                  m_valid,
    output wire [DATA_W-1:0]     m_data,
    output wire                  m_inside,  // the event lies on the sensor
    output wire [15:0]           m_near,    // banks that hold a neighbour on the sensor
    output wire [16*STAMP_W-1:0] m_age,

    output wire                  idle       // nothing inside, memory emptied after reset
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(WIDTH >= `EVCOT_WIDTH_MIN && WIDTH <= `EVCOT_WIDTH_MAX)) WIDTH_must_be_1_to_65536 ();
    parameter_check #(.OK(HEIGHT >= `EVCOT_HEIGHT_MIN && HEIGHT <= `EVCOT_HEIGHT_MAX)) HEIGHT_must_be_1_to_65536 ();
    parameter_check #(.OK(WIDTH <= 16777216 / HEIGHT)) WIDTH_times_HEIGHT_must_be_at_most_2_to_the_24 ();
    parameter_check #(.OK(STAMP_W >= `EVCOT_STAMP_W_MIN && STAMP_W <= `EVCOT_STAMP_W_MAX)) STAMP_W_must_be_4_to_32 ();

    localparam COLS   = (WIDTH + 3) / 4;  // squares of 4 x 4 pixels: a cell of each bank
    localparam CELLS  = COLS * ((HEIGHT + 3) / 4);
    localparam ADDR_W = (CELLS > 1) ? $clog2(CELLS) : 1;

    localparam [31:0] ACROSS = WIDTH;
    localparam [31:0] DOWN   = HEIGHT;
    localparam [31:0] STRIDE = COLS;

    localparam [STAMP_W-1:0] KEEP = {{(STAMP_W - SEGMENT_W - 1) {1'b1}}, {(SEGMENT_W + 1) {1'b0}}};

    // ---- the event's square, and its place there ---------------------------------------------------------------------

    wire [31:0] x      = {{(32 - X_W) {1'b0}}, s_x};
    wire [31:0] y      = {{(32 - Y_W) {1'b0}}, s_y};
    wire [31:0] square = (y >> 2) * STRIDE + (x >> 2);
    wire        inside_sensor = x < ACROSS && y < DOWN;
    wire        unused = &{1'b0, square};

    reg [DATA_W-1:0] data, ask_data;
    reg [ADDR_W-1:0] base, ask_base;
    reg [1:0]        col, line, ask_col, ask_line;  // within the square
    reg [3:0]        near_cols, near_lines, ask_near_cols, ask_near_lines;
    reg              on_sensor, ask_on_sensor;

    // The columns (or lines) of banks of a place and of the places next to it, as far as those are on the sensor.
    function [3:0] around;
        input [1:0] place;
        input       lower, higher;  // there are
        begin
            around = 4'd1 << place;
            if (lower) around = around | (4'd1 << (place - 2'd1));
            if (higher) around = around | (4'd1 << (place + 2'd1));
        end
    endfunction

    always @(posedge clk)
        if (s_ready) begin
            data       <= s_data;
            base       <= square[ADDR_W-1:0];
            col        <= x[1:0];
            line       <= y[1:0];
            near_cols  <= around(x[1:0], x != 32'd0, x + 32'd1 < ACROSS);
            near_lines <= around(y[1:0], y != 32'd0, y + 32'd1 < DOWN);
            on_sensor  <= inside_sensor;
        end

    // ---- time, and what enters: a token, or a visit of the walk ------------------------------------------------------

    wire enters, access, visits, visited, clearing, waits;
    reg  missed, tidies;  // of what is in age, a visit: it is to be done again; it writes
    wire [ADDR_W-1:0]  row;
    wire [STAMP_W-1:0] now;

    reg                 ask_valid, ask_access, ask_visits;
    reg                 read_valid, read_access, read_visits, read_on_sensor;
    reg                 found_valid, found_access, found_visits, found_on_sensor;
    reg                 then_valid, then_visits, then_on_sensor;
    reg                 age_valid, age_visits, age_on_sensor;
    reg [DATA_W-1:0]    read_data, found_data, then_data, age_data;
    reg [ADDR_W-1:0]    read_base, found_base, then_base, age_base;
    reg [STAMP_W-1:0]   ask_now, read_now, found_now, then_now, age_now;
    reg [15:0]          read_near, found_near, then_near, age_near;
    reg [15:0]          read_own;

    stamp_walk #(
        .W        (STAMP_W),
        .SEGMENT_W(SEGMENT_W),
        .STEP_W   (STEP_W),
        .ROWS     (CELLS),
        .ROW_W    (ADDR_W)
    ) u_walk (
        .clk        (clk),
        .rst        (rst),
        .advance    (advance),
        .s_valid    (s_valid),
        .s_ready    (s_ready),
        .s_step     (s_step),
        .s_access   (s_access && inside_sensor),
        .enters     (enters),
        .access     (access),
        .visits     (visits),
        .row        (row),
        .now        (now),
        .visited    (visited),
        .missed     (missed),
        .visited_row(age_base),
        .clearing   (clearing),
        .waits      (waits)
    );

    assign visited = age_visits;

    wire would_miss = ask_access || (read_access && read_base == then_base) || (found_access && found_base == then_base);

    always @(posedge clk) begin
        if (advance) begin
            ask_valid       <= enters;
            ask_access      <= access;
            ask_visits      <= visits && !missed;
            ask_data        <= data;
            ask_base        <= visits ? row : base;
            ask_col         <= col;
            ask_line        <= line;
            ask_near_cols   <= near_cols;
            ask_near_lines  <= near_lines;
            ask_now         <= now;
            ask_on_sensor   <= on_sensor;

            read_valid      <= ask_valid;
            read_access     <= ask_access;
            read_visits     <= ask_visits && !missed;
            read_data       <= ask_data;
            read_base       <= ask_base;
            read_now        <= ask_now;
            read_on_sensor  <= ask_on_sensor;

            found_valid     <= read_valid;
            found_access    <= read_access;
            found_visits    <= read_visits && !missed;
            found_data      <= read_data;
            found_base      <= read_base;
            found_now       <= read_now;
            found_near      <= read_near;
            found_on_sensor <= read_on_sensor;

            then_valid      <= found_valid;
            then_visits     <= found_visits && !missed;
            then_data       <= found_data;
            then_base       <= found_base;
            then_now        <= found_now;
            then_near       <= found_near;
            then_on_sensor  <= found_on_sensor;

            age_valid       <= then_valid;
            age_visits      <= then_visits && !missed;
            age_data        <= then_data;
            age_base        <= then_base;
            age_now         <= then_now;
            age_near        <= then_near;
            age_on_sensor   <= then_on_sensor;

            missed          <= then_visits && !missed && would_miss;
            tidies          <= then_visits && !missed && !would_miss;
        end
        if (rst) begin
            ask_valid    <= 1'b0;
            ask_access   <= 1'b0;
            ask_visits   <= 1'b0;
            read_valid   <= 1'b0;
            read_access  <= 1'b0;
            read_visits  <= 1'b0;
            found_valid  <= 1'b0;
            found_access <= 1'b0;
            found_visits <= 1'b0;
            then_valid   <= 1'b0;
            then_visits  <= 1'b0;
            age_valid    <= 1'b0;
            age_visits   <= 1'b0;
            missed       <= 1'b0;
            tidies       <= 1'b0;
        end
    end

    // ---- banks -------------------------------------------------------------------------------------------------------

    // One write a clock: a visit's at the end of its way, to all banks whose stamp is too old; else an event's, to its own.
    wire [ADDR_W-1:0]  write_base  = tidies ? age_base : read_base;
    wire [STAMP_W-1:0] write_stamp = tidies ? age_now - KEEP : read_now;

    genvar b;
    generate
        for (b = 0; b < 16; b = b + 1) begin : g_bank
            localparam [31:0] BANK = b;
            localparam [1:0]  COL  = BANK[1:0];
            localparam [1:0]  LINE = BANK[3:2];

            // The square that the neighbour in this bank lies in; where there is none on the sensor, any.
            wire right = !ask_visits && COL == 2'd0 && ask_col == 2'd3;
            wire left  = !ask_visits && COL == 2'd3 && ask_col == 2'd0;
            wire below = !ask_visits && LINE == 2'd0 && ask_line == 2'd3;
            wire above = !ask_visits && LINE == 2'd3 && ask_line == 2'd0;

            wire [ADDR_W-1:0] aside = right ? {{(ADDR_W - 1) {1'b0}}, 1'b1} : {ADDR_W{left}};
            wire [ADDR_W-1:0] astride = below ? STRIDE[ADDR_W-1:0]
                                      : above ? {ADDR_W{1'b0}} - STRIDE[ADDR_W-1:0] : {ADDR_W{1'b0}};
            wire              own     = ask_col == COL && ask_line == LINE;

            (* ram_style = "block", no_rw_check *)
            reg [STAMP_W-1:0] stamps [0:CELLS-1];
            reg [STAMP_W-1:0] found, then, age;
            reg [ADDR_W-1:0]  at;

            wire too_old = &age[STAMP_W-1:SEGMENT_W+1];
            wire writes  = tidies ? too_old || clearing : read_own[b];

            always @(posedge clk)
                if (advance) begin
                    at           <= ask_base + aside + astride;
                    read_own[b]  <= ask_access && own;
                    read_near[b] <= ask_on_sensor && ask_near_cols[COL] && ask_near_lines[LINE] && !own;

                    if (writes) stamps[write_base] <= write_stamp;
                    found <= stamps[at];

                    then <= found;  // a RAM gives late in its clock
                    age  <= then_now - then;
                end

            assign m_age[b*STAMP_W +: STAMP_W] = age;
        end
    endgenerate

    assign m_valid  = age_valid;
    assign m_data   = age_data;
    assign m_inside = age_on_sensor;
    assign m_near   = age_near;
    assign idle     = !clearing && !waits && !ask_valid && !read_valid && !found_valid && !then_valid && !age_valid;

endmodule

`default_nettype wire
