// SPDX-License-Identifier: Apache-2.0
// evcot in Prophesee's KV260 design: EVT 2.1 in, records out, both AXI4-Stream of 64 bits (docs/hardware.md).
//
// It is placed between the Event Stream Smart Tracker and the PS Host Interface, on their clock. The ports follow Vivado's naming
// convention, so a block design infers the buses. The IMX636 has 1280 x 720 pixels.
`default_nettype none
`include "evcot_regs.vh"

module kv260_evcot #(
    parameter TRACKER = 0  // of evcot_top: 0 cot_array, 1 cot_chain, 2 cot_motion
) (
    input  wire        aclk,     // the pipeline's clock
    input  wire        aresetn,  // peripheral_aresetn of its Processor System Reset

    // from event_stream_smart_tracker, out_event_stream
    input  wire        s_axis_tvalid,
    output wire        s_axis_tready,
    input  wire [63:0] s_axis_tdata,
    input  wire [7:0]  s_axis_tkeep,
    input  wire        s_axis_tlast,

    // to ps_host_if, s_axis: six words a record, seven of cot_motion
    output wire        m_axis_tvalid,
    input  wire        m_axis_tready,
    output wire [63:0] m_axis_tdata,
    output wire [7:0]  m_axis_tkeep,
    output wire        m_axis_tlast,

    // registers, on a further port of the AXI interconnect: 16 KiB
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

    output wire        irq       // a level, to pl_ps_irq0
);

    /* verilator lint_off PINCONNECTEMPTY */
    evcot_top #(
        .SOURCES(16),   // EVT 2.1 and nothing else
        .SOURCE (4),
        .TRACKER(TRACKER),
        .N      (8),
        .WIDTH  (1280),
        .HEIGHT (720),
        .X_W    (11),
        .Y_W    (10),
        .DATA_W (64)
    ) u_evcot (
        .clk                  (aclk),
        .rst                  (!aresetn),
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
        .s_axis_tvalid        (s_axis_tvalid),
        .s_axis_tready        (s_axis_tready),
        .s_axis_tdata         (s_axis_tdata),
        .s_axis_tkeep         (s_axis_tkeep),
        .s_axis_tlast         (s_axis_tlast),
        .aer_req              (1'b1),  // active low after reset
        .aer_ack              (),
        .aer_row              (1'b0),
        .aer_data             (22'd0),
        .m_axis_records_tvalid(m_axis_tvalid),
        .m_axis_records_tready(m_axis_tready),
        .m_axis_records_tdata (m_axis_tdata),
        .m_axis_records_tkeep (m_axis_tkeep),
        .m_axis_records_tlast (m_axis_tlast),
        .m_axis_owned_tvalid  (),
        .m_axis_owned_tready  (1'b1),  // not connected: without this the trackers would stall
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
