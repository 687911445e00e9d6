// SPDX-License-Identifier: Apache-2.0
// The published library's output line: merges N active-low 4-phase senders onto one bus (docs/published.md).
//
// A sender's rank is its number, 0 the highest. The choice is made anew at every clock up to that of the receiver's acknowledge,
// which goes to the sender chosen in that very clock: a word may be replaced as it is acknowledged, and is sent again later.
// Senders must hold request and word until acknowledged. The word is all ones while the line is idle.
//
// Latency:    2 clocks from a request to the word, 4 to the sender's acknowledge if the receiver acknowledges at once.
// Throughput: a word in 6 clocks.
// Stall:      the next word waits until the sender has released its request and the receiver its acknowledge.
// Reset:      no request, no acknowledge, the word of an idle line.
// Combinational paths: none; all outputs are registers.
`default_nettype none

module published_line #(
    parameter N       = 8,                          // senders
    parameter W       = 25,                         // bits of a word
    parameter INDEX_W = (N > 1) ? $clog2(N) : 1     // derived: leave it alone
) (
    input  wire           clk,
    input  wire           rst,

    input  wire [N-1:0]   s_req_n,
    output reg  [N-1:0]   s_ack_n,
    input  wire [N*W-1:0] s_word,

    output reg            m_req_n,
    input  wire           m_ack_n,
    output reg  [W-1:0]   m_word
);

    parameter_check #(.OK(N >= 1 && N <= 64)) N_must_be_1_to_64 ();
    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();
    parameter_check #(.OK(INDEX_W == ((N > 1) ? $clog2(N) : 1))) INDEX_W_must_be_left_at_its_default ();

    localparam [1:0] IDLE        = 2'd0;
    localparam [1:0] CONNECT     = 2'd1;
    localparam [1:0] ACKNOWLEDGE = 2'd2;

    reg [1:0]         state;
    reg [INDEX_W-1:0] owner;  // the sender whose word is on the line

    reg [INDEX_W-1:0] first;
    integer i;
    always @* begin
        first = {INDEX_W{1'b0}};
        for (i = N - 1; i >= 0; i = i - 1) if (!s_req_n[i]) first = i[INDEX_W-1:0];
    end

    wire none = &s_req_n;

    always @(posedge clk) begin
        s_ack_n <= {N{1'b1}};

        case (state)
            // Waits for a request.
            IDLE: begin
                m_word <= {W{1'b1}};
                if (!none) state <= CONNECT;
            end

            // Sends the word of the highest rank, up to the clock of the acknowledge.
            CONNECT: begin
                m_req_n <= none;
                if (!none) begin
                    m_word <= s_word[first*W +: W];
                    owner  <= first;
                end
                if (!m_ack_n) state <= ACKNOWLEDGE;
            end

            // Acknowledges the sender chosen last until both lines are released.
            ACKNOWLEDGE: begin
                m_req_n <= 1'b1;
                s_ack_n <= ~({{(N - 1) {1'b0}}, 1'b1} << owner);
                if (s_req_n[owner] && m_ack_n) state <= IDLE;
            end

            default: state <= IDLE;
        endcase

        if (rst) begin
            state   <= IDLE;
            owner   <= {INDEX_W{1'b0}};
            m_req_n <= 1'b1;
            m_word  <= {W{1'b1}};
            s_ack_n <= {N{1'b1}};
        end
    end

endmodule

`default_nettype wire
