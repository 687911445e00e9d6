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

    input  wire               s_valid,   // else the row adds nothing
    input  wire               s_begin,   // the sum begins with the next row, and this one is none
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

    reg               valid_1, valid_2, valid_3;
    reg        [5:1]  begins;
    reg signed [13:0] pair [0:3];
    reg signed [14:0] low, high;  // of four products each
    reg signed [15:0] eight;

    integer k;

    always @(posedge clk) begin
        {valid_1, valid_2, valid_3} <= {s_valid, valid_1, valid_2};
        begins                      <= {begins[4:1], s_begin};
        for (k = 0; k < 4; k = k + 1) pair[k] <= {product[2*k][12], product[2*k]} + {product[2*k+1][12], product[2*k+1]};
        low   <= {pair[0][13], pair[0]} + {pair[1][13], pair[1]};
        high  <= {pair[2][13], pair[2]} + {pair[3][13], pair[3]};
        eight <= {low[14], low} + {high[14], high};
        if (!valid_3) begin
            low  <= 15'sd0;
            high <= 15'sd0;
        end
        sum <= sum + {{4{eight[15]}}, eight};
        if (begins[5]) sum <= 20'sd0;
    end

endmodule

`default_nettype wire
