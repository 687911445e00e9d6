// SPDX-License-Identifier: Apache-2.0
// A mean that goes a part of the way to a value, bit by bit from the lowest one: docs/filters.md, "Support that follows the noise".
//
// For W clocks `subtracts` is high, and `value` has the bits of the value. Each clock with `halves` halves the way, rounded down. Then
// `adds` is high for W clocks. Before each of `subtracts` and `adds` both are low for a clock at least.
//
// Latency:    the mean is there in the clock after the last one with `adds`.
// Throughput: a bit per clock.
// Stall:      while none of the three is high, nothing changes.
// Reset:      the mean is 0.
// Combinational paths: none.
`default_nettype none

module noise_mean #(
    parameter W = 26  // bits of the mean; its highest bit is 0, as that of each value
) (
    input  wire         clk,
    input  wire         rst,

    input  wire         subtracts,
    input  wire         halves,
    input  wire         adds,
    input  wire         value,     // a bit of it
    output reg  [W-1:0] mean
);

    reg [W-1:0] way;    // from the mean to the value, then a part of it
    reg         carry;  // of a difference: borrow
    wire        here    = mean[0];
    wire        operand = subtracts ? value : way[0];
    wire        result  = here ^ operand ^ carry;
    wire        other   = operand ^ subtracts;  // a borrow is the carry of the value's complement

    always @(posedge clk) begin
        if (subtracts || adds) mean <= {subtracts ? here : result, mean[W-1:1]};
        if (subtracts || halves || adds) way <= {subtracts ? result : way[W-1], way[W-1:1]};
        carry <= (subtracts || adds) && ((here && other) || (here && carry) || (other && carry));
        if (rst) mean <= {W{1'b0}};
    end

endmodule

`default_nettype wire
