// SPDX-License-Identifier: Apache-2.0
// The design that all boards share: evcot_top with the LFSR as its source (or board_small.v, a part of it), with a self-test and a
// serial line to a host.
//
// After reset board_boot.v writes the settings of the test. Pseudo-random events then go in without end, as fast as the line
// takes the records; the first RECORDS of them are folded into a signature, rotated by one bit and exclusive-ored with each
// 32-bit word. `passed` or `failed` is then asserted by comparison with the golden model's signature (evcot_cosim/fpga/board.py).
// The host (evcot_cosim/fpga/serial_host.py) receives every record, and can read and write all registers (docs/registers.md) once
// board_boot.v has finished; changes after the test do not affect its result.
//
// alive: toggles with every 256th record.
`default_nettype none
`include "evcot_regs.vh"

module board_core #(
    parameter CLOCK_HZ = 12000000,
    parameter BAUD     = 1000000,  // bits per second of the line
    parameter FULL     = 1,        // 0: board_small
    parameter TRACKER  = 0,        // of evcot_top: 0 cot_array, 1 cot_chain
    parameter N        = 4         // tracker slots, 1, 2, 4 or 8
) (
    input  wire clk,
    input  wire rst,
    input  wire rx,
    output wire tx,
    output reg  passed,
    output reg  failed,
    output wire alive
);

    `include "board_selftest.vh"

    parameter_check #(.OK(N == 1 || N == 2 || N == 4 || N == 8)) N_must_be_1_2_4_or_8 ();

    localparam A      = `EVCOT_CSR_ADDR_W;

    // ---- the bus: first the boot's, then the host's ------------------------------------------------------------------

    wire         booted;
    wire         boot_awvalid, boot_wvalid, boot_bready, host_awvalid, host_wvalid, host_bready, host_arvalid, host_rready;
    wire [A-1:0] boot_awaddr, host_awaddr, host_araddr;
    wire [31:0]  boot_wdata, host_wdata;
    wire         awready, wready, bvalid, arready, rvalid;
    wire [1:0]   bresp, rresp;
    wire [31:0]  rdata;

    board_boot #(
        .N(N)
    ) u_boot (
        .clk           (clk),
        .rst           (rst),
        .done          (booted),
        .m_axil_awvalid(boot_awvalid),
        .m_axil_awready(awready),
        .m_axil_awaddr (boot_awaddr),
        .m_axil_wvalid (boot_wvalid),
        .m_axil_wready (wready),
        .m_axil_wdata  (boot_wdata),
        .m_axil_bvalid (bvalid),
        .m_axil_bready (boot_bready)
    );

    wire        record_valid, record_ready, record_last;
    wire [31:0] record_data;
    wire [3:0]  record_keep;

    uart_host #(
        .DIVISOR((CLOCK_HZ + BAUD / 2) / BAUD),
        .ADDR_W (A)
    ) u_host (
        .clk           (clk),
        .rst           (rst),
        .rx            (rx),
        .tx            (tx),
        .m_axil_awvalid(host_awvalid),
        .m_axil_awready(booted && awready),
        .m_axil_awaddr (host_awaddr),
        .m_axil_wvalid (host_wvalid),
        .m_axil_wready (booted && wready),
        .m_axil_wdata  (host_wdata),
        .m_axil_bvalid (booted && bvalid),
        .m_axil_bready (host_bready),
        .m_axil_bresp  (bresp),
        .m_axil_arvalid(host_arvalid),
        .m_axil_arready(arready),
        .m_axil_araddr (host_araddr),
        .m_axil_rvalid (rvalid),
        .m_axil_rready (host_rready),
        .m_axil_rdata  (rdata),
        .m_axil_rresp  (rresp),
        .s_axis_tvalid (record_valid),
        .s_axis_tready (record_ready),
        .s_axis_tdata  (record_data),
        .s_axis_tkeep  (record_keep),
        .s_axis_tlast  (record_last)
    );

    // ---- the tracker -------------------------------------------------------------------------------------------------

    wire         awvalid = booted ? host_awvalid : boot_awvalid;
    wire         wvalid  = booted ? host_wvalid : boot_wvalid;
    wire         bready  = booted ? host_bready : boot_bready;
    wire [A-1:0] awaddr  = booted ? host_awaddr : boot_awaddr;
    wire [31:0]  wdata   = booted ? host_wdata : boot_wdata;

    /* verilator lint_off PINCONNECTEMPTY */
    generate
        if (FULL != 0) begin : g_full
            evcot_top #(
                .SOURCES     (1 << `EVCOT_SOURCE_LFSR),
                .SOURCE      (`EVCOT_SOURCE_LFSR),
                .TRACKER     (TRACKER),
                .WIDTH       (WIDTH),
                .HEIGHT      (HEIGHT),
                .FIFO_DEPTH  (4),
                .RECORD_DEPTH(2),
                .DATA_W      (32),
                .N           (N),
                .X_W         (SHAPE_X_W),
                .Y_W         (SHAPE_Y_W),
                .FRAC        (SHAPE_FRAC),
                .TICK_W      (SHAPE_TICK_W),
                .RADIX_W     (SHAPE_RADIX_W),
                .NEV_W       (SHAPE_NEV_W),
                .TC_W        (SHAPE_TC_W),
                .SUP_W       (SHAPE_SUP_W),
                .ID_W        (SHAPE_ID_W),
                .SEQ_W       (SHAPE_SEQ_W),
                .TIME_W      (SHAPE_TIME_W)
            ) u_top (
                .clk                  (clk),
                .rst                  (rst),
                .s_axil_awvalid       (awvalid),
                .s_axil_awready       (awready),
                .s_axil_awaddr        (awaddr),
                .s_axil_awprot        (3'd0),
                .s_axil_wvalid        (wvalid),
                .s_axil_wready        (wready),
                .s_axil_wdata         (wdata),
                .s_axil_wstrb         (4'hF),
                .s_axil_bvalid        (bvalid),
                .s_axil_bready        (bready),
                .s_axil_bresp         (bresp),
                .s_axil_arvalid       (host_arvalid),
                .s_axil_arready       (arready),
                .s_axil_araddr        (host_araddr),
                .s_axil_arprot        (3'd0),
                .s_axil_rvalid        (rvalid),
                .s_axil_rready        (host_rready),
                .s_axil_rdata         (rdata),
                .s_axil_rresp         (rresp),
                .irq                  (),
                .s_axis_tvalid        (1'b0),
                .s_axis_tready        (),
                .s_axis_tdata         (64'd0),
                .s_axis_tkeep         (8'hFF),
                .s_axis_tlast         (1'b0),
                .aer_req              (1'b1),
                .aer_ack              (),
                .aer_row              (1'b0),
                .aer_data             ({SHAPE_X_W + SHAPE_Y_W + 1{1'b0}}),
                .m_axis_records_tvalid(record_valid),
                .m_axis_records_tready(record_ready),
                .m_axis_records_tdata (record_data),
                .m_axis_records_tkeep (record_keep),
                .m_axis_records_tlast (record_last),
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
        end else begin : g_small
            board_small #(
                .N(N)
            ) u_small (
                .clk                  (clk),
                .rst                  (rst),
                .s_axil_awvalid       (awvalid),
                .s_axil_awready       (awready),
                .s_axil_awaddr        (awaddr),
                .s_axil_wvalid        (wvalid),
                .s_axil_wready        (wready),
                .s_axil_wdata         (wdata),
                .s_axil_bvalid        (bvalid),
                .s_axil_bready        (bready),
                .s_axil_bresp         (bresp),
                .s_axil_arvalid       (host_arvalid),
                .s_axil_arready       (arready),
                .s_axil_araddr        (host_araddr),
                .s_axil_rvalid        (rvalid),
                .s_axil_rready        (host_rready),
                .s_axil_rdata         (rdata),
                .s_axil_rresp         (rresp),
                .m_axis_records_tvalid(record_valid),
                .m_axis_records_tready(record_ready),
                .m_axis_records_tdata (record_data),
                .m_axis_records_tkeep (record_keep),
                .m_axis_records_tlast (record_last)
            );
        end
    endgenerate
    /* verilator lint_on PINCONNECTEMPTY */

    // ---- the test ----------------------------------------------------------------------------------------------------

    localparam [31:0] SIGNATURE = (N == 1) ? SIGNATURE_1 : (N == 2) ? SIGNATURE_2 : (N == 4) ? SIGNATURE_4 : SIGNATURE_8;

    reg [31:0] signature;
    reg [15:0] records;
    reg        over;  // the last record of the test is in the signature

    assign alive = records[8];

    always @(posedge clk) begin
        if (record_valid && record_ready) begin
            if (!over) signature <= {signature[30:0], signature[31]} ^ record_data;
            if (record_last) begin
                records <= records + 16'd1;
                over    <= over || records == RECORDS - 16'd1;
            end
        end
        passed <= over && signature == SIGNATURE;
        failed <= over && signature != SIGNATURE;
        if (rst) begin
            signature <= 32'd0;
            records   <= 16'd0;
            over      <= 1'b0;
            passed    <= 1'b0;
            failed    <= 1'b0;
        end
    end


endmodule

`default_nettype wire
