// SPDX-License-Identifier: Apache-2.0
// The mean of two values, each with a weight: (a * weight_a + b * weight_b) / (weight_a + weight_b), without a multiplier.
//
// With lo and hi the two values, w the weight of hi and s the sum of both: mean = lo + (hi - lo) * w / s. The product is made
// bit by bit from the lowest, the quotient from the highest without restoring: a remainder below zero has s added in the next
// clock, every other one has it taken away, and its sign is the bit. Rounded to nearest, halves up, when ROUND is 1; else down.
// The sum of the weights must not be zero.
//
// Latency: 2 W + 3 clocks from the edge that takes `start` to `done`, which stays until the next start; the operands must
// stay for the two clocks from `start` on.
`default_nettype none

module engine_mean #(
    parameter W        = 13,  // bits of a value
    parameter WEIGHT_W = 16,  // bits of a weight
    parameter ROUND    = 1    // 1: to nearest; 0: down
) (
    input  wire                clk,
    input  wire                start,
    input  wire [W-1:0]        a,
    input  wire [WEIGHT_W-1:0] weight_a,
    input  wire [W-1:0]        b,
    input  wire [WEIGHT_W-1:0] weight_b,
    output reg                 done,
    output reg  [W-1:0]        mean
);

    localparam LEFT_W = $clog2(W + 1);
    localparam [31:0] BITS = W;

    reg                loads, multiplies, divides, ends;
    reg                first;     // of the divisions
    reg [LEFT_W-1:0]   left;      // clocks to go
    reg [W:0]          difference;
    reg [W-1:0]        low;
    reg [WEIGHT_W-1:0] weight;    // of the higher value
    reg [WEIGHT_W:0]   sum;
    reg [WEIGHT_W+1:0] high;      // the product's upper part, then the remainder, signed
    reg [W-1:0]        bits;      // its lower part, as far as made, above the distance's other bits; then above the quotient

    wire b_higher = !difference[W];
    wire last     = left == {LEFT_W{1'b0}};
    wire negative = high[WEIGHT_W+1];

    always @(posedge clk) begin
        loads <= start;
        if (start) begin
            difference <= {1'b0, b} - {1'b0, a};
            sum        <= {1'b0, weight_a} + {1'b0, weight_b};
            {done, multiplies, divides, ends} <= 4'd0;
        end else if (loads) begin
            multiplies <= 1'b1;
            left       <= BITS[LEFT_W-1:0] - 1'b1;
            low        <= b_higher ? a : b;
            weight     <= b_higher ? weight_b : weight_a;
            bits       <= b_higher ? difference[W-1:0] : {W{1'b0}} - difference[W-1:0];
            high       <= {(WEIGHT_W + 2) {1'b0}};
        end else if (multiplies) begin
            {high, bits} <= {{2'b00, high[WEIGHT_W-1:0]} + {2'b00, bits[0] ? weight : {WEIGHT_W{1'b0}}}, bits} >> 1;
            left         <= last ? BITS[LEFT_W-1:0] : left - 1'b1;
            multiplies   <= !last;
            divides      <= last;
            first        <= 1'b1;
        end else if (divides) begin
            high    <= {high[WEIGHT_W:0], bits[W-1]} + {!negative, negative ? sum : ~sum} + {{(WEIGHT_W + 1) {1'b0}}, !negative};
            bits    <= (bits << 1) | {{(W - 1) {1'b0}}, !negative && !first};
            left    <= left - 1'b1;
            first   <= 1'b0;
            divides <= !last;
            ends    <= last;
        end else if (ends) begin
            mean <= low + bits + {{(W - 1) {1'b0}}, ROUND != 0 && !negative};
            ends <= 1'b0;
            done <= 1'b1;
        end
    end

endmodule

`default_nettype wire
