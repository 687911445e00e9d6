// SPDX-License-Identifier: Apache-2.0
// First-in first-out queue, first word falls through.
//
// Latency:    1 clock from s_ to m_ when empty, 4 with BLOCK = 1.
// Throughput: 1 word per clock; with DEPTH = 1, one word in two clocks, since a full queue accepts nothing until the clock after a
//             word has left; with BLOCK = 1 and DEPTH below 4, DEPTH words in four clocks.
// Stall:      s_ready is low while DEPTH words are held; with BLOCK = 1 there is one more in the output register.
// Reset:      becomes empty. The memory is not reset.
// Combinational paths: none from port to port. m_data is a memory read, with BLOCK = 1 a register.
`default_nettype none

module fifo #(
    // bits of a word, at least 1
    parameter W = 8,
    // words held, at least 1, any number
    parameter DEPTH = 16,
    // 1: for block RAM, which is slow: a register stands before it, two behind it, and no word is read in the clock of its writing
    parameter BLOCK = 0
) (
    input  wire                       clk,
    input  wire                       rst,

    input  wire                       s_valid,
    output wire                       s_ready,
    input  wire [W-1:0]               s_data,

    output wire                       m_valid,
    input  wire                       m_ready,
    output wire [W-1:0]               m_data,

    // words held, 0..DEPTH, without the one in the register
    output wire [$clog2(DEPTH+1)-1:0] level
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();
    parameter_check #(.OK(DEPTH >= 1)) DEPTH_must_be_at_least_1 ();
    parameter_check #(.OK(BLOCK == 0 || BLOCK == 1)) BLOCK_must_be_0_or_1 ();

    localparam ADDR_W = (DEPTH > 1) ? $clog2(DEPTH) : 1;
    localparam LEVEL_W = $clog2(DEPTH + 1);
    localparam [31:0] LAST = DEPTH - 1;

    reg [ADDR_W-1:0] write_reg, read_reg;
    reg [LEVEL_W-1:0] level_reg;
    reg full_reg;

    wire push = s_valid && s_ready;
    wire pop;
    wire read;  // the read address goes on

    assign s_ready = !full_reg;
    assign level = level_reg;

    generate
        if (BLOCK != 0) begin : g_block
            // The oldest word is read out of the memory as soon as there is room behind it, and occupies its entry until it leaves
            // the first register.
            reg  ram_valid, m_valid_reg;
            reg  settling;  // the newest word is on its way into the memory
            reg  [ADDR_W-1:0] to_reg;
            reg  [W-1:0] data_reg;
            wire unread = {1'b0, level_reg} != {{(LEVEL_W - 1) {1'b0}}, ram_valid && settling, ram_valid ^ settling};
            wire moves = m_ready || !m_valid_reg;
            wire reads = moves || !ram_valid;

            assign read = unread && reads;
            assign pop = ram_valid && moves;
            assign m_valid = m_valid_reg;

            block_memory #(
                .W    (W),
                .DEPTH(DEPTH)
            ) u_memory (
                .clk          (clk),
                .write        (settling),
                .write_address(to_reg),
                .write_data   (data_reg),
                .read_enable  (reads),
                .read_address (read_reg),
                .out_enable   (moves),
                .read_data    (m_data)
            );

            always @(posedge clk) begin
                settling <= push;
                to_reg <= write_reg;
                data_reg <= s_data;
                if (reads) ram_valid <= unread;
                if (moves) m_valid_reg <= ram_valid;
                if (rst) {settling, ram_valid, m_valid_reg} <= 3'b000;
            end
        end else begin : g_through
            reg [W-1:0] memory [0:DEPTH-1];

            assign read = pop;
            assign pop = m_valid && m_ready;
            assign m_valid = level_reg != {LEVEL_W{1'b0}};
            assign m_data = memory[read_reg];

            always @(posedge clk) if (push) memory[write_reg] <= s_data;
        end
    endgenerate

    always @(posedge clk) begin
        if (push) write_reg <= (write_reg == LAST[ADDR_W-1:0]) ? {ADDR_W{1'b0}} : write_reg + 1'b1;
        if (read) read_reg <= (read_reg == LAST[ADDR_W-1:0]) ? {ADDR_W{1'b0}} : read_reg + 1'b1;
        if (push != pop) begin
            level_reg <= level_reg + (pop ? {LEVEL_W{1'b1}} : {{(LEVEL_W - 1) {1'b0}}, 1'b1});
            full_reg <= push && level_reg == LAST[LEVEL_W-1:0];
        end
        if (rst) begin
            write_reg <= {ADDR_W{1'b0}};
            read_reg <= {ADDR_W{1'b0}};
            level_reg <= {LEVEL_W{1'b0}};
            full_reg <= 1'b0;
        end
    end

endmodule

`default_nettype wire
