// SPDX-License-Identifier: Apache-2.0
// Decoder for one of Prophesee's formats on 64-bit beats, EVT 2.0, 2.1 or 3.0, with the same ports for each.
//
// Latency:    that of evt2_decoder.v, evt21_decoder.v or evt3_decoder.v, as all below.
// Throughput: likewise.
// Stall:      likewise.
// Reset:      likewise.
// Combinational paths: none.
`default_nettype none
`include "evcot_regs.vh"

module evt_source #(
    parameter FORMAT = `EVCOT_SOURCE_EVT2,  // EVCOT_SOURCE_EVT2, _EVT21 or _EVT3
    parameter T_W    = 48,                  // bits of a time, microseconds
    parameter X_W    = 9,                   // bits of an x address
    parameter Y_W    = 9,                   // bits of a y address
    parameter WIDTH  = 346,                 // pixels of the sensor across
    parameter HEIGHT = 260                  // pixels of the sensor down
) (
    input  wire           clk,
    input  wire           rst,

    input  wire           swap_bytes,   // the high byte of a word comes first
    input  wire           swap_halves,  // EVT 2.1: the upper half of a word comes first

    input  wire           s_axis_tvalid,
    output wire           s_axis_tready,
    input  wire [63:0]    s_axis_tdata,
    input  wire [7:0]     s_axis_tkeep,
    input  wire           s_axis_tlast,

    output wire           m_valid,
    input  wire           m_ready,
    output wire [T_W-1:0] m_t,
    output wire [X_W-1:0] m_x,
    output wire [Y_W-1:0] m_y,
    output wire           m_p,

    output reg  [31:0]    n_skipped,    // words and events left out
    output wire           idle
);

    parameter_check #(
        .OK(FORMAT >= `EVCOT_SOURCE_EVT2 && FORMAT <= `EVCOT_SOURCE_EVT3)
    ) FORMAT_must_be_EVT2_EVT21_or_EVT3 ();

    wire [31:0] n_events, n_untimed, n_outside, n_reserved, n_cut;

    generate
        if (FORMAT == `EVCOT_SOURCE_EVT21) begin : g_evt21
            evt21_decoder #(
                .DATA_W(64),
                .T_W   (T_W),
                .X_W   (X_W),
                .Y_W   (Y_W),
                .WIDTH (WIDTH),
                .HEIGHT(HEIGHT)
            ) u_decoder (
                .clk          (clk),
                .rst          (rst),
                .swap_bytes   (swap_bytes),
                .swap_halves  (swap_halves),
                .s_axis_tvalid(s_axis_tvalid),
                .s_axis_tready(s_axis_tready),
                .s_axis_tdata (s_axis_tdata),
                .s_axis_tkeep (s_axis_tkeep),
                .s_axis_tlast (s_axis_tlast),
                .m_valid      (m_valid),
                .m_ready      (m_ready),
                .m_t          (m_t),
                .m_x          (m_x),
                .m_y          (m_y),
                .m_p          (m_p),
                .n_events     (n_events),
                .n_untimed    (n_untimed),
                .n_outside    (n_outside),
                .n_reserved   (n_reserved),
                .n_cut        (n_cut),
                .idle         (idle)
            );
        end else if (FORMAT == `EVCOT_SOURCE_EVT3) begin : g_evt3
            evt3_decoder #(
                .DATA_W(64),
                .T_W   (T_W),
                .X_W   (X_W),
                .Y_W   (Y_W),
                .WIDTH (WIDTH),
                .HEIGHT(HEIGHT)
            ) u_decoder (
                .clk          (clk),
                .rst          (rst),
                .swap_bytes   (swap_bytes),
                .s_axis_tvalid(s_axis_tvalid),
                .s_axis_tready(s_axis_tready),
                .s_axis_tdata (s_axis_tdata),
                .s_axis_tkeep (s_axis_tkeep),
                .s_axis_tlast (s_axis_tlast),
                .m_valid      (m_valid),
                .m_ready      (m_ready),
                .m_t          (m_t),
                .m_x          (m_x),
                .m_y          (m_y),
                .m_p          (m_p),
                .n_events     (n_events),
                .n_untimed    (n_untimed),
                .n_outside    (n_outside),
                .n_reserved   (n_reserved),
                .n_cut        (n_cut),
                .idle         (idle)
            );
        end else begin : g_evt2
            evt2_decoder #(
                .DATA_W(64),
                .T_W   (T_W),
                .X_W   (X_W),
                .Y_W   (Y_W),
                .WIDTH (WIDTH),
                .HEIGHT(HEIGHT)
            ) u_decoder (
                .clk          (clk),
                .rst          (rst),
                .swap_bytes   (swap_bytes),
                .s_axis_tvalid(s_axis_tvalid),
                .s_axis_tready(s_axis_tready),
                .s_axis_tdata (s_axis_tdata),
                .s_axis_tkeep (s_axis_tkeep),
                .s_axis_tlast (s_axis_tlast),
                .m_valid      (m_valid),
                .m_ready      (m_ready),
                .m_t          (m_t),
                .m_x          (m_x),
                .m_y          (m_y),
                .m_p          (m_p),
                .n_events     (n_events),
                .n_untimed    (n_untimed),
                .n_outside    (n_outside),
                .n_reserved   (n_reserved),
                .n_cut        (n_cut),
                .idle         (idle)
            );
        end
    endgenerate

    always @(posedge clk) n_skipped <= rst ? 32'd0 : n_untimed + n_outside + n_reserved + n_cut;

    wire unused = &{1'b0, n_events, swap_halves};

endmodule

`default_nettype wire
