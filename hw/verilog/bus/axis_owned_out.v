// SPDX-License-Identifier: Apache-2.0
// Owned events to AXI4-Stream, one per beat of 64 bits: EVCOT_OWNED_* in evcot_regs.vh, docs/registers.md.
//
// tuser is the slot, so that a switch can route each slot to its own classifier. Each event is a packet: tlast is 1.
//
// Latency:    1 clock.
// Throughput: an event per clock.
// Stall:      a beat is held until accepted.
// Reset:      becomes empty.
// Combinational paths: none.
`default_nettype none
`include "evcot_regs.vh"

module axis_owned_out #(
    parameter SLOT_W = 3,   // bits of a slot number
    parameter REL_W  = 10,  // bits of an address in a window
    parameter SEQ_W  = 48   // bits of an event's number
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              s_own_valid,
    output wire              s_own_ready,
    input  wire [SLOT_W-1:0] s_own_slot,
    input  wire [REL_W-1:0]  s_own_x,
    input  wire [REL_W-1:0]  s_own_y,
    input  wire              s_own_p,
    input  wire [SEQ_W-1:0]  s_own_seq,

    output wire              m_axis_tvalid,
    input  wire              m_axis_tready,
    output wire [63:0]       m_axis_tdata,
    output wire [7:0]        m_axis_tkeep,
    output wire [SLOT_W-1:0] m_axis_tuser,
    output wire              m_axis_tlast
);

    localparam LOW_W = (SEQ_W < `EVCOT_OWNED_SEQ_W) ? SEQ_W : `EVCOT_OWNED_SEQ_W;
    localparam W     = SLOT_W + 2 * REL_W + 1 + LOW_W;

    wire [SLOT_W-1:0] slot;
    wire [REL_W-1:0]  x, y;
    wire              p;
    wire [LOW_W-1:0]  seq;

    skid_buffer #(
        .W(W)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_own_valid),
        .s_ready(s_own_ready),
        .s_data ({s_own_slot, s_own_x, s_own_y, s_own_p, s_own_seq[LOW_W-1:0]}),
        .m_valid(m_axis_tvalid),
        .m_ready(m_axis_tready),
        .m_data ({slot, x, y, p, seq})
    );

    reg [63:0] word;

    always @* begin
        word = 64'd0;
        word[`EVCOT_OWNED_X_LSB +: REL_W]     = x;
        word[`EVCOT_OWNED_Y_LSB +: REL_W]     = y;
        word[`EVCOT_OWNED_SLOT_LSB +: SLOT_W] = slot;
        word[`EVCOT_OWNED_P_LSB]              = p;
        word[`EVCOT_OWNED_SEQ_LSB +: LOW_W]   = seq;
    end

    assign m_axis_tdata = word;
    assign m_axis_tkeep = 8'hff;
    assign m_axis_tuser = slot;
    assign m_axis_tlast = 1'b1;

    wire unused = &{1'b0, s_own_seq};

endmodule

`default_nettype wire
