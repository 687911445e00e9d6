// SPDX-License-Identifier: Apache-2.0
// a + one or a + other, rounded: the bit below the last bit of the addend is the carry into the sum.
//
// Combinational. On an ECP5, the look-up tables before the carry chain can make the selection: hw/fpga/ecp5/array_sum.v.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> y.
`default_nettype none

module array_sum #(
    parameter W     = 14,
    parameter ROUND = 1    // 0: down
) (
    input  wire [W-1:0] a,
    input  wire         choice,  // of `one`
    input  wire [W:0]   one,
    input  wire [W:0]   other,
    output wire [W-1:0] y
);

    wire [W:0] total = {a, ROUND != 0} + (choice ? one : other);

    assign y = total[W:1];

    wire unused = &{1'b0, total[0]};

endmodule

`default_nettype wire
