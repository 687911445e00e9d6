// SPDX-License-Identifier: Apache-2.0
// Four published trackers in cascade behind the published register addresses and output word: docs/published.md.
//
// A tracker sees what those before it rejected; one that is not enabled is a pair of wires. Centres and events of all four
// leave on one line as 25-bit words, {tag, high, low, event}: tag 0x00 to 0x03 a centre of tracker 0 to 3, with event = 0;
// 0x10 to 0x13 an event of that cluster, with event = 1. Rank on the line: centres 0 to 3, then events 0 to 3.
// Events that all four reject leave on the pass-through port; the published library drops them: tie m_pass_ack_n low.
// LIBRARY_LINE = 1 is the library as a whole, whose line keeps an event for 5 clocks or longer, fewer after an acknowledge from
// before; in each of them its tracker updates the average; 0 is the trackers by themselves, on a line without delay (aer_merge.v).
// In the library an event of a cluster has a second receiver, a pattern cell, whose acknowledge its tracker awaits as well. Of
// that cell there is here the clock in which it answers, nothing else: docs/published.md.
//
// Latency:    clocks from a request, every output acknowledged at once: event of a cluster 5 (LIBRARY_LINE = 0: 3), centre 14
//             (8), rejected 3; plus 3 for each enabled tracker upstream.
// Stall:      a word waits for the line, and its tracker with it; a tracker that is busy acknowledges what the one before it
//             passes, which is lost, as in the published library.
// Reset:      every register has its default; no tracker is enabled then and none selected.
// Combinational paths: s_high, s_low -> m_pass_high, m_pass_low; past trackers that are not enabled, s_req_n -> m_pass_req_n and
//             m_pass_ack_n -> s_ack_n.
// Throughput: one event at a time in each tracker: the next request after its acknowledge.
`default_nettype none
`include "published_regs.vh"

module cot_published_chain #(
    parameter LIBRARY_LINE = 1  // 1: the library's output line; 0: one without delay
) (
    input  wire        clk,
    input  wire        rst,

    // registers: a write of 1 to 4 to 127 selects tracker 0 to 3, of any other value none. The selected one is held in
    // reset and takes the writes to 78 .. 91.
    input  wire        cfg_valid,
    input  wire [7:0]  cfg_addr,
    input  wire [7:0]  cfg_data,

    // events
    input  wire        s_req_n,
    output wire        s_ack_n,
    input  wire [7:0]  s_high,
    input  wire [7:0]  s_low,

    // events of the clusters, and their centres
    output wire        m_req_n,
    input  wire        m_ack_n,
    output wire [24:0] m_word,

    // events that no tracker took
    output wire        m_pass_req_n,
    input  wire        m_pass_ack_n,
    output wire [7:0]  m_pass_high,
    output wire [7:0]  m_pass_low
);

    parameter_check #(.OK(LIBRARY_LINE == 0 || LIBRARY_LINE == 1)) LIBRARY_LINE_must_be_0_or_1 ();

    localparam N = 4;
    localparam WORD_W = 25;

    reg [7:0] selected;
    always @(posedge clk) begin
        if (cfg_valid && cfg_addr == `PUBLISHED_REG_SELECT) selected <= cfg_data;
        if (rst) selected <= `PUBLISHED_SELECT_NONE;
    end

    // link i leads into tracker i, link N out of the cascade; all have the same address
    wire [N:0] link_req_n, link_ack_n;

    assign link_req_n[0] = s_req_n;
    assign s_ack_n       = link_ack_n[0];
    assign m_pass_req_n  = link_req_n[N];
    assign link_ack_n[N] = m_pass_ack_n;
    assign m_pass_high   = s_high;
    assign m_pass_low    = s_low;

    // what the trackers send: centres, then events
    wire [2*N-1:0]        req_n, ack_n;
    wire [2*N*WORD_W-1:0] word;

    wire [3:0] clamped_k = (cfg_data == 8'd0) ? 4'd1 : (cfg_data > 8'd8) ? 4'd8 : cfg_data[3:0];

    genvar i;
    generate
        for (i = 0; i < N; i = i + 1) begin : g_tracker
            localparam [31:0] INDEX  = i;
            localparam [7:0]  NUMBER = i + `PUBLISHED_SELECT_FIRST;

            // ---- registers -----------------------------------------------------------------------------------------

            wire mine = selected == NUMBER;

            reg [7:0]  init_cm_low, init_cm_high, init_radix, nev_th, radix_max, radix_min;
            reg [2:0]  radix_th, radix_step;
            reg [31:0] max_time;
            reg [3:0]  hist_avg;
            reg        enable;

            wire [31:0] resets_cm_low = `PUBLISHED_RESET_INIT_CM_LOW;
            wire [7:0]  reset_cm_low  = resets_cm_low[8*i +: 8];

            always @(posedge clk) begin
                if (cfg_valid && mine) begin
                    case (cfg_addr)
                        `PUBLISHED_REG_INIT_CM_LOW:      init_cm_low <= cfg_data;
                        `PUBLISHED_REG_INIT_CM_HIGH:     init_cm_high <= cfg_data;
                        `PUBLISHED_REG_RADIX_TH:         radix_th <= cfg_data[2:0];
                        `PUBLISHED_REG_INIT_RADIX:       init_radix <= cfg_data;
                        `PUBLISHED_REG_MAX_TIME:         max_time[7:0] <= cfg_data;
                        `PUBLISHED_REG_MAX_TIME + 8'd1:  max_time[15:8] <= cfg_data;
                        `PUBLISHED_REG_MAX_TIME + 8'd2:  max_time[23:16] <= cfg_data;
                        `PUBLISHED_REG_MAX_TIME + 8'd3:  max_time[31:24] <= cfg_data;
                        `PUBLISHED_REG_NEV_TH:           nev_th <= cfg_data;
                        `PUBLISHED_REG_HIST_AVG:         hist_avg <= clamped_k;
                        `PUBLISHED_REG_ENABLE:           if (cfg_data == 8'hFF || cfg_data == 8'h00) enable <= cfg_data[0];
                        `PUBLISHED_REG_RADIX_STEP:       radix_step <= cfg_data[2:0];
                        `PUBLISHED_REG_RADIX_MAX:        radix_max <= cfg_data;
                        `PUBLISHED_REG_RADIX_MIN:        radix_min <= cfg_data;
                        default:              ;
                    endcase
                end
                if (rst) begin
                    init_cm_low  <= reset_cm_low;
                    init_cm_high <= `PUBLISHED_RESET_INIT_CM_HIGH;
                    radix_th     <= `PUBLISHED_RESET_RADIX_TH;
                    init_radix   <= `PUBLISHED_RESET_INIT_RADIX;
                    max_time     <= `PUBLISHED_RESET_MAX_TIME;
                    nev_th       <= `PUBLISHED_RESET_NEV_TH;
                    hist_avg     <= `PUBLISHED_RESET_HIST_AVG;
                    enable       <= `PUBLISHED_RESET_ENABLE;
                    radix_step   <= `PUBLISHED_RESET_RADIX_STEP;
                    radix_max    <= `PUBLISHED_RESET_RADIX_MAX;
                    radix_min    <= `PUBLISHED_RESET_RADIX_MIN;
                end
            end

            // ---- tracker -------------------------------------------------------------------------------------------

            wire       tracker_ack_n, pass_req_n;
            wire [7:0] pass_high, pass_low, event_high, event_low, centre_high, centre_low;

            cot_published u_tracker (
                .clk           (clk),
                .rst           (rst || mine),
                .init_cm_high  (init_cm_high),
                .init_cm_low   (init_cm_low),
                .init_radix    (init_radix),
                .radix_th      (radix_th),
                .radix_step    (radix_step),
                .radix_min     (radix_min),
                .radix_max     (radix_max),
                .max_time      (max_time),
                .nev_th        (nev_th),
                .hist_avg      (hist_avg),
                .s_req_n       (link_req_n[i] || !enable),
                .s_ack_n       (tracker_ack_n),
                .s_high        (s_high),
                .s_low         (s_low),
                .m_pass_req_n  (pass_req_n),
                .m_pass_ack_n  (link_ack_n[i+1]),
                .m_pass_high   (pass_high),
                .m_pass_low    (pass_low),
                .m_event_req_n (req_n[N+i]),
                .m_event_ack_n (ack_n[N+i]),
                .m_event_high  (event_high),
                .m_event_low   (event_low),
                .m_centre_req_n(req_n[i]),
                .m_centre_ack_n(ack_n[i]),
                .m_centre_high (centre_high),
                .m_centre_low  (centre_low)
            );

            assign link_req_n[i+1] = enable ? pass_req_n : link_req_n[i];
            assign link_ack_n[i]   = enable ? tracker_ack_n : link_ack_n[i+1];
            assign word[i*WORD_W +: WORD_W]     = {3'd0, 1'b0, 2'd0, INDEX[1:0], centre_high, centre_low, 1'b0};
            assign word[(N+i)*WORD_W +: WORD_W] = {3'd0, 1'b1, 2'd0, INDEX[1:0], event_high, event_low, 1'b1};

            wire unused = &{1'b0, pass_high, pass_low, INDEX, resets_cm_low};
        end
        if (LIBRARY_LINE != 0) begin : g_library
            wire [2*N-1:0] line_ack_n;

            // the pattern cells: each acknowledges its tracker's event one clock after the request
            reg [N-1:0] pattern_ack_n;
            always @(posedge clk) begin
                pattern_ack_n <= req_n[2*N-1:N];
                if (rst) pattern_ack_n <= {N{1'b1}};
            end

            assign ack_n = line_ack_n | {pattern_ack_n, {N{1'b0}}};

            published_line #(
                .N(2 * N),
                .W(WORD_W)
            ) u_line (
                .clk    (clk),
                .rst    (rst),
                .s_req_n(req_n),
                .s_ack_n(line_ack_n),
                .s_word (word),
                .m_req_n(m_req_n),
                .m_ack_n(m_ack_n),
                .m_word (m_word)
            );
        end else begin : g_merge
            aer_merge #(
                .N(2 * N),
                .W(WORD_W)
            ) u_line (
                .clk    (clk),
                .rst    (rst),
                .s_req_n(req_n),
                .s_ack_n(ack_n),
                .s_word (word),
                .m_req_n(m_req_n),
                .m_ack_n(m_ack_n),
                .m_word (m_word)
            );
        end
    endgenerate

endmodule

`default_nettype wire
