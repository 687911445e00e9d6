// SPDX-License-Identifier: Apache-2.0
// First-in first-out queue, first word falls through.
//
// Latency:    1 clock from s_ to m_ when empty.
// Throughput: 1 word per clock; with DEPTH = 1, one word in two clocks, since a full queue takes nothing until the
//             clock after it gave a word.
// Stall:      s_ready is low while DEPTH words are held.
// Reset:      becomes empty. The memory is not reset.
// Combinational paths: none from port to port; m_data is a memory read, to be cut by a skid_buffer where that is slow.
`default_nettype none

module fifo #(
    // bits of a word, at least 1
    parameter W = 8,
    // words held, at least 1, any number
    parameter DEPTH = 16
) (
    input  wire                       clk,
    input  wire                       rst,

    input  wire                       s_valid,
    output wire                       s_ready,
    input  wire [W-1:0]               s_data,

    output wire                       m_valid,
    input  wire                       m_ready,
    output wire [W-1:0]               m_data,

    // words held, 0..DEPTH
    output wire [$clog2(DEPTH+1)-1:0] level
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();
    parameter_check #(.OK(DEPTH >= 1)) DEPTH_must_be_at_least_1 ();

    localparam ADDR_W = (DEPTH > 1) ? $clog2(DEPTH) : 1;
    localparam LEVEL_W = $clog2(DEPTH + 1);
    localparam [31:0] LAST = DEPTH - 1;
    localparam [31:0] FULL = DEPTH;

    reg [W-1:0] memory [0:DEPTH-1];
    reg [ADDR_W-1:0] write_reg, read_reg;
    reg [LEVEL_W-1:0] level_reg;

    wire push = s_valid && s_ready;
    wire pop = m_valid && m_ready;

    assign s_ready = level_reg != FULL[LEVEL_W-1:0];
    assign m_valid = level_reg != {LEVEL_W{1'b0}};
    assign m_data = memory[read_reg];
    assign level = level_reg;

    always @(posedge clk) begin
        if (push) begin
            memory[write_reg] <= s_data;
            write_reg <= (write_reg == LAST[ADDR_W-1:0]) ? {ADDR_W{1'b0}} : write_reg + 1'b1;
        end
        if (pop) read_reg <= (read_reg == LAST[ADDR_W-1:0]) ? {ADDR_W{1'b0}} : read_reg + 1'b1;
        if (push && !pop) level_reg <= level_reg + 1'b1;
        if (pop && !push) level_reg <= level_reg - 1'b1;
        if (rst) begin
            write_reg <= {ADDR_W{1'b0}};
            read_reg <= {ADDR_W{1'b0}};
            level_reg <= {LEVEL_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
