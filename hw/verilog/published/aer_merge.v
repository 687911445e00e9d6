// SPDX-License-Identifier: Apache-2.0
// Merges N active-low 4-phase senders onto one bus.
//
// The lowest-numbered sender with a request goes first; a word that is being sent is never withdrawn. A word passes without
// delay when the bus is free, that is, after the receiver has de-asserted its acknowledge of the previous word: a receiver
// that ties its acknowledge low gets one word only. Senders must hold request and word until acknowledged.
//
// Latency:    none, by wire; a clock between two words.
// Throughput: a word per handshake.
// Stall:      a sender waits for its acknowledge.
// Reset:      no sender holds the bus.
// Combinational paths: s_req_n, s_word, m_ack_n -> s_ack_n, m_req_n, m_word.
`default_nettype none

module aer_merge #(
    parameter N       = 4,                          // senders
    parameter W       = 25,                         // bits of a word
    parameter INDEX_W = (N > 1) ? $clog2(N) : 1     // derived: leave it alone
) (
    input  wire           clk,
    input  wire           rst,

    input  wire [N-1:0]   s_req_n,
    output wire [N-1:0]   s_ack_n,
    input  wire [N*W-1:0] s_word,

    output wire           m_req_n,
    input  wire           m_ack_n,
    output wire [W-1:0]   m_word
);

    parameter_check #(.OK(N >= 1 && N <= 64)) N_must_be_1_to_64 ();
    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();
    parameter_check #(.OK(INDEX_W == ((N > 1) ? $clog2(N) : 1))) INDEX_W_must_be_left_at_its_default ();

    reg               busy;   // the line carries a word of `owner`
    reg [INDEX_W-1:0] owner;
    reg               free;   // the acknowledge of the word before was released

    reg [INDEX_W-1:0] first;
    integer i;
    always @* begin
        first = {INDEX_W{1'b0}};
        for (i = N - 1; i >= 0; i = i - 1) if (!s_req_n[i]) first = i[INDEX_W-1:0];
    end

    wire [INDEX_W-1:0] granted = busy ? owner : first;

    assign m_req_n = busy ? s_req_n[owner] : !free || (&s_req_n);
    assign m_word  = s_word[granted*W +: W];
    assign s_ack_n = ~(({{(N - 1) {1'b0}}, 1'b1} << granted) & {N{!m_req_n && !m_ack_n}});

    always @(posedge clk) begin
        busy  <= !m_req_n;
        owner <= granted;
        free  <= m_req_n && (free || m_ack_n);
        if (rst) begin
            busy <= 1'b0;
            free <= 1'b1;
        end
    end

endmodule

`default_nettype wire
