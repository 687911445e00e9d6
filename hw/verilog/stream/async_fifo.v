// SPDX-License-Identifier: Apache-2.0
// First-in first-out queue between two clocks, for example of a camera and of the trackers.
//
// Each side has a pointer in Gray code, of which one bit changes at a time, and sees that of the other side through flip-flops. A
// word is in the memory before the pointer that tells of it has been seen. Constraints: hw/fpga/constraints/async_fifo.xdc, .sdc.
//
// Latency:    1 clock of s_clk, then STAGES + 2 of m_clk, one more where the edges are close.
// Throughput: 1 word per clock of the slower side, with DEPTH_W at least 4.
// Stall:      s_ready is low while 2^DEPTH_W words are held, or seem to be: a word that has left is seen STAGES + 1 clocks later.
// Reset:      becomes empty. Reset both sides together, so that both are in reset for STAGES + 1 clocks of the slower one.
// Combinational paths: none; s_ready, m_valid and m_data are registers, s_ready an inverted one.
`default_nettype none

module async_fifo #(
    parameter W       = 64,  // bits of a word, at least 1
    parameter DEPTH_W = 4,   // log2 of the words held, 2..16
    parameter STAGES  = 2    // flip-flops that a pointer passes, 2..4
) (
    input  wire         s_clk,
    input  wire         s_rst,
    input  wire         s_valid,
    output wire         s_ready,
    input  wire [W-1:0] s_data,

    input  wire         m_clk,
    input  wire         m_rst,
    output wire         m_valid,
    input  wire         m_ready,
    output wire [W-1:0] m_data
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();
    parameter_check #(.OK(DEPTH_W >= 2 && DEPTH_W <= 16)) DEPTH_W_must_be_2_to_16 ();

    localparam [DEPTH_W:0] ZERO = {(DEPTH_W + 1) {1'b0}};

    reg  [W-1:0]     memory [0:(1<<DEPTH_W)-1];
    reg  [DEPTH_W:0] write_at, write_gray, read_at, read_gray;
    wire [DEPTH_W:0] read_seen, write_seen;  // by the other side

    genvar i;
    generate
        for (i = 0; i <= DEPTH_W; i = i + 1) begin : g_pointers
            synchronizer #(.STAGES(STAGES)) u_write (.clk(m_clk), .rst(m_rst), .d(write_gray[i]), .q(write_seen[i]));
            synchronizer #(.STAGES(STAGES)) u_read (.clk(s_clk), .rst(s_rst), .d(read_gray[i]), .q(read_seen[i]));
        end
    endgenerate

    // ---- s_clk -------------------------------------------------------------------------------------------------------

    reg              full;
    wire             push       = s_valid && !full;
    wire [DEPTH_W:0] write_next = write_at + {{DEPTH_W{1'b0}}, push};
    wire [DEPTH_W:0] write_code = write_next ^ (write_next >> 1);

    assign s_ready = !full;

    always @(posedge s_clk) begin
        if (push) memory[write_at[DEPTH_W-1:0]] <= s_data;
        write_at   <= write_next;
        write_gray <= write_code;
        full       <= write_code == {~read_seen[DEPTH_W:DEPTH_W-1], read_seen[DEPTH_W-2:0]};
        if (s_rst) begin
            write_at   <= ZERO;
            write_gray <= ZERO;
            full       <= 1'b1;
        end
    end

    // ---- m_clk -------------------------------------------------------------------------------------------------------

    reg              empty, valid_reg;
    reg  [W-1:0]     data_reg;
    wire             moves     = m_ready || !valid_reg;
    wire             pop       = moves && !empty;
    wire [DEPTH_W:0] read_next = read_at + {{DEPTH_W{1'b0}}, pop};
    wire [DEPTH_W:0] read_code = read_next ^ (read_next >> 1);

    assign m_valid = valid_reg;
    assign m_data  = data_reg;

    always @(posedge m_clk) begin
        if (moves) begin
            valid_reg <= !empty;
            data_reg  <= memory[read_at[DEPTH_W-1:0]];
        end
        read_at   <= read_next;
        read_gray <= read_code;
        empty     <= read_code == write_seen;
        if (m_rst) begin
            read_at   <= ZERO;
            read_gray <= ZERO;
            empty     <= 1'b1;
            valid_reg <= 1'b0;
        end
    end

endmodule

`default_nettype wire
