// SPDX-License-Identifier: Apache-2.0
// The weighted sum of an image's cells: eight products per clock, of the eight cells and the eight weights of a row.
//
// Latency:    6 clocks from s_ to `sum`.
// Throughput: a row per clock.
// Stall:      none.
// Reset:      none; s_begin begins a sum.
// Combinational paths: none.
`default_nettype none

module classifier_sum (
    input  wire               clk,

    input  wire        [3:0]  s_valid,   // by pairs of products: else they add nothing
    input  wire               s_begin,   // the sum begins with this row
    input  wire        [63:0] s_weights, // eight, signed
    input  wire        [31:0] s_cells,   // eight, without sign

    output reg         [19:0] sum        // signed
);

    wire signed [12:0] product [0:7];  // from -1920 to 1905: 12 bits

    genvar i;
    generate
        for (i = 0; i < 8; i = i + 1) begin : g_lane
            multiplier #(
                .A_W(8),
                .B_W(5)
            ) u_product (
                .clk(clk),
                .a  (s_weights[8*i +: 8]),
                .b  ({1'b0, s_cells[4*i +: 4]}),
                .p  (product[i])
            );
        end
    endgenerate

    reg        [3:0]  valid_1, valid_2;
    reg        [5:1]  begins;
    wire       [19:0] sum_next;
    reg signed [12:0] pair_0, pair_1, pair_2, pair_3;
    reg signed [13:0] low, high;  // of four products each
    reg signed [14:0] eight;

    motion_sum #(
        .W(20)
    ) u_next (
        .adds (!begins[5]),
        .a    (sum),
        .minus(1'b0),
        .b    ({{5{eight[14]}}, eight}),
        .y    (sum_next)
    );

    always @(posedge clk) begin
        {valid_1, valid_2} <= {s_valid, valid_1};
        begins             <= {begins[4:1], s_begin};
        pair_0 <= product[0] + product[1];
        pair_1 <= product[2] + product[3];
        pair_2 <= product[4] + product[5];
        pair_3 <= product[6] + product[7];
        if (!valid_2[0]) pair_0 <= 13'sd0;
        if (!valid_2[1]) pair_1 <= 13'sd0;
        if (!valid_2[2]) pair_2 <= 13'sd0;
        if (!valid_2[3]) pair_3 <= 13'sd0;
        low    <= {pair_0[12], pair_0} + {pair_1[12], pair_1};
        high   <= {pair_2[12], pair_2} + {pair_3[12], pair_3};
        eight  <= {low[13], low} + {high[13], high};
        sum    <= sum_next;
    end

endmodule

`default_nettype wire
