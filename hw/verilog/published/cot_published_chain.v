// SPDX-License-Identifier: Apache-2.0
// Four published trackers in cascade behind the published register addresses and output word: docs/published.md.
//
// A tracker sees what those before it rejected; one that is not enabled is a pair of wires. Centres and events of all four
// leave on one line as 25-bit words, {tag, high, low, event}: tag 0x00 to 0x03 a centre of tracker 0 to 3, with event = 0;
// 0x10 to 0x13 an event of that cluster, with event = 1. If two have a word at once, the lower tracker goes first.
// Events that all four reject leave on the pass-through port.
//
// Clocks from a request, every output acknowledged at once: as cot_published.v, plus 3 for each enabled tracker upstream.
// Reset gives every register its default; no tracker is enabled then and none selected.
`default_nettype none
`include "published_regs.vh"

module cot_published_chain (
    input  wire        clk,
    input  wire        rst,

    // registers: a write to 127 selects a tracker, 0 to 3, or none, any other value. The selected one is held in reset
    // and takes the writes to 78 .. 91.
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

    localparam N = 4;
    localparam WORD_W = 25;

    reg [7:0] selected;
    always @(posedge clk) begin
        if (cfg_valid && cfg_addr == `PUBLISHED_REG_SELECT) selected <= cfg_data;
        if (rst) selected <= `PUBLISHED_SELECT_NONE;
    end

    // link i leads into tracker i, link N out of the cascade
    wire [N:0]          link_req_n, link_ack_n;
    wire [16*(N+1)-1:0] link;
    wire [N-1:0]        req_n, ack_n;
    wire [N*WORD_W-1:0] word;

    assign link_req_n[0] = s_req_n;
    assign s_ack_n       = link_ack_n[0];
    assign link[15:0]    = {s_high, s_low};
    assign m_pass_req_n  = link_req_n[N];
    assign link_ack_n[N] = m_pass_ack_n;
    assign {m_pass_high, m_pass_low} = link[16*N +: 16];

    genvar i;
    generate
        for (i = 0; i < N; i = i + 1) begin : g_tracker
            localparam [7:0] INDEX = i;

            // ---- registers -----------------------------------------------------------------------------------------

            wire mine = selected == INDEX;

            reg [7:0]  init_cm_low, init_cm_high, init_radix, nev_th, radix_max, radix_min;
            reg [2:0]  radix_th, radix_step;
            reg [31:0] max_time;
            reg [3:0]  hist_avg;
            reg        enable;

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
                        `PUBLISHED_REG_HIST_AVG:         hist_avg <= cfg_data[3:0];
                        `PUBLISHED_REG_ENABLE:           enable <= |cfg_data;
                        `PUBLISHED_REG_RADIX_STEP:       radix_step <= cfg_data[2:0];
                        `PUBLISHED_REG_RADIX_MAX:        radix_max <= cfg_data;
                        `PUBLISHED_REG_RADIX_MIN:        radix_min <= cfg_data;
                        default:              ;
                    endcase
                end
                if (rst) begin
                    init_cm_low  <= `PUBLISHED_RESET_INIT_CM_LOW;
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

            wire       tracker_ack_n, pass_req_n, is_event;
            wire [7:0] pass_high, pass_low, high, low;

            cot_published u_tracker (
                .clk         (clk),
                .rst         (rst || mine),
                .init_cm_high(init_cm_high),
                .init_cm_low (init_cm_low),
                .init_radix  (init_radix),
                .radix_th    (radix_th),
                .radix_step  (radix_step),
                .radix_min   (radix_min),
                .radix_max   (radix_max),
                .max_time    (max_time),
                .nev_th      (nev_th),
                .hist_avg    (hist_avg),
                .s_req_n     (link_req_n[i] || !enable),
                .s_ack_n     (tracker_ack_n),
                .s_high      (link[i*16+8 +: 8]),
                .s_low       (link[i*16 +: 8]),
                .m_pass_req_n(pass_req_n),
                .m_pass_ack_n(link_ack_n[i+1]),
                .m_pass_high (pass_high),
                .m_pass_low  (pass_low),
                .m_req_n     (req_n[i]),
                .m_ack_n     (ack_n[i]),
                .m_event     (is_event),
                .m_high      (high),
                .m_low       (low)
            );

            assign link_req_n[i+1]         = enable ? pass_req_n : link_req_n[i];
            assign link_ack_n[i]           = enable ? tracker_ack_n : link_ack_n[i+1];
            assign link[(i+1)*16 +: 16]    = enable ? {pass_high, pass_low} : link[i*16 +: 16];
            assign word[i*WORD_W +: WORD_W] = {3'd0, is_event, 2'd0, INDEX[1:0], high, low, is_event};
        end
    endgenerate

    aer_merge #(
        .N(N),
        .W(WORD_W)
    ) u_merge (
        .clk    (clk),
        .rst    (rst),
        .s_req_n(req_n),
        .s_ack_n(ack_n),
        .s_word (word),
        .m_req_n(m_req_n),
        .m_ack_n(m_ack_n),
        .m_word (m_word)
    );

endmodule

`default_nettype wire
