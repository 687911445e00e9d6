// SPDX-License-Identifier: Apache-2.0
// Passed events to AXI4-Stream, one per beat of 64 bits: EVCOT_PASSED_* in evcot_regs.vh, docs/registers.md.
//
// Each event is a packet: tlast is 1.
//
// Latency:    1 clock.
// Throughput: an event per clock.
// Stall:      a beat is held until accepted.
// Reset:      becomes empty.
// Combinational paths: none.
`default_nettype none
`include "evcot_regs.vh"

module axis_passed_out #(
    parameter X_W   = 9,  // bits of an x address
    parameter Y_W   = 9,  // bits of a y address
    parameter SEQ_W = 48  // bits of an event's number
) (
    input  wire             clk,
    input  wire             rst,

    input  wire             s_pass_valid,
    output wire             s_pass_ready,
    input  wire [X_W-1:0]   s_pass_x,
    input  wire [Y_W-1:0]   s_pass_y,
    input  wire             s_pass_p,
    input  wire [SEQ_W-1:0] s_pass_seq,

    output wire             m_axis_tvalid,
    input  wire             m_axis_tready,
    output wire [63:0]      m_axis_tdata,
    output wire [7:0]       m_axis_tkeep,
    output wire             m_axis_tlast
);

    localparam LOW_W = (SEQ_W < `EVCOT_PASSED_SEQ_W) ? SEQ_W : `EVCOT_PASSED_SEQ_W;
    localparam W     = X_W + Y_W + 1 + LOW_W;

    wire [X_W-1:0]   x;
    wire [Y_W-1:0]   y;
    wire             p;
    wire [LOW_W-1:0] seq;

    skid_buffer #(
        .W(W)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_pass_valid),
        .s_ready(s_pass_ready),
        .s_data ({s_pass_x, s_pass_y, s_pass_p, s_pass_seq[LOW_W-1:0]}),
        .m_valid(m_axis_tvalid),
        .m_ready(m_axis_tready),
        .m_data ({x, y, p, seq})
    );

    reg [63:0] word;

    always @* begin
        word = 64'd0;
        word[`EVCOT_PASSED_X_LSB +: X_W]     = x;
        word[`EVCOT_PASSED_Y_LSB +: Y_W]     = y;
        word[`EVCOT_PASSED_P_LSB]            = p;
        word[`EVCOT_PASSED_SEQ_LSB +: LOW_W] = seq;
    end

    assign m_axis_tdata = word;
    assign m_axis_tkeep = 8'hff;
    assign m_axis_tlast = 1'b1;

    wire unused = &{1'b0, s_pass_seq};

endmodule

`default_nettype wire
