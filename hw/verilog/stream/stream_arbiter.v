// SPDX-License-Identifier: Apache-2.0
// Merges N streams into one, round robin: after stream i, the next waiting one above i goes first.
//
// Every stream has a register in front, and whose turn it is next is decided a clock ahead, so that no long path begins or ends here.
//
// Latency:    2 clocks from s_ to m_.
// Throughput: 1 word per clock from two streams or more, every 2 clocks from each. A stream that waits is served after at most N - 1
//             words of others.
// Stall:      the output word is held until accepted. Nothing is lost or repeated, and each stream keeps its order.
// Reset:      becomes empty, stream 0 first. Payload is not reset.
// Combinational paths: none; s_ready, m_valid and m_data are registers.
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

    reg [N-1:0] s_ready_reg;
    reg [N*W-1:0] waiting_data_reg;
    // Whose turn it is: a stream that waits, or none.
    reg [N-1:0] turn_reg;
    // The streams above the last one that had a turn: they go first.
    reg [N-1:0] above_reg;
    reg m_valid_reg;
    reg [W-1:0] m_data_reg;

    wire output_free = m_ready || !m_valid_reg;
    wire [N-1:0] waiting = (s_valid | ~s_ready_reg) & ~turn_reg;
    // The next turn goes to the stream that waits and that no other one is ahead of: those above the last turn come first, each group
    // from its lowest on.
    reg [N-1:0] turn_next, above_next;
    integer i, j;
    always @* begin
        turn_next = waiting;
        for (i = 0; i < N; i = i + 1) begin
            for (j = 0; j < N; j = j + 1) begin
                if (waiting[j] && ((j < i) ? above_reg[j] || !above_reg[i] : j > i && above_reg[j] && !above_reg[i])) turn_next[i] = 1'b0;
            end
        end
        above_next[0] = 1'b0;
        for (i = 1; i < N; i = i + 1) above_next[i] = above_next[i-1] || turn_next[i-1];
    end

    reg [W-1:0] data;
    integer from;
    always @* begin
        data = {W{1'b0}};
        for (from = 0; from < N; from = from + 1) data = data | (waiting_data_reg[from*W +: W] & {W{turn_reg[from]}});
    end

    assign s_ready = s_ready_reg;
    assign m_valid = m_valid_reg;
    assign m_data = m_data_reg;

    integer stream;
    always @(posedge clk) begin
        for (stream = 0; stream < N; stream = stream + 1) begin
            if (s_valid[stream] && s_ready_reg[stream]) waiting_data_reg[stream*W +: W] <= s_data[stream*W +: W];
        end
        s_ready_reg <= (s_ready_reg & ~s_valid) | (turn_reg & {N{output_free}});
        if (output_free) begin
            m_valid_reg <= |turn_reg;
            m_data_reg <= data;
        end
        if (output_free || turn_reg == {N{1'b0}}) begin
            turn_reg <= turn_next;
            if (waiting != {N{1'b0}}) above_reg <= above_next;
        end
        if (rst) begin
            s_ready_reg <= {N{1'b1}};
            m_valid_reg <= 1'b0;
            turn_reg <= {N{1'b0}};
            above_reg <= {N{1'b0}};
        end
    end

endmodule

`default_nettype wire
