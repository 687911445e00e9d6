// SPDX-License-Identifier: Apache-2.0
// evcot behind the AER bus of a DAVIS240C: word-serial addresses in, records out on AXI4-Stream of 32 bits (docs/hardware.md).
//
// The chip's word has 10 bits. The highest is 0 for a row, whose address is in the low 8, and 1 for a column: polarity lowest,
// the address above it. Request and acknowledge are active low. If a chip counts its rows from below, the picture is upside down:
// invert the row address here if that matters.
`default_nettype none
`include "evcot_regs.vh"

module davis_evcot (
    input  wire        clk,
    input  wire        rst,

    // the chip; asynchronous: constraints in davis_evcot.xdc
    input  wire        davis_req_n,
    output wire        davis_ack_n,
    input  wire [9:0]  davis_data,

    output wire        m_axis_tvalid,
    input  wire        m_axis_tready,
    output wire [31:0] m_axis_tdata,
    output wire [3:0]  m_axis_tkeep,
    output wire        m_axis_tlast,

    input  wire        s_axi_awvalid,
    output wire        s_axi_awready,
    input  wire [`EVCOT_CSR_ADDR_W-1:0] s_axi_awaddr,
    input  wire [2:0]  s_axi_awprot,
    input  wire        s_axi_wvalid,
    output wire        s_axi_wready,
    input  wire [31:0] s_axi_wdata,
    input  wire [3:0]  s_axi_wstrb,
    output wire        s_axi_bvalid,
    input  wire        s_axi_bready,
    output wire [1:0]  s_axi_bresp,
    input  wire        s_axi_arvalid,
    output wire        s_axi_arready,
    input  wire [`EVCOT_CSR_ADDR_W-1:0] s_axi_araddr,
    input  wire [2:0]  s_axi_arprot,
    output wire        s_axi_rvalid,
    input  wire        s_axi_rready,
    output wire [31:0] s_axi_rdata,
    output wire [1:0]  s_axi_rresp,
    output wire        irq
);

    /* verilator lint_off PINCONNECTEMPTY */
    evcot_top #(
        .SOURCES(4),  // AER
        .SOURCE (2),
        .N      (4),
        .WIDTH  (240),
        .HEIGHT (180),
        .X_W    (8),
        .Y_W    (8),
        .DATA_W (32)
    ) u_evcot (
        .clk                  (clk),
        .rst                  (rst),
        .s_axil_awvalid       (s_axi_awvalid),
        .s_axil_awready       (s_axi_awready),
        .s_axil_awaddr        (s_axi_awaddr),
        .s_axil_awprot        (s_axi_awprot),
        .s_axil_wvalid        (s_axi_wvalid),
        .s_axil_wready        (s_axi_wready),
        .s_axil_wdata         (s_axi_wdata),
        .s_axil_wstrb         (s_axi_wstrb),
        .s_axil_bvalid        (s_axi_bvalid),
        .s_axil_bready        (s_axi_bready),
        .s_axil_bresp         (s_axi_bresp),
        .s_axil_arvalid       (s_axi_arvalid),
        .s_axil_arready       (s_axi_arready),
        .s_axil_araddr        (s_axi_araddr),
        .s_axil_arprot        (s_axi_arprot),
        .s_axil_rvalid        (s_axi_rvalid),
        .s_axil_rready        (s_axi_rready),
        .s_axil_rdata         (s_axi_rdata),
        .s_axil_rresp         (s_axi_rresp),
        .irq                  (irq),
        .s_axis_tvalid        (1'b0),
        .s_axis_tready        (),
        .s_axis_tdata         (64'd0),
        .s_axis_tkeep         (8'hFF),
        .s_axis_tlast         (1'b0),
        .aer_req              (davis_req_n),
        .aer_ack              (davis_ack_n),
        .aer_row              (!davis_data[9]),
        .aer_data             ({8'd0, davis_data[8:0]}),
        .m_axis_records_tvalid(m_axis_tvalid),
        .m_axis_records_tready(m_axis_tready),
        .m_axis_records_tdata (m_axis_tdata),
        .m_axis_records_tkeep (m_axis_tkeep),
        .m_axis_records_tlast (m_axis_tlast),
        .m_axis_owned_tvalid  (),
        .m_axis_owned_tready  (1'b1),
        .m_axis_owned_tdata   (),
        .m_axis_owned_tkeep   (),
        .m_axis_owned_tuser   (),
        .m_axis_owned_tlast   (),
        .m_axis_passed_tvalid (),
        .m_axis_passed_tready (1'b1),
        .m_axis_passed_tdata  (),
        .m_axis_passed_tkeep  (),
        .m_axis_passed_tlast  ()
    );
    /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
