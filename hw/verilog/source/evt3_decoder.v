// SPDX-License-Identifier: Apache-2.0
// Decodes Prophesee's EVT 3.0, 16-bit words that each set a part of the next event, from AXI4-Stream to events, as
// sw/evcot/recordings/formats/evt3.py does.
//
// Bits 15..12 are the type of a word: 0: row; 2: one event, polarity 11, x 10..0; 3: polarity and base x of the next vector;
// 4, 5: a vector of 12 or 8 pixels, one event per set bit, to the right of the base, which advances by as many; 6: bits 11..0 of
// the time; 8: a time mark, bits 23..12 (time_mark.v extends it to T_W bits), which sets those below to 0 if it is a new one.
// Triggers and vendors' words (7, 10, 14, 15) are skipped; other types are reserved: skipped and counted. Type 1 invalidates
// the row: events are dropped until the next one.
// https://docs.prophesee.ai/stable/data/encoding_formats/evt3.html
//
// Latency:    6 clocks from s_axis_ to m_.
// Throughput: 1 word per clock, and 1 more for each further event of a vector.
// Stall:      an event is held until accepted.
// Reset:      becomes empty, time unknown, counters 0.
// Combinational paths: none; m_ are registers, s_axis_tready comes from registers.
`default_nettype none

module evt3_decoder #(
    parameter DATA_W  = 32,    // bits of a beat: 16, 32 or 64
    parameter T_W     = 48,    // bits of a time, microseconds
    parameter X_W     = 11,    // bits of an x address
    parameter Y_W     = 11,    // bits of a y address
    parameter WIDTH   = 1280,  // pixels of the sensor
    parameter HEIGHT  = 720,
    parameter COUNT_W = 32     // bits of a counter
) (
    input  wire                clk,
    input  wire                rst,

    input  wire                swap_bytes,  // the high byte of a word comes first

    input  wire                s_axis_tvalid,
    output wire                s_axis_tready,
    input  wire [DATA_W-1:0]   s_axis_tdata,
    input  wire [DATA_W/8-1:0] s_axis_tkeep,
    input  wire                s_axis_tlast,

    output wire                m_valid,
    input  wire                m_ready,
    output wire [T_W-1:0]      m_t,
    output wire [X_W-1:0]      m_x,
    output wire [Y_W-1:0]      m_y,
    output wire                m_p,

    output wire [COUNT_W-1:0]  n_events,    // output
    output wire [COUNT_W-1:0]  n_untimed,   // events before any time mark or address
    output wire [COUNT_W-1:0]  n_outside,   // events beyond the sensor
    output reg  [COUNT_W-1:0]  n_reserved,  // words of reserved types
    output wire [COUNT_W-1:0]  n_cut,       // words of which a part is missing
    output wire                idle         // nothing inside
);

    parameter_check #(.OK(T_W >= 25 && T_W <= 64)) T_W_must_be_25_to_64 ();

    localparam LOW_W  = 12;
    localparam MARK_W = 12;

    localparam [3:0] ROW       = 4'd0;
    localparam [3:0] OTHER_ROW = 4'd1;
    localparam [3:0] COLUMN    = 4'd2;
    localparam [3:0] BASE      = 4'd3;
    localparam [3:0] VECTOR_12 = 4'd4;
    localparam [3:0] VECTOR_8  = 4'd5;
    localparam [3:0] TIME_LOW  = 4'd6;
    localparam [3:0] TIME_HIGH = 4'd8;
    // Also defined: 7, 10, 14, 15.
    localparam [15:0] DEFINED  = 16'b1100_0101_1111_1101;

    wire        word_valid, word_ready, words_idle;
    wire [15:0] word;

    axis_words #(
        .DATA_W (DATA_W),
        .WORD_W (16),
        .COUNT_W(COUNT_W)
    ) u_words (
        .clk          (clk),
        .rst          (rst),
        .swap_bytes   (swap_bytes),
        .s_axis_tvalid(s_axis_tvalid),
        .s_axis_tready(s_axis_tready),
        .s_axis_tdata (s_axis_tdata),
        .s_axis_tkeep (s_axis_tkeep),
        .s_axis_tlast (s_axis_tlast),
        .m_valid      (word_valid),
        .m_ready      (word_ready),
        .m_word       (word),
        .n_cut        (n_cut),
        .idle         (words_idle)
    );

    wire [3:0]  kind      = word[15:12];
    wire        is_column = kind == COLUMN;
    wire        is_vector = kind == VECTOR_12 || kind == VECTOR_8;
    wire        is_event  = is_column || is_vector;
    wire        taken     = word_valid && word_ready;

    // What words have set so far.
    wire [T_W-LOW_W-1:0] high;
    reg  [LOW_W-1:0]     low;
    reg  [10:0]          row;
    reg  [11:0]          base;
    reg                  polarity;
    reg                  row_known, base_known;
    wire                 timed, new_mark, events_ready, events_idle;

    time_mark #(
        .MARK_W(MARK_W),
        .HIGH_W(T_W - LOW_W)
    ) u_mark (
        .clk    (clk),
        .rst    (rst),
        .set    (taken && kind == TIME_HIGH),
        .mark   (word[MARK_W-1:0]),
        .differs(new_mark),
        .high   (high),
        .known  (timed)
    );

    event_vector #(
        .L      (12),
        .T_W    (T_W),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .WIDTH  (WIDTH),
        .HEIGHT (HEIGHT),
        .COUNT_W(COUNT_W)
    ) u_events (
        .clk      (clk),
        .rst      (rst),
        .s_valid  (word_valid && is_event),
        .s_ready  (events_ready),
        .s_t      ({high, low}),
        .s_x      (is_column ? {1'b0, word[10:0]} : base),
        .s_y      (row),
        .s_p      (is_column ? word[11] : polarity),
        .s_mask   (is_column ? 12'd1 : {kind == VECTOR_12 ? word[11:8] : 4'd0, word[7:0]}),
        .s_known  (timed && row_known && (is_column || base_known)),
        .m_valid  (m_valid),
        .m_ready  (m_ready),
        .m_t      (m_t),
        .m_x      (m_x),
        .m_y      (m_y),
        .m_p      (m_p),
        .n_events (n_events),
        .n_untimed(n_untimed),
        .n_outside(n_outside),
        .idle     (events_idle)
    );

    assign word_ready = events_ready || !is_event;
    assign idle = words_idle && events_idle;

    always @(posedge clk) begin
        if (taken) begin
            // From 2048 on it stays, beyond every sensor, however many vectors follow.
            if (is_vector && !base[11]) base <= base + (kind == VECTOR_12 ? 12'd12 : 12'd8);
            case (kind)
                ROW: begin
                    row       <= word[10:0];
                    row_known <= 1'b1;
                end
                OTHER_ROW: row_known <= 1'b0;
                BASE: begin
                    base       <= {1'b0, word[10:0]};
                    polarity   <= word[11];
                    base_known <= 1'b1;
                end
                TIME_LOW:  low <= word[LOW_W-1:0];
                TIME_HIGH: if (new_mark) low <= {LOW_W{1'b0}};
                default: ;
            endcase
        end
        if (taken && !DEFINED[kind]) n_reserved <= n_reserved + 1'b1;
        if (rst) begin
            low        <= {LOW_W{1'b0}};
            row_known  <= 1'b0;
            base_known <= 1'b0;
            n_reserved <= {COUNT_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
