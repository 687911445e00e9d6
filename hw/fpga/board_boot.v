// SPDX-License-Identifier: Apache-2.0
// Writes what the self-test of a board needs over AXI4-Lite, once, and then leaves the bus to somebody else.
//
// What is written stands in board_selftest.vh, which evcot_cosim/fpga/headers.py makes: words before the slots, a slot's words
// for each slot, words after them. Between two writes there are 64 clocks, time for a reset that one of them asks for.
`default_nettype none
`include "evcot_regs.vh"

module board_boot #(
    parameter N = 8  // tracker slots
) (
    input  wire        clk,
    input  wire        rst,

    output reg         done,

    output reg         m_axil_awvalid,
    input  wire        m_axil_awready,
    output wire [`EVCOT_CSR_ADDR_W-1:0] m_axil_awaddr,
    output reg         m_axil_wvalid,
    input  wire        m_axil_wready,
    output wire [31:0] m_axil_wdata,
    input  wire        m_axil_bvalid,
    output wire        m_axil_bready
);

    `include "board_selftest.vh"  // BEFORE, OF_SLOT, AFTER, SLOT_STEP, boot_word: address, data; RECORDS, SIGNATURE_*

    localparam [6:0] LAST_SLOT = N - 1;

    reg [5:0] word;
    reg [6:0] slot;
    reg [5:0] pause;
    reg       under_way;

    wire of_slot = word >= BEFORE && word < BEFORE + OF_SLOT;
    wire [`EVCOT_CSR_ADDR_W+31:0] entry = boot_word(word);
    wire [`EVCOT_CSR_ADDR_W-1:0]  slot_base = of_slot ? {{`EVCOT_CSR_ADDR_W-7{1'b0}}, slot} * SLOT_STEP : 0;

    assign m_axil_awaddr = entry[32+:`EVCOT_CSR_ADDR_W] + slot_base;
    assign m_axil_wdata  = entry[31:0];
    assign m_axil_bready = under_way;

    always @(posedge clk) begin
        if (m_axil_awready) m_axil_awvalid <= 1'b0;
        if (m_axil_wready)  m_axil_wvalid  <= 1'b0;
        if (!under_way && !done) begin
            pause <= pause + 6'd1;
            if (pause == 6'd63) begin
                under_way      <= 1'b1;
                m_axil_awvalid <= 1'b1;
                m_axil_wvalid  <= 1'b1;
            end
        end
        if (under_way && m_axil_bvalid) begin
            under_way <= 1'b0;
            word      <= word + 6'd1;
            if (word == BEFORE + OF_SLOT - 6'd1 && slot != LAST_SLOT) begin
                word <= BEFORE;
                slot <= slot + 7'd1;
            end
            done <= word == BEFORE + OF_SLOT + AFTER - 6'd1;
        end
        if (rst) begin
            done           <= 1'b0;
            under_way      <= 1'b0;
            m_axil_awvalid <= 1'b0;
            m_axil_wvalid  <= 1'b0;
            word           <= 6'd0;
            slot           <= 7'd0;
            pause          <= 6'd0;
        end
    end

endmodule

`default_nettype wire
