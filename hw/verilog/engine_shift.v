// SPDX-License-Identifier: Apache-2.0
// The arithmetic right shift of a | b | c by a k of the clock before, 0 to 15, in few levels of logic.
//
// k is decoded while it is loaded: one register for each k, one for all k from each on. A bit of the result is a sum of
// products: the bit that each k takes there, and the sign for all k that reach as far.
//
// Latency: k a clock before a, b and c, which are combinational.
`default_nettype none

module engine_shift #(
    parameter W    = 14,  // bits of the shifted value
    parameter COPY = 0    // 0 or 1: two that load the same k stay apart in synthesis, as their registers differ in reset
) (
    input  wire         clk,
    input  wire         rst,
    input  wire         load,
    input  wire [3:0]   k,
    input  wire [W-1:0] a,
    input  wire [W-1:0] b,
    input  wire [W-1:0] c,
    output wire [W-1:0] shifted,
    output wire         below     // the bit below the lowest one; 0 for k = 0
);

    reg [15:0] is;       // k is i
    reg [15:0] reaches;  // k is i or more

    always @(posedge clk) begin : decode
        integer i;
        if (load)
            for (i = 0; i < 16; i = i + 1) begin
                is[i]      <= k == i[3:0];
                reaches[i] <= k >= i[3:0];
            end
        if (rst) begin
            is      <= {16{COPY != 0}};
            reaches <= {16{COPY != 0}};
        end
    end

    // From bit 0 on: the bit below, then the result. Sums of four, for the depth of the tree.
    wire [W:0]   reach;  // bit i: the shift is by W - i or more, so the sign is there
    wire [W:0]   fill;
    wire [W:0]   four   [0:3];
    wire [W:0]   moved  [0:15];

    engine_products #(
        .W(W + 1)
    ) u_fill (
        .a({(W + 1) {a[W-1]}}),
        .b({(W + 1) {b[W-1]}}),
        .c({(W + 1) {c[W-1]}}),
        .d(reach),
        .y(fill)
    );

    genvar i;
    generate
        for (i = 0; i <= W; i = i + 1) begin : g_reach
            assign reach[i] = (W - i < 16) && reaches[(W - i < 16) ? W - i : 0];
        end
        for (i = 0; i < 16; i = i + 1) begin : g_k
            if (i == 0) begin : g_all
                wire [W-2:0] product;
                engine_products #(
                    .W(W - 1)
                ) u_products (
                    .a(a[W-2:0]),
                    .b(b[W-2:0]),
                    .c(c[W-2:0]),
                    .d({(W - 1) {is[0]}}),
                    .y(product)
                );
                assign moved[i] = {1'b0, product, 1'b0};
            end else if (i < W) begin : g_some
                wire [W-1-i:0] product;
                engine_products #(
                    .W(W - i)
                ) u_products (
                    .a(a[W-2:i-1]),
                    .b(b[W-2:i-1]),
                    .c(c[W-2:i-1]),
                    .d({(W - i) {is[i]}}),
                    .y(product)
                );
                assign moved[i] = {{(i + 1) {1'b0}}, product};
            end else begin : g_none
                assign moved[i] = {(W + 1) {1'b0}};
            end
        end
        for (i = 0; i < 4; i = i + 1) begin : g_four
            assign four[i] = moved[4*i] | moved[4*i+1] | moved[4*i+2] | moved[4*i+3];
        end
    endgenerate

    assign {shifted, below} = four[0] | four[1] | four[2] | (four[3] | fill);

    wire unused = &{1'b0, is, reaches};

endmodule

`default_nettype wire
