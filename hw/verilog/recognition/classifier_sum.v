// SPDX-License-Identifier: Apache-2.0
// The weighted sum of an image's cells: eight products per clock, of the eight cells and the eight weights of a row.
//
// Latency:    4 clocks from s_ to `sum`.
// Throughput: a row per clock.
// Stall:      none.
// Reset:      none; s_first begins a sum.
// Combinational paths: none.
`default_nettype none

module classifier_sum (
    input  wire               clk,

    input  wire               s_valid,   // else the row adds nothing
    input  wire               s_first,   // the sum begins with this row
    input  wire        [63:0] s_weights, // eight, signed
    input  wire        [31:0] s_cells,   // eight, without sign

    output reg  signed [19:0] sum
);

    wire signed [12:0] product [0:7];

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

    reg               valid_1, valid_2, first_1, first_2, first_3;
    reg signed [13:0] low, high;  // each of four products: at most 4 * 1920 below 0
    wire signed [14:0] eight = low + high;
    wire signed [19:0] begin_at = first_3 ? 20'sd0 : sum;

    always @(posedge clk) begin
        {valid_1, valid_2}          <= {s_valid, valid_1};
        {first_1, first_2, first_3} <= {s_first, first_1, first_2};
        low                         <= product[0] + product[1] + product[2] + product[3];
        high                        <= product[4] + product[5] + product[6] + product[7];
        if (!valid_2) begin
            low  <= 14'sd0;
            high <= 14'sd0;
        end
        sum <= begin_at + {{5{eight[14]}}, eight};
    end

endmodule

`default_nettype wire
