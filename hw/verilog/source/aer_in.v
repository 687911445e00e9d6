// SPDX-License-Identifier: Apache-2.0
// Address events from a chip: 4-phase request and acknowledge, asynchronous to the clock, each stamped with its arrival.
//
// The sender drives a word, asserts the request, waits for the acknowledge, de-asserts the request, and waits until the acknowledge is
// de-asserted. The request passes a synchronizer; the word must be stable from the request to the acknowledge (bundled data), and is
// sampled when the request leaves the synchronizer, STAGES clocks later. The acknowledge is asserted when there is room for the event
// in the output, so that the sender waits and nothing is lost.
//
// Plain words: {y, x, p}. Word-serial: with aer_row, a row address y in the low bits, for all columns until the next one;
// without, a column {x, p} in the low bits. Columns before any row, and events beyond the sensor, are dropped and counted.
//
// Latency:    SYNC + 2 to SYNC + 3 clocks from the request to m_.
// Throughput: with a sender that answers at once, an event in 2 * SYNC + 3 clocks, occasionally one more.
// Stall:      an event is held until accepted; the next one is stamped when it arrives, and acknowledged when there is room.
// Reset:      no acknowledge, no row is known; a request that is already asserted counts as a new one.
// Flush:      an event inside is dropped and counters are cleared, but the handshake continues: a word that has not been acknowledged
//             is sampled after the flush, one that has been is not sampled again, and the row is kept.
// Combinational paths: active_low -> aer_ack, idle.
`default_nettype none

module aer_in #(
    parameter T_W     = 48,   // bits of a time
    parameter X_W     = 9,    // bits of an x address
    parameter Y_W     = 9,    // bits of a y address
    parameter WIDTH   = 346,  // pixels of the sensor
    parameter HEIGHT  = 260,
    parameter SYNC    = 2,    // stages of the synchronizer, 2..4
    parameter COUNT_W = 32,   // bits of a counter
    parameter AER_W   = X_W + Y_W + 1  // derived: leave it alone
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               flush,

    // settings: change them under reset or flush alone
    input  wire               active_low,   // of aer_req and aer_ack
    input  wire               word_serial,

    input  wire [T_W-1:0]     t_us,         // now

    // the chip
    input  wire               aer_req,
    output wire               aer_ack,
    input  wire               aer_row,
    input  wire [AER_W-1:0]   aer_data,

    // events out
    output reg                m_valid,
    input  wire               m_ready,
    output reg  [T_W-1:0]     m_t,
    output reg  [X_W-1:0]     m_x,
    output reg  [Y_W-1:0]     m_y,
    output reg                m_p,

    output reg  [COUNT_W-1:0] n_events,   // taken from m_
    output reg  [COUNT_W-1:0] n_outside,  // beyond the sensor
    output reg  [COUNT_W-1:0] n_rowless,  // columns before any row
    output wire               idle        // nothing inside
);

    parameter_check #(.OK(T_W >= 1)) T_W_must_be_at_least_1 ();
    parameter_check #(.OK(X_W >= 1 && X_W <= 16)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= 1 && Y_W <= 16)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(WIDTH >= 1 && WIDTH <= (1 << X_W))) WIDTH_must_be_1_to_2_to_the_X_W ();
    parameter_check #(.OK(HEIGHT >= 1 && HEIGHT <= (1 << Y_W))) HEIGHT_must_be_1_to_2_to_the_Y_W ();
    parameter_check #(.OK(COUNT_W >= 8 && COUNT_W <= 64)) COUNT_W_must_be_8_to_64 ();
    parameter_check #(.OK(AER_W == X_W + Y_W + 1)) AER_W_must_be_left_at_its_default ();

    localparam [31:0] COLUMNS = WIDTH;
    localparam [31:0] ROWS = HEIGHT;

    localparam [1:0] LISTEN = 2'd0;  // waiting for a request
    localparam [1:0] DECIDE = 2'd1;  // the word has been read; waiting for room if it is an event
    localparam [1:0] RETURN = 2'd2;  // acknowledged; waiting for the request to go

    reg [1:0]      state;
    reg [SYNC-1:0] synced;  // the highest: the synchronizer has forgotten the reset
    wire           level;
    wire           request = synced[SYNC-1] && (level ^ active_low);

    synchronizer #(
        .STAGES(SYNC),
        .RESET (0)
    ) u_request (
        .clk(clk),
        .rst(rst),
        .d  (aer_req),
        .q  (level)
    );

    always @(posedge clk) synced <= rst ? {SYNC{1'b0}} : {synced[SYNC-2:0], 1'b1};

    reg             acknowledge;
    assign aer_ack = acknowledge ^ active_low;

    // The word, as it was when its request arrived.
    reg             is_row;
    reg [AER_W-1:0] word;
    reg [T_W-1:0]   arrival;

    // The last row of a word-serial sender.
    reg             row_known;
    reg [Y_W-1:0]   row;

    wire            sets_row = word_serial && is_row;
    wire            rowless = word_serial && !is_row && !row_known;
    wire [X_W-1:0]  x = word[X_W:1];
    wire [Y_W-1:0]  y = word_serial ? row : word[AER_W-1:X_W+1];
    wire            on_sensor = {{(32 - X_W) {1'b0}}, x} < COLUMNS && {{(32 - Y_W) {1'b0}}, y} < ROWS;
    wire            is_event = !sets_row && !rowless && on_sensor;
    wire            room = m_ready || !m_valid;
    wire            decided = state == DECIDE && (!is_event || room) && !flush;

    reg             was_rowless, was_outside;  // the word that was decided in the clock before

    assign idle = state == LISTEN && !request && !m_valid;

    always @(posedge clk) begin
        case (state)
            LISTEN:
            if (request && !flush) begin
                is_row  <= aer_row;
                word    <= aer_data;
                arrival <= t_us;
                state   <= DECIDE;
            end
            DECIDE:
            if (decided) begin
                acknowledge <= 1'b1;
                state       <= RETURN;
            end
            RETURN:
            if (!request) begin
                acknowledge <= 1'b0;
                state       <= LISTEN;
            end
            default: state <= LISTEN;
        endcase

        if (m_ready) m_valid <= 1'b0;
        if (m_valid && m_ready) n_events <= n_events + 1'b1;
        if (state == DECIDE && room) begin  // an event or not
            m_t <= arrival;
            m_x <= x;
            m_y <= y;
            m_p <= word[0];
        end
        if (decided && is_event) m_valid <= 1'b1;
        if (decided && sets_row) begin
            row       <= word[Y_W-1:0];
            row_known <= 1'b1;
        end
        was_rowless <= decided && rowless;
        was_outside <= decided && !sets_row && !rowless && !on_sensor;
        if (was_rowless) n_rowless <= n_rowless + 1'b1;
        if (was_outside) n_outside <= n_outside + 1'b1;
        if (flush && state == DECIDE) state <= LISTEN;
        if (rst || flush) begin
            m_valid     <= 1'b0;
            was_rowless <= 1'b0;
            was_outside <= 1'b0;
            n_events    <= {COUNT_W{1'b0}};
            n_outside   <= {COUNT_W{1'b0}};
            n_rowless   <= {COUNT_W{1'b0}};
        end
        if (rst) begin
            state       <= LISTEN;
            acknowledge <= 1'b0;
            row_known   <= 1'b0;
        end
    end

endmodule

`default_nettype wire
