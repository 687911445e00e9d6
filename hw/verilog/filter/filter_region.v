// SPDX-License-Identifier: Apache-2.0
// Keeps the events inside one rectangle: region_x0 <= x <= region_x1 and region_y0 <= y <= region_y1 (docs/filters.md).
//
// Latency:    1 clock from s_ to m_.
// Throughput: 1 token per clock.
// Stall:      a token is held until accepted.
// Reset:      becomes empty.
// Combinational paths: none; s_ready and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module filter_region #(
    parameter X_W    = 9,  // bits of an x address
    parameter Y_W    = 9,  // bits of a y address
    parameter TICK_W = 20  // bits of the tick input
) (
    input  wire              clk,
    input  wire              rst,

    // registers: see filter_regs.v
    input  wire              enable,
    input  wire [15:0]       region_x0,
    input  wire [15:0]       region_x1,
    input  wire [15:0]       region_y0,
    input  wire [15:0]       region_y1,

    // tokens in
    input  wire              s_valid,
    output wire              s_ready,
    input  wire [TICK_W-1:0] s_tick,
    input  wire              s_event,
    input  wire              s_skip,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    input  wire              s_p,

    // tokens out
    output wire              m_valid,
    input  wire              m_ready,
    output wire [TICK_W-1:0] m_tick,
    output wire              m_event,
    output wire              m_skip,
    output wire [X_W-1:0]    m_x,
    output wire [Y_W-1:0]    m_y,
    output wire              m_p,

    output wire              idle  // nothing inside
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();

    wire [16:0] x = {{(17 - X_W) {1'b0}}, s_x};
    wire [16:0] y = {{(17 - Y_W) {1'b0}}, s_y};

    wire in_region = x >= {1'b0, region_x0} && x <= {1'b0, region_x1} && y >= {1'b0, region_y0} && y <= {1'b0, region_y1};
    wire drops = s_event && enable && !in_region;

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_valid),
        .s_ready(s_ready),
        .s_data ({s_tick, s_event && !drops, s_skip || drops, s_x, s_y, s_p}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign idle = !m_valid;

endmodule

`default_nettype wire
