// SPDX-License-Identifier: Apache-2.0
// The mean of two values, each with a weight: (a * weight_a + b * weight_b) / (weight_a + weight_b), without a multiplier.
//
// With lo and hi the two values, w the weight of hi and s the sum of both: mean = lo + (hi - lo) * w / s. The product is built
// bit by bit from the top, always as quotient * s + remainder: double both, then add w where the bit is set. Rounded to
// nearest, halves up, when ROUND is 1, which is one doubling more; else down. The sum of the weights must not be zero.
//
// Latency: 6 W + 5 clocks from the edge that takes `start` to `done`, which stays until the next start; the operands must
// stay so long.
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

    reg              begun, adds, ended;
    reg              sums, subtracts;  // the first and second of three clocks: grown, over, decision
    reg [LEFT_W-1:0] left;      // bits to go
    reg [W-1:0]      low;
    reg [W-1:0]      distance;  // its highest bit is the next
    reg [WEIGHT_W:0] sum, rem;  // rem is less than sum
    reg [WEIGHT_W+1:0] grown, over;
    reg [W:0]        difference;
    reg [W-1:0]      quot;
    reg              twice;     // what the doubling of rem adds to the doubled quot

    wire                b_higher = !difference[W];
    wire [WEIGHT_W-1:0] w      = b_higher ? weight_b : weight_a;  // of the higher value
    wire                passes = !over[WEIGHT_W+1];

    wire [W:0] rounded    = {low, 1'b1} + {quot, twice};

    always @(posedge clk) begin
        difference <= {1'b0, b} - {1'b0, a};

        sum   <= {1'b0, weight_a} + {1'b0, weight_b};
        grown <= {1'b0, rem} + {1'b0, adds ? {1'b0, w} : rem};
        over  <= grown - {1'b0, sum};

        sums      <= 1'b0;
        subtracts <= sums;
        if (start) begin
            begun    <= 1'b0;
            ended    <= 1'b0;
            done     <= 1'b0;
            adds     <= 1'b0;
            left     <= BITS[LEFT_W-1:0];
        end else if (!begun) begin
            begun    <= 1'b1;
            sums     <= 1'b1;
            low      <= b_higher ? a : b;
            distance <= b_higher ? difference[W-1:0] : {W{1'b0}} - difference[W-1:0];
            quot     <= {W{1'b0}};
            rem      <= {(WEIGHT_W + 1) {1'b0}};
        end else if (!sums && !subtracts && !ended) begin
            sums  <= 1'b1;
            adds  <= !adds;
            ended <= left == {LEFT_W{1'b0}};
            if (!adds || distance[W-1]) rem <= passes ? over[WEIGHT_W:0] : grown[WEIGHT_W:0];
            if (!adds) twice <= passes && (ROUND != 0 || left != {LEFT_W{1'b0}});
            if (adds) begin
                left     <= left - 1'b1;
                quot     <= {quot[W-2:0], twice} + {{(W - 1) {1'b0}}, passes && distance[W-1]};
                distance <= distance << 1;
            end
        end else if (ended) begin
            done <= 1'b1;
            mean <= rounded[W:1];
        end
    end

    wire unused = &{1'b0, grown[WEIGHT_W+1], rounded[0]};

endmodule

`default_nettype wire
