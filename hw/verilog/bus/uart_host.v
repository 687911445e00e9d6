// SPDX-License-Identifier: Apache-2.0
// Interface to a host on a serial line: the host reads and writes registers over AXI4-Lite, and records are sent to it.
//
// A request has 7 bytes: 'R' or 'W'; the address, 2 bytes; the data, 4 bytes (ignored for a read); lowest byte first.
// Any other first byte is ignored, and so is a request in which no byte arrives for TIMEOUT bits. The host must wait for the answer
// before the next request.
//
// Frames to the host: an answer is 'r' or 'w', the response of AXI (0: OKAY), 4 bytes of data; a record is 'c' and its
// bytes in the order of the beats of s_axis. Each ends with a checksum, the sum of all its bytes modulo 256. An answer waits for the
// record that is being sent, but for no further one.
//
// Stall:      while the line is busy s_axis_tready is low.
// Reset:      idle; a byte that is being sent is truncated.
// Latency:    an answer begins with the end of the bus access, or of the record that is being sent.
// Throughput: a byte per 10 bits.
// Combinational paths: none.
`default_nettype none
`include "evcot_regs.vh"

module uart_host #(
    parameter DIVISOR = 12,   // clocks per bit of the line: see uart_rx.v
    parameter TIMEOUT = 320,  // bits of silence that end a request which is not whole, at least 20
    parameter ADDR_W  = `EVCOT_CSR_ADDR_W  // bits of an address, 1 to 16
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              rx,
    output wire              tx,

    output reg               m_axil_awvalid,
    input  wire              m_axil_awready,
    output wire [ADDR_W-1:0] m_axil_awaddr,
    output reg               m_axil_wvalid,
    input  wire              m_axil_wready,
    output wire [31:0]       m_axil_wdata,
    input  wire              m_axil_bvalid,
    output wire              m_axil_bready,
    input  wire [1:0]        m_axil_bresp,
    output reg               m_axil_arvalid,
    input  wire              m_axil_arready,
    output wire [ADDR_W-1:0] m_axil_araddr,
    input  wire              m_axil_rvalid,
    output wire              m_axil_rready,
    input  wire [31:0]       m_axil_rdata,
    input  wire [1:0]        m_axil_rresp,

    // records, 32 bits a beat
    input  wire              s_axis_tvalid,
    output wire              s_axis_tready,
    input  wire [31:0]       s_axis_tdata,
    input  wire [3:0]        s_axis_tkeep,
    input  wire              s_axis_tlast
);

    parameter_check #(.OK(TIMEOUT >= 20)) TIMEOUT_must_be_at_least_20 ();
    parameter_check #(.OK(ADDR_W >= 1 && ADDR_W <= 16)) ADDR_W_must_be_1_to_16 ();

    localparam [7:0] READ = "R", WRITE = "W", READ_DONE = "r", WRITE_DONE = "w", RECORD = "c";

    // ---- requests ----------------------------------------------------------------------------------------------------

    localparam        WAIT_W = $clog2(TIMEOUT * DIVISOR);
    localparam [31:0] WAIT   = TIMEOUT * DIVISOR - 1;

    wire       byte_valid;
    wire [7:0] byte_data;

    uart_rx #(
        .DIVISOR(DIVISOR)
    ) u_rx (
        .clk    (clk),
        .rst    (rst),
        .rx     (rx),
        .m_valid(byte_valid),
        .m_data (byte_data)
    );

    reg [55:0]       request;  // the first byte lowest, when all are there
    reg [2:0]        have;
    reg [WAIT_W-1:0] silence;
    reg              asked;    // a request is whole, and its answer not yet handed over
    wire             writes = request[7:0] == WRITE;
    wire             known  = byte_data == READ || byte_data == WRITE;
    wire             answered;

    assign m_axil_awaddr = request[8+:ADDR_W];
    assign m_axil_araddr = request[8+:ADDR_W];
    assign m_axil_wdata  = request[55:24];

    always @(posedge clk) begin
        silence <= silence - 1'b1;
        if (have != 3'd0 && silence == {WAIT_W{1'b0}}) have <= 3'd0;
        if (byte_valid && !asked && (have != 3'd0 || known)) begin
            request <= {byte_data, request[55:8]};
            silence <= WAIT[WAIT_W-1:0];
            have    <= (have == 3'd6) ? 3'd0 : have + 3'd1;
            asked   <= have == 3'd6;
        end
        if (answered) asked <= 1'b0;
        if (rst) begin
            have  <= 3'd0;
            asked <= 1'b0;
        end
    end

    // ---- the bus -----------------------------------------------------------------------------------------------------

    reg        begun, done;  // the access; done: its answer is in `answer`
    reg [33:0] answer;       // response, data

    assign m_axil_bready = begun && writes && !done;
    assign m_axil_rready = begun && !writes && !done;

    always @(posedge clk) begin
        if (m_axil_awready) m_axil_awvalid <= 1'b0;
        if (m_axil_wready)  m_axil_wvalid  <= 1'b0;
        if (m_axil_arready) m_axil_arvalid <= 1'b0;
        if (asked && !begun) begin
            begun          <= 1'b1;
            m_axil_awvalid <= writes;
            m_axil_wvalid  <= writes;
            m_axil_arvalid <= !writes;
        end
        if (m_axil_bvalid && m_axil_bready) begin
            done   <= 1'b1;
            answer <= {m_axil_bresp, 32'd0};
        end
        if (m_axil_rvalid && m_axil_rready) begin
            done   <= 1'b1;
            answer <= {m_axil_rresp, m_axil_rdata};
        end
        if (answered) begin
            begun <= 1'b0;
            done  <= 1'b0;
        end
        if (rst) begin
            begun          <= 1'b0;
            done           <= 1'b0;
            m_axil_awvalid <= 1'b0;
            m_axil_wvalid  <= 1'b0;
            m_axil_arvalid <= 1'b0;
        end
    end

    // ---- frames ------------------------------------------------------------------------------------------------------

    localparam [1:0] F_IDLE = 2'd0, F_ANSWER = 2'd1, F_RECORD = 2'd2, F_SUM = 2'd3;

    reg [1:0]  frame;
    reg [39:0] bytes;      // of the answer or the beat, the next one lowest
    reg [4:0]  there;      // which of them there are
    reg        last;       // no beat follows
    reg [7:0]  sum;

    wire       starts   = frame == F_IDLE;
    wire       empty    = there == 5'd0;
    wire       ends     = empty && (frame == F_ANSWER || (frame == F_RECORD && last));
    wire       tx_ready;
    wire       sends    = (starts && (done || s_axis_tvalid)) || frame == F_SUM || (!starts && !empty);
    wire [7:0] tx_data  = starts ? (done ? (writes ? WRITE_DONE : READ_DONE) : RECORD) : frame == F_SUM ? sum : bytes[7:0];
    wire       sent     = sends && tx_ready;

    assign s_axis_tready = frame == F_RECORD && empty && !last;
    assign answered      = starts && done && tx_ready;

    always @(posedge clk) begin
        if (sent) begin
            sum   <= starts ? tx_data : sum + tx_data;
            bytes <= bytes >> 8;
            there <= there >> 1;
        end
        if (starts && sent) begin
            frame <= done ? F_ANSWER : F_RECORD;
            bytes <= {answer[31:0], 6'd0, answer[33:32]};
            there <= done ? 5'b11111 : 5'd0;
            last  <= done;
        end
        if (s_axis_tvalid && s_axis_tready) begin
            bytes <= {8'd0, s_axis_tdata};
            there <= {1'b0, s_axis_tkeep};
            last  <= s_axis_tlast;
        end
        if (ends) frame <= F_SUM;
        if (frame == F_SUM && sent) frame <= F_IDLE;
        if (rst) frame <= F_IDLE;
    end

    uart_tx #(
        .DIVISOR(DIVISOR)
    ) u_tx (
        .clk    (clk),
        .rst    (rst),
        .s_valid(sends),
        .s_ready(tx_ready),
        .s_data (tx_data),
        .tx     (tx)
    );

endmodule

`default_nettype wire
