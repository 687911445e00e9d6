// SPDX-License-Identifier: Apache-2.0
// The mean of two values, each with a weight: (a * weight_a + b * weight_b) / (weight_a + weight_b), without a multiplier.
//
// With lo and hi the two values, w the weight of hi and s the sum of both: mean = lo + (hi - lo) * w / s. The product is built
// bit by bit from the top, always as quotient * s + remainder: double both, then add w where the bit is set. Rounded to
// nearest, halves up, when ROUND is 1, which is one doubling more; else down. The sum of the weights must not be zero.
//
// Latency: 2 W + 3 clocks from `start` to `done`, which stays until the next start; the operands must stay so long.
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

    reg                begun, adds, b_higher;
    reg [LEFT_W-1:0]   left;      // bits to go
    reg [W-1:0]        distance;  // its highest bit is the next
    reg [W-1:0]        quot;
    reg [WEIGHT_W:0]   rem;       // less than the sum of the weights

    wire [WEIGHT_W-1:0] w     = b_higher ? weight_b : weight_a;  // of the higher value
    wire [WEIGHT_W-1:0] other = b_higher ? weight_a : weight_b;
    wire [WEIGHT_W:0]   sum   = {1'b0, weight_a} + {1'b0, weight_b};

    // Doubling, the remainder passes s when 2 rem >= s; adding w, when rem >= s - w, the other weight.
    wire [WEIGHT_W+1:0] before = adds ? {1'b0, rem} : {rem, 1'b0};
    wire [WEIGHT_W+1:0] passed = before - (adds ? {2'b00, other} : {1'b0, sum});
    wire                passes = !passed[WEIGHT_W+1];
    wire [WEIGHT_W+1:0] grown  = adds ? before + {2'b00, w} : before;

    wire [W:0] difference = {1'b0, b} - {1'b0, a};

    always @(posedge clk) begin
        if (start) begin
            begun    <= 1'b0;
            done     <= 1'b0;
            adds     <= 1'b0;
            left     <= BITS[LEFT_W-1:0];
            b_higher <= !difference[W];
        end else if (!begun) begin
            begun    <= 1'b1;
            distance <= b_higher ? difference[W-1:0] : ~difference[W-1:0] + 1'b1;
            quot     <= {W{1'b0}};
            rem      <= {(WEIGHT_W + 1) {1'b0}};
        end else if (left != {LEFT_W{1'b0}}) begin
            adds <= !adds;
            if (adds) begin
                left     <= left - 1'b1;
                distance <= distance << 1;
            end
            if (!adds || distance[W-1]) begin
                rem  <= passes ? passed[WEIGHT_W:0] : grown[WEIGHT_W:0];
                quot <= (adds ? quot : quot << 1) + {{(W - 1) {1'b0}}, passes};
            end
        end else if (!done) begin
            done <= 1'b1;
            mean <= (b_higher ? a : b) + quot + {{(W - 1) {1'b0}}, (ROUND != 0) && passes};
        end
    end

    wire unused = &{1'b0, grown[WEIGHT_W+1]};

endmodule

`default_nettype wire
