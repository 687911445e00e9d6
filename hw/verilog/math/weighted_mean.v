// SPDX-License-Identifier: Apache-2.0
// The mean of two values, each with a weight: (a * weight_a + b * weight_b) / (weight_a + weight_b).
//
// Rounded to nearest, halves up, when ROUND is 1; else down. It lies between a and b, so it has their width. The sum of the
// weights must not be zero.
//
// Latency:    W + WEIGHT_W + 2 clocks from the operands taken to m_valid.
// Throughput: one mean in W + WEIGHT_W + 3 clocks.
// Stall:      the result stays until taken; s_ready is low from the operands taken until then.
// Reset:      drops a division under way and becomes ready.
// Combinational paths: none from port to port; the products are formed in the clock that takes the operands.
`default_nettype none

module weighted_mean #(
    parameter W        = 13,  // bits of a value, at least 1
    parameter WEIGHT_W = 16,  // bits of a weight, at least 1
    parameter ROUND    = 1    // 1: to nearest; 0: down
) (
    input  wire                clk,
    input  wire                rst,

    input  wire                s_valid,
    output wire                s_ready,
    input  wire [W-1:0]        s_a,
    input  wire [WEIGHT_W-1:0] s_weight_a,
    input  wire [W-1:0]        s_b,
    input  wire [WEIGHT_W-1:0] s_weight_b,

    output wire                m_valid,
    input  wire                m_ready,
    output wire [W-1:0]        m_mean
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();
    parameter_check #(.OK(WEIGHT_W >= 1)) WEIGHT_W_must_be_at_least_1 ();
    parameter_check #(.OK(ROUND == 0 || ROUND == 1)) ROUND_must_be_0_or_1 ();

    localparam DEN_W = WEIGHT_W + 1;
    localparam NUM_W = W + WEIGHT_W + 1;

    wire [DEN_W-1:0] den  = {1'b0, s_weight_a} + {1'b0, s_weight_b};
    wire [DEN_W-1:0] half = ROUND ? den >> 1 : {DEN_W{1'b0}};
    wire [NUM_W-1:0] num  = {{DEN_W{1'b0}}, s_a} * {{(W + 1) {1'b0}}, s_weight_a}
                          + {{DEN_W{1'b0}}, s_b} * {{(W + 1) {1'b0}}, s_weight_b}
                          + {{W{1'b0}}, half};

    wire [NUM_W-1:0] quot;
    wire [DEN_W-1:0] rem;

    divider #(
        .NUM_W(NUM_W),
        .DEN_W(DEN_W)
    ) u_divider (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_valid),
        .s_ready(s_ready),
        .s_num  (num),
        .s_den  (den),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_quot (quot),
        .m_rem  (rem)
    );

    assign m_mean = quot[W-1:0];

    wire unused = &{1'b0, quot[NUM_W-1:W], rem};

endmodule

`default_nettype wire
