// SPDX-License-Identifier: Apache-2.0
// Finds straight lines: leaky integrate-and-fire cells on (angle, rho), whose spikes are events (docs/lines.md).
//
// An event hits one cell at every angle. Each cell counts its hits and loses one per period of 2^leak_log2 events. Where a cell
// reaches 8 hits, the event is a spike, with the index of the lowest such angle and of the cell along rho; all cells of the event
// are emptied then. Every other event leaves as a dropped one, so its ticks and its event number still count.
//
// The streams are those of a filter, so a tracker can follow: its x is m_angle, its y m_rho.
//
// Latency:    8 clocks from s_ to m_: place, shares, row, RAM, potential, forwarding, decision, output.
// Throughput: 1 token per clock.
// Stall:      while the output is full, the pipeline stalls.
// Reset:      becomes empty and clears the memory: 2^RHO_W + 6 clocks with idle low, and s_ready for most of them.
// RAM:        ANGLES memories of 2^RHO_W words of 12 bits.
// Combinational paths: none; s_ready comes from registers alone, and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module hough_lines #(
    parameter X_W    = 9,    // bits of an x address
    parameter Y_W    = 9,    // bits of a y address
    parameter TICK_W = 20,   // bits of the tick input
    parameter WIDTH  = 346,  // pixels of the sensor across
    parameter HEIGHT = 260,  // pixels of the sensor down
    parameter ANGLES = 16,   // angles in half a turn, 16 or 32
    parameter ANGLE_W = $clog2(ANGLES),  // derived: leave it alone
    // bits of an index along rho: cells of 1 px cover the diagonal; derived: leave it alone
    parameter RHO_W = ($clog2((WIDTH + 8) * (WIDTH + 8) + (HEIGHT + 8) * (HEIGHT + 8)) + 1) / 2
) (
    input  wire               clk,
    input  wire               rst,

    // register, which changes only in reset
    input  wire [3:0]         leak_log2,  // log2 of the events in a period, 2 to 9

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
    output wire               m_event,  // a spike
    output wire               m_skip,
    output wire [ANGLE_W-1:0] m_angle,  // of a spike
    output wire [RHO_W-1:0]   m_rho,    // of a spike
    output wire [X_W-1:0]     m_x,      // pixel of the event
    output wire [Y_W-1:0]     m_y,
    output wire               m_p,

    output wire               idle  // nothing inside, memory emptied after reset
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(WIDTH >= 1 && WIDTH <= 2048)) WIDTH_must_be_1_to_2048 ();
    parameter_check #(.OK(HEIGHT >= 1 && HEIGHT <= 2048)) HEIGHT_must_be_1_to_2048 ();
    parameter_check #(.OK(ANGLES == 16 || ANGLES == 32)) ANGLES_must_be_16_or_32 ();
    parameter_check #(.OK(ANGLE_W == $clog2(ANGLES))) ANGLE_W_must_be_left_at_its_default ();
    parameter_check #(.OK(RHO_W == ($clog2((WIDTH + 8) * (WIDTH + 8) + (HEIGHT + 8) * (HEIGHT + 8)) + 1) / 2))
        RHO_W_must_be_left_at_its_default ();

    `include "hough_table.vh"

    localparam HALF      = ANGLES / 2;          // angles in a quarter turn
    localparam SHARE_W   = RHO_W + 3;           // a share of rho in 1/8 px; sums are right modulo the range of rho
    localparam PRODUCT_W = SHARE_W + 6;
    localparam TOKEN_W   = TICK_W + X_W + Y_W + 3;

    localparam [31:0] ACROSS = WIDTH;
    localparam [31:0] DOWN   = HEIGHT;

    wire space;  // for one more token in the output: everything moves

    // ---- place: from the middle of the sensor, in half pixels --------------------------------------------------------

    wire [31:0] x = {{(32 - X_W) {1'b0}}, s_x};
    wire [31:0] y = {{(32 - Y_W) {1'b0}}, s_y};
    wire [31:0] from_middle_x = (x << 1) - (ACROSS - 32'd1);
    wire [31:0] from_middle_y = (y << 1) - (DOWN - 32'd1);

    reg                 clearing;  // after reset: every cell is emptied
    reg                 place_valid, place_event;
    reg [TOKEN_W-1:0]   place_token;
    reg [PRODUCT_W-1:0] place_x, place_y;

    assign s_ready = space && !clearing;

    always @(posedge clk) begin
        if (space) begin
            place_valid <= s_valid && !clearing;
            place_event <= s_valid && !clearing && s_event && x < ACROSS && y < DOWN;
            place_token <= {s_tick, s_event, s_skip, s_x, s_y, s_p};
            place_x     <= from_middle_x[PRODUCT_W-1:0];
            place_y     <= from_middle_y[PRODUCT_W-1:0];
        end
        if (rst) begin
            place_valid <= 1'b0;
            place_event <= 1'b0;
        end
    end

    // ---- shares of x and y in rho, for the angles of a quarter turn --------------------------------------------------

    reg  [RHO_W-1:0]            clear_row;  // while clearing, the share of x; that of y is 0, so every angle visits every row
    reg  [(HALF+1)*SHARE_W-1:0] shares_x, shares_y;
    wire [(HALF+1)*SHARE_W-1:0] next_x, next_y;

    genvar j;
    generate
        for (j = 0; j <= HALF; j = j + 1) begin : g_share
            localparam [8:0] COSINE = COSINES[9*(j*16/HALF) +: 9];
            wire [PRODUCT_W-1:0] product_x = $signed(place_x) * $signed({{(PRODUCT_W - 9) {1'b0}}, COSINE});
            wire [PRODUCT_W-1:0] product_y = $signed(place_y) * $signed({{(PRODUCT_W - 9) {1'b0}}, COSINE});
            assign next_x[j*SHARE_W +: SHARE_W] = clearing ? {clear_row, 3'd0} : product_x[PRODUCT_W-1:6];
            assign next_y[j*SHARE_W +: SHARE_W] = product_y[PRODUCT_W-1:6];
            wire unused = &{1'b0, product_x, product_y};
        end
    endgenerate

    always @(posedge clk) begin
        if (space) begin
            shares_x <= next_x;
            shares_y <= next_y;
            if (clearing) begin
                shares_y  <= {(HALF + 1) * SHARE_W{1'b0}};
                clear_row <= clear_row + 1'b1;
                clearing  <= !(&clear_row);
            end
        end
        if (rst) begin
            clear_row <= {RHO_W{1'b0}};
            clearing  <= 1'b1;
        end
    end

    // ---- rows, and the period of an event ----------------------------------------------------------------------------

    reg  [ANGLES*RHO_W-1:0] rows;
    wire [ANGLES*RHO_W-1:0] next_rows;

    genvar k;
    generate
        for (k = 0; k < ANGLES; k = k + 1) begin : g_row
            localparam OF_X = (k <= HALF) ? k : ANGLES - k;
            localparam OF_Y = (k <= HALF) ? HALF - k : k - HALF;
            wire [SHARE_W-1:0] share_x = shares_x[OF_X*SHARE_W +: SHARE_W];
            wire [SHARE_W-1:0] share_y = shares_y[OF_Y*SHARE_W +: SHARE_W];
            wire [SHARE_W-1:0] rho     = (k <= HALF) ? share_y + share_x : share_y - share_x;
            assign next_rows[k*RHO_W +: RHO_W] = {!rho[SHARE_W-1], rho[SHARE_W-2:3]};
            wire unused = &{1'b0, rho[2:0]};
        end
    endgenerate

    // A slot is a token, a cell to empty, or nothing; `event` says that cells are written.
    reg               share_valid, row_valid, found_valid, past_valid, hit_valid, fired_valid;
    reg               share_event, row_event, found_event, past_event, hit_event;
    reg               share_clears, row_clears, found_clears, past_clears, hit_clears;
    reg [TOKEN_W-1:0] share_token, row_token, found_token, past_token, hit_token, fired_token;
    reg [STAMP_W-1:0] period, row_period, found_period, past_period, hit_period;
    reg               last_period;    // of the slot that has left `hit`: the lowest bit of its period
    reg [8:0]         phase;          // events of the period
    wire              inhibits;

    wire [8:0]  period_end = ~(9'h1ff << leak_log2);  // phase of its last event
    wire        ends       = phase == period_end;

    always @(posedge clk) begin
        if (space) begin
            {share_valid, share_event, share_clears} <= {place_valid, place_event || clearing, clearing};
            {row_valid, row_event, row_clears}       <= {share_valid, share_event, share_clears};
            {found_valid, found_event, found_clears} <= {row_valid, row_event, row_clears};
            {past_valid, past_event, past_clears}    <= {found_valid, found_event, found_clears};
            {hit_valid, hit_event, hit_clears}       <= {past_valid, past_event, past_clears};
            fired_valid <= hit_valid;

            share_token <= place_token;
            row_token   <= share_token;
            found_token <= row_token;
            past_token  <= found_token;
            hit_token   <= past_token;
            fired_token <= hit_token;

            rows <= next_rows;
            if (share_event && !share_clears) begin
                phase  <= ends ? 9'd0 : phase + 9'd1;
                period <= period + {{(STAMP_W - 1) {1'b0}}, ends};
            end
            row_period    <= period;
            found_period  <= row_period;
            past_period   <= found_period;
            hit_period    <= past_period;
            last_period   <= hit_period[0];
        end
        if (rst) begin
            {share_valid, share_event, share_clears} <= 3'd0;
            {row_valid, row_event, row_clears}       <= 3'd0;
            {found_valid, found_event, found_clears} <= 3'd0;
            {past_valid, past_event, past_clears}    <= 3'd0;
            {hit_valid, hit_event, hit_clears}       <= 3'd0;
            fired_valid <= 1'b0;
            period      <= {STAMP_W{1'b0}};
            phase       <= 9'd0;
        end
    end

    // ---- cells -------------------------------------------------------------------------------------------------------

    wire [ANGLES-1:0]       fires;
    wire [ANGLES*RHO_W-1:0] hit_rows;
    assign                  inhibits = |fires || hit_clears;

    generate
        for (k = 0; k < ANGLES; k = k + 1) begin : g_angle
            hough_angle #(
                .RHO_W(RHO_W)
            ) u_cells (
                .clk          (clk),
                .advance      (space),
                .row          (rows[k*RHO_W +: RHO_W]),
                .found_period (found_period),
                .hit_period   (hit_period),
                .hit_event    (hit_event),
                .past_leaks   (past_period[0] != hit_period[0]),
                .found_leaks  (found_period[0] != hit_period[0]),
                .last_leaks   (found_period[0] != last_period),
                .inhibits     (inhibits),
                .fires        (fires[k]),
                .hit_row      (hit_rows[k*RHO_W +: RHO_W])
            );
        end
    endgenerate

    // ---- decision: the lowest angle that fires -----------------------------------------------------------------------

    reg [ANGLES-1:0]       fired;
    reg [ANGLES*RHO_W-1:0] fired_rows;

    always @(posedge clk)
        if (space) begin
            fired      <= fires & {ANGLES{hit_event && !hit_clears}};
            fired_rows <= hit_rows;
        end

    wire [ANGLES-1:0]  first = fired & ~(fired - 1'b1);  // the lowest bit of `fired`
    reg  [ANGLE_W-1:0] angle;
    reg  [RHO_W-1:0]   rho;

    always @* begin : lowest
        integer i;
        angle = {ANGLE_W{1'b0}};
        rho   = {RHO_W{1'b0}};
        for (i = 0; i < ANGLES; i = i + 1) begin
            angle = angle | (i[ANGLE_W-1:0] & {ANGLE_W{first[i]}});
            rho   = rho | (fired_rows[i*RHO_W +: RHO_W] & {RHO_W{first[i]}});
        end
    end

    wire              spikes = |fired;
    wire [TICK_W-1:0] fired_tick;
    wire              fired_event, fired_skip;
    wire [X_W+Y_W:0]  fired_rest;  // x, y, p
    assign {fired_tick, fired_event, fired_skip, fired_rest} = fired_token;

    skid_buffer #(
        .W(TOKEN_W + ANGLE_W + RHO_W)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(fired_valid),
        .s_ready(space),
        .s_data ({fired_tick, spikes, fired_skip || (fired_event && !spikes), angle, rho, fired_rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_angle, m_rho, m_x, m_y, m_p})
    );

    assign idle = !clearing && !place_valid && !share_valid && !row_valid && !found_valid && !past_valid && !hit_valid
               && !fired_valid && !m_valid && !share_clears && !row_clears && !found_clears && !past_clears && !hit_clears;

    wire unused = &{1'b0, from_middle_x, from_middle_y};

endmodule

`default_nettype wire
