// SPDX-License-Identifier: Apache-2.0
// AXI4-Lite slave: converts the five channels into one access at a time, which the module with the registers answers.
//
// Address and data of a write may arrive in any order. Waiting reads and writes alternate: after an access, the next address of the
// same kind is accepted a clock later. An access is held on request_* until the clock in which `answer` is high; answer_data (of a
// read) and answer_error (SLVERR) are sampled in that clock.
//
// Latency:    1 clock from the last of an access's handshakes to request_valid, 1 from `answer` to the response.
// Throughput: an access in 2 clocks plus the time until the answer.
// Stall:      a response that is not accepted delays the next access of its kind only.
// Reset:      no access, no response.
// Combinational paths: none from AXI to AXI; the outputs to AXI are registers, or the inverse of one.
`default_nettype none
`include "evcot_regs.vh"

module axi_lite_slave #(
    // bits of a byte address, at least 3; the two low ones are ignored
    parameter ADDR_W = `EVCOT_CSR_ADDR_W
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              s_axil_awvalid,
    output wire              s_axil_awready,
    input  wire [ADDR_W-1:0] s_axil_awaddr,
    input  wire [2:0]        s_axil_awprot,
    input  wire              s_axil_wvalid,
    output wire              s_axil_wready,
    input  wire [31:0]       s_axil_wdata,
    input  wire [3:0]        s_axil_wstrb,
    output reg               s_axil_bvalid,
    input  wire              s_axil_bready,
    output reg  [1:0]        s_axil_bresp,
    input  wire              s_axil_arvalid,
    output wire              s_axil_arready,
    input  wire [ADDR_W-1:0] s_axil_araddr,
    input  wire [2:0]        s_axil_arprot,
    output reg               s_axil_rvalid,
    input  wire              s_axil_rready,
    output reg  [31:0]       s_axil_rdata,
    output reg  [1:0]        s_axil_rresp,

    output reg               request_valid,
    output reg               request_write,
    output reg  [ADDR_W-3:0] request_word,   // the address without its two low bits
    output wire [31:0]       request_data,
    output wire [3:0]        request_strb,
    input  wire              answer,
    input  wire [31:0]       answer_data,
    input  wire              answer_error
);

    parameter_check #(.OK(ADDR_W >= 3)) ADDR_W_must_be_at_least_3 ();

    localparam [1:0] OKAY   = 2'b00;
    localparam [1:0] SLVERR = 2'b10;

    reg              aw_held, w_held, ar_held;
    reg [ADDR_W-3:0] aw_word, ar_word;
    reg [31:0]       data;
    reg [3:0]        strb;

    wire can_write  = aw_held && w_held && (s_axil_bready || !s_axil_bvalid);
    wire can_read   = ar_held && (s_axil_rready || !s_axil_rvalid);
    wire begins     = !request_valid && (can_read || can_write);

    assign s_axil_awready = !aw_held;
    assign s_axil_wready  = !w_held;
    assign s_axil_arready = !ar_held;
    assign request_data   = data;
    assign request_strb   = strb;

    always @(posedge clk) begin
        if (s_axil_bready) s_axil_bvalid <= 1'b0;
        if (s_axil_rready) s_axil_rvalid <= 1'b0;

        if (s_axil_awvalid && !aw_held) begin
            aw_held <= 1'b1;
            aw_word <= s_axil_awaddr[ADDR_W-1:2];
        end
        if (s_axil_wvalid && !w_held) begin
            w_held <= 1'b1;
            data   <= s_axil_wdata;
            strb   <= s_axil_wstrb;
        end
        if (s_axil_arvalid && !ar_held) begin
            ar_held <= 1'b1;
            ar_word <= s_axil_araddr[ADDR_W-1:2];
        end

        if (begins) begin
            request_valid <= 1'b1;
            request_write <= !can_read;
            request_word  <= can_read ? ar_word : aw_word;
        end
        if (request_valid && answer) begin
            request_valid <= 1'b0;
            if (request_write) begin
                aw_held       <= 1'b0;
                w_held        <= 1'b0;
                s_axil_bvalid <= 1'b1;
                s_axil_bresp  <= answer_error ? SLVERR : OKAY;
            end else begin
                ar_held       <= 1'b0;
                s_axil_rvalid <= 1'b1;
                s_axil_rdata  <= answer_data;
                s_axil_rresp  <= answer_error ? SLVERR : OKAY;
            end
        end

        if (rst) begin
            {aw_held, w_held, ar_held} <= 3'd0;
            {s_axil_bvalid, s_axil_rvalid, request_valid} <= 3'd0;
        end
    end

    wire unused = &{1'b0, s_axil_awaddr[1:0], s_axil_araddr[1:0], s_axil_awprot, s_axil_arprot};

endmodule

`default_nettype wire
