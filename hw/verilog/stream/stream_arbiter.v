// SPDX-License-Identifier: Apache-2.0
// Merges N streams into one, round robin: after stream i, the next waiting one above i goes first.
//
// Latency:    1 clock from s_ to m_.
// Throughput: 1 word per clock. A stream that waits is served after at most N - 1 words of others.
// Stall:      the output word is held until accepted. Nothing is lost or repeated, and each stream keeps its order.
// Reset:      becomes empty, stream 0 first. Payload is not reset.
// Combinational paths: m_ready, s_valid -> s_ready. A skid_buffer behind m_ or before s_ cuts them.
`default_nettype none

module stream_arbiter #(
    // streams, at least 1
    parameter N = 2,
    // bits of a word, at least 1
    parameter W = 8
) (
    input  wire           clk,
    input  wire           rst,

    // stream i: s_valid[i], s_ready[i], s_data[i*W +: W]
    input  wire [N-1:0]   s_valid,
    output wire [N-1:0]   s_ready,
    input  wire [N*W-1:0] s_data,

    output wire           m_valid,
    input  wire           m_ready,
    output wire [W-1:0]   m_data
);

    parameter_check #(.OK(N >= 1)) N_must_be_at_least_1 ();
    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();

    reg m_valid_reg;
    reg [W-1:0] m_data_reg;
    // The streams above the one served last: they go first.
    reg [N-1:0] above_reg;

    wire output_free = m_ready || !m_valid_reg;
    wire [N-1:0] favoured = s_valid & above_reg;
    wire [N-1:0] candidates = (favoured != {N{1'b0}}) ? favoured : s_valid;
    // Lowest set bit, and everything above it.
    wire [N-1:0] grant = candidates & (~candidates + 1'b1);
    wire [N-1:0] above_next = ~(grant | (grant - 1'b1));

    reg [W-1:0] granted_data;
    integer i;
    always @* begin
        granted_data = {W{1'b0}};
        for (i = 0; i < N; i = i + 1) granted_data = granted_data | (s_data[i*W +: W] & {W{grant[i]}});
    end

    assign s_ready = output_free ? grant : {N{1'b0}};
    assign m_valid = m_valid_reg;
    assign m_data = m_data_reg;

    always @(posedge clk) begin
        if (output_free) begin
            m_valid_reg <= |s_valid;
            m_data_reg <= granted_data;
            if (|s_valid) above_reg <= above_next;
        end
        if (rst) begin
            m_valid_reg <= 1'b0;
            above_reg <= {N{1'b0}};
        end
    end

endmodule

`default_nettype wire
