// SPDX-License-Identifier: Apache-2.0
// A register that synthesis does not merge with others of the same value: each has a smaller fan-out, and can be placed near its loads.
//
// Latency:    1 clock.
// Throughput: a value per clock.
// Reset:      none.
// Stall:      none.
// Combinational paths: none.
`default_nettype none

(* keep_hierarchy *)
module array_copy #(
    parameter W = 1
) (
    input  wire         clk,
    input  wire [W-1:0] s,
    output reg  [W-1:0] m
);

    always @(posedge clk) m <= s;

endmodule

`default_nettype wire
