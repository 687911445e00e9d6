// SPDX-License-Identifier: Apache-2.0
// The arithmetic right shift of ~a_not | ~b_not | c by k, 0 to 9, in few levels of logic; the last shift by one is left to the reader.
//
// k is decoded while it is loaded: a one-hot register for the even shifts, and `odd` for the lowest bit. `evenly` is the
// result of the even shift; the reader must shift it by one more if `odd` is high. From k = 10 on it is 0: nothing moves.
//
// Latency: k is loaded a clock before a_not, b_not and c, from which the path is combinational.
// Throughput: a shift per clock.
// Stall:      none.
// Reset:      none.
// Combinational paths: a_not, b_not, c -> evenly.
`default_nettype none

module array_shift #(
    parameter W    = 14,  // bits of the shifted value
    parameter COPY = 0    // 0 or 1: two that load the same k stay apart in synthesis, as their registers differ in reset
) (
    input  wire         clk,
    input  wire         rst,
    input  wire         load,
    input  wire [3:0]   k,
    input  wire [W-1:0] a_not,
    input  wire [W-1:0] b_not,
    input  wire [W-1:0] c,
    output wire [W:0]   evenly,   // with the bit below the lowest one, which is 0 for k = 0 and 1
    output reg          odd
);

    reg [4:0] is;  // k is 2 i or 2 i + 1

    always @(posedge clk) begin
        if (load) begin
            is  <= 5'd1 << k[3:1];
            odd <= k[0];
        end
        if (rst) begin
            is  <= {5{COPY != 0}};
            odd <= COPY != 0;
        end
    end

    genvar i;
    generate
        for (i = 0; i < 5; i = i + 1) begin : g_k
            wire [W:0] y;
            array_products #(
                .W (W + 1),
                .BY(2 * i)
            ) u_products (
                .a_not ({a_not, 1'b1}),
                .b_not ({b_not, 1'b1}),
                .c     ({c, 1'b0}),
                .wanted(is[i]),
                .y     (y)
            );
        end
    endgenerate

    array_or #(
        .W(W + 1)
    ) u_or (
        .a(g_k[0].y),
        .b(g_k[1].y),
        .c(g_k[2].y),
        .d(g_k[3].y),
        .e(g_k[4].y),
        .y(evenly)
    );

endmodule

`default_nettype wire
