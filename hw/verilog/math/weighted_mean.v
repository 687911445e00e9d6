// SPDX-License-Identifier: Apache-2.0
// The mean of two values, each with a weight: (a * weight_a + b * weight_b) / weight, without a multiplier.
//
// With weight = weight_a + weight_b: mean = a + (b - a) * weight_b / weight, the quotient rounded to nearest, halves up, when
// ROUND is 1; else down. The product is computed bit by bit from the lowest, the sign of b - a last. The quotient is computed by
// non-restoring division from the highest bit: the weight is added to a negative remainder in the next clock, and subtracted from
// any other; the sign is the quotient bit. This also holds for negative products.
//
// `b` must be valid at `start`, the others until `done`, and `weight` from W clocks after `start` on; it must not be zero.
//
// Latency:    2 W + 3 clocks from the edge that takes `start` to `done`, which stays until the next start.
// Throughput: a mean at a time.
// Stall:      none.
// Reset:      none; `start` loads all that decides.
// Combinational paths: none.
`default_nettype none

module weighted_mean #(
    parameter W        = 13,  // bits of a value
    parameter WEIGHT_W = 16,  // bits of a weight
    parameter ROUND    = 1    // 1: to nearest; 0: down
) (
    input  wire                clk,
    input  wire                start,
    input  wire [W-1:0]        a,
    input  wire [W-1:0]        b,
    input  wire [WEIGHT_W-1:0] weight_b,
    input  wire [WEIGHT_W:0]   weight,    // of both
    output reg                 done,
    output reg  [W-1:0]        mean
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();
    parameter_check #(.OK(WEIGHT_W >= 1)) WEIGHT_W_must_be_at_least_1 ();
    parameter_check #(.OK(ROUND == 0 || ROUND == 1)) ROUND_must_be_0_or_1 ();

    localparam LEFT_W = $clog2(W + 1);
    localparam [31:0] BITS = W;

    reg                multiplies, signs, divides, ends;
    reg                first;     // of the divisions
    reg [LEFT_W-1:0]   left;      // clocks to go
    reg                sign;      // of b - a
    reg [WEIGHT_W+1:0] high;      // the product's upper part, then the remainder, signed
    reg [W-1:0]        bits;      // its lower part, as far as made, above what is left of b - a; then above the quotient

    wire last     = left == {LEFT_W{1'b0}};
    wire negative = high[WEIGHT_W+1];

    always @(posedge clk) begin
        if (start) begin
            {sign, bits} <= {1'b0, b} - {1'b0, a};
            high         <= {(WEIGHT_W + 2) {1'b0}};
            left         <= BITS[LEFT_W-1:0] - 1'b1;
            {done, multiplies, signs, divides, ends} <= 5'b01000;
        end else if (multiplies) begin
            {high, bits} <= {{2'b00, high[WEIGHT_W-1:0]} + {2'b00, bits[0] ? weight_b : {WEIGHT_W{1'b0}}}, bits} >> 1;
            left         <= left - 1'b1;
            multiplies   <= !last;
            signs        <= last;
        end else if (signs) begin
            if (sign) high <= high - {2'b00, weight_b};
            left    <= BITS[LEFT_W-1:0];
            signs   <= 1'b0;
            divides <= 1'b1;
            first   <= 1'b1;
        end else if (divides) begin
            high    <= {high[WEIGHT_W:0], bits[W-1]} + {!negative, negative ? weight : ~weight} + {{(WEIGHT_W + 1) {1'b0}}, !negative};
            bits    <= (bits << 1) | {{(W - 1) {1'b0}}, !negative && !first};
            left    <= left - 1'b1;
            first   <= 1'b0;
            divides <= !last;
            ends    <= last;
        end else if (ends) begin
            mean <= a + bits + {{(W - 1) {1'b0}}, ROUND != 0 && !negative};
            ends <= 1'b0;
            done <= 1'b1;
        end
    end

endmodule

`default_nettype wire
