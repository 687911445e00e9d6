// SPDX-License-Identifier: Apache-2.0
/*
[properties]
mean = "the result is (a weight_a + b weight_b) / weight, to nearest with halves up, or down"
clocks = "it comes 2 W + 3 clocks after the edge that takes start, not before"
stays = "it stays until the next start"

[[tasks]]
name = "nearest"
parameters = { W = 4, WEIGHT_W = 4, ROUND = 1 }
k = 13
covers_within = 14

[[tasks]]
name = "down"
parameters = { W = 3, WEIGHT_W = 4, ROUND = 0 }
k = 11
covers_within = 12
quick = true

[[faults]]
meaning = "halves are rounded down"
right = "ROUND != 0 && !negative"
wrong = "1'b0"
breaks = ["mean"]
within = 14

[[faults]]
meaning = "the sign of the difference is left out"
right = "if (sign) high <="
wrong = "if (1'b0) high <="
breaks = ["mean"]
within = 14

[[faults]]
meaning = "a step of the division is missing"
right = "left    <= BITS[LEFT_W-1:0];"
wrong = "left    <= BITS[LEFT_W-1:0] - 1'b1;"
breaks = ["clocks"]
within = 14

[[faults]]
meaning = "the result is lost a clock later"
right = "end else if (ends) begin"
wrong = "end else if (done) done <= 1'b0; else if (ends) begin"
breaks = ["stays"]
within = 14
*/
// The mean is compared with a multiplication and a division, for any weights whose sum is not 0; the operands stay until `done`.
localparam F_WIDE = W + WEIGHT_W + 4;
localparam F_LAST = 2 * W + 3;  // clocks from start to done

reg [7:0] f_clocks;  // since start
reg       f_started, f_was_done;
reg [W-1:0] f_a, f_b, f_was;
reg [WEIGHT_W-1:0] f_weight_b;
reg [WEIGHT_W:0]   f_weight;
initial f_started = 1'b0;
always @* assume (!f_started || f_clocks >= F_LAST || (!start && a == f_a && weight_b == f_weight_b && weight == f_weight));
always @* assume (!start || (weight != 0 && {1'b0, weight_b} <= weight && weight - weight_b < (1 << WEIGHT_W)));

always @(posedge clk) begin
    f_was_done <= done && !start;
    f_was <= mean;
    if (start) begin
        f_started <= 1'b1;
        f_clocks  <= 8'd0;
        {f_a, f_b, f_weight_b, f_weight} <= {a, b, weight_b, weight};
    end else if (f_clocks < F_LAST) f_clocks <= f_clocks + 8'd1;
end

// In terms that are never negative: a * weight_a + b * weight_b, and half of the weight for rounding.
wire [F_WIDE-1:0] f_w  = {{(F_WIDE - WEIGHT_W - 1) {1'b0}}, f_weight};
wire [F_WIDE-1:0] f_wb = {{(F_WIDE - WEIGHT_W) {1'b0}}, f_weight_b};
wire [F_WIDE-1:0] f_sum = f_a * (f_w - f_wb) + f_b * f_wb;
wire [F_WIDE-1:0] f_twice = 2 * f_sum + (ROUND != 0 ? f_w : {F_WIDE{1'b0}});
wire [F_WIDE-1:0] f_mean = {{(F_WIDE - W) {1'b0}}, mean};

always @* if (f_started) begin
    p_mean:   assert (f_clocks != F_LAST || f_was_done || (2 * f_mean * f_w <= f_twice && f_twice < 2 * f_mean * f_w + 2 * f_w));
    p_clocks: assert (done == (f_clocks == F_LAST));
    p_stays:  assert (!f_was_done || (done && mean == f_was));
    i_clocks: assert (f_clocks < F_LAST || (f_clocks == F_LAST && !(multiplies || signs || divides || ends)));
    c_mean:   cover (f_clocks == F_LAST && !f_was_done && mean != f_a && mean != f_b && f_a > f_b);
    c_clocks: cover (done);
    c_stays:  cover (f_was_done);
end
