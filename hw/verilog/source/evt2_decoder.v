// SPDX-License-Identifier: Apache-2.0
// Decodes Prophesee's EVT 2.0, 32-bit words of one event each, from AXI4-Stream to events, as sw/evcot/recordings/formats/evt2.py does.
//
// Bits 31..28 are the type of a word: 0, 1: an event, darker or brighter, its time's low bits 27..22, x 21..11, y 10..0;
// 8: a time mark, bits 33..6 of the time (time_mark.v extends it to T_W bits). Triggers and vendors' words (10, 14, 15) are
// skipped; all other types are reserved: skipped and counted.
// https://docs.prophesee.ai/stable/data/encoding_formats/evt2.html
//
// Latency:    6 clocks from s_axis_ to m_.
// Throughput: 1 word per clock, so 1 event per clock between marks.
// Stall:      an event is held until accepted.
// Reset:      becomes empty, time unknown, counters 0.
// Combinational paths: none; m_ are registers, s_axis_tready comes from registers.
`default_nettype none

module evt2_decoder #(
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
    output wire [COUNT_W-1:0]  n_untimed,   // events before any time mark
    output wire [COUNT_W-1:0]  n_outside,   // events beyond the sensor
    output reg  [COUNT_W-1:0]  n_reserved,  // words of reserved types
    output wire [COUNT_W-1:0]  n_cut,       // words of which a part is missing
    output wire                idle         // nothing inside
);

    parameter_check #(.OK(T_W >= 35 && T_W <= 64)) T_W_must_be_35_to_64 ();

    localparam LOW_W  = 6;
    localparam MARK_W = 28;
    // Types 0, 1 (events), 8 (time mark), 10 (trigger), 14 and 15 (vendors').
    localparam [15:0] DEFINED = 16'b1100_0101_0000_0011;

    wire        word_valid, word_ready, words_idle;
    wire [31:0] word;

    axis_words #(
        .DATA_W (DATA_W),
        .WORD_W (32),
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

    wire [3:0]  kind     = word[31:28];
    wire        is_event = kind <= 4'd1;
    wire        taken    = word_valid && word_ready;

    wire [T_W-LOW_W-1:0] high;
    wire                 timed, events_ready, events_idle, unused_differs;

    time_mark #(
        .MARK_W(MARK_W),
        .HIGH_W(T_W - LOW_W)
    ) u_mark (
        .clk    (clk),
        .rst    (rst),
        .set    (taken && kind == 4'd8),
        .mark   (word[MARK_W-1:0]),
        .differs(unused_differs),
        .high   (high),
        .known  (timed)
    );

    event_vector #(
        .L      (1),
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
        .s_t      ({high, word[27:22]}),
        .s_x      ({1'b0, word[21:11]}),
        .s_y      (word[10:0]),
        .s_p      (kind[0]),
        .s_mask   (1'b1),
        .s_known  (timed),
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
        if (taken && !DEFINED[kind]) n_reserved <= n_reserved + 1'b1;
        if (rst) n_reserved <= {COUNT_W{1'b0}};
    end

endmodule

`default_nettype wire
