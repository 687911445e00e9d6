// SPDX-License-Identifier: Apache-2.0
// Skid buffer: cuts every path between two ready/valid ports without losing throughput.
//
// Latency:    1 clock from s_ to m_.
// Throughput: 1 word per clock.
// Stall:      a word that arrives in the clock in which the output stalls is stored in a second register; then s_ready falls.
// Reset:      becomes empty; s_ready rises one clock after reset. Payload is not reset.
// Combinational paths: none; s_ready, m_valid and m_data are registers.
`default_nettype none

module skid_buffer #(
    // bits of a word, at least 1
    parameter W = 8
) (
    input  wire         clk,
    input  wire         rst,

    input  wire         s_valid,
    output wire         s_ready,
    input  wire [W-1:0] s_data,

    output wire         m_valid,
    input  wire         m_ready,
    output wire [W-1:0] m_data
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();

    reg s_ready_reg, m_valid_reg, skid_valid_reg;
    reg [W-1:0] m_data_reg, skid_data_reg;

    wire accept = s_valid && s_ready_reg;
    wire output_free = m_ready || !m_valid_reg;
    wire skid_valid_next = !output_free && (skid_valid_reg || accept);

    assign s_ready = s_ready_reg;
    assign m_valid = m_valid_reg;
    assign m_data = m_data_reg;

    always @(posedge clk) begin
        s_ready_reg <= !skid_valid_next;
        skid_valid_reg <= skid_valid_next;
        if (s_ready_reg) skid_data_reg <= s_data;
        if (output_free) begin
            m_valid_reg <= skid_valid_reg || accept;
            m_data_reg <= skid_valid_reg ? skid_data_reg : s_data;
        end
        if (rst) begin
            s_ready_reg <= 1'b0;
            m_valid_reg <= 1'b0;
            skid_valid_reg <= 1'b0;
        end
    end

endmodule

`default_nettype wire
