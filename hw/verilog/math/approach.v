// SPDX-License-Identifier: Apache-2.0
// Moves a fixed-point value towards a target: result = value + (target - value) * 2^-k.
//
// Combinational. With fractional bits (FRAC > 0) the step is rounded to nearest, halves up; without, it is the plain
// arithmetic shift, which stops up to 2^k - 1 short of a target that lies above. The result lies between value and target,
// so it cannot overflow.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: value, target, k -> result.
`default_nettype none
`include "evcot_defs.vh"

module approach #(
    parameter W    = 13,  // bits of value and target, fraction included
    parameter FRAC = 4    // how many of them are fraction
) (
    input  wire [W-1:0] value,
    input  wire [W-1:0] target,
    input  wire [3:0]   k,
    output wire [W-1:0] result
);

    parameter_check #(.OK(W >= 1 && W <= 24)) W_must_be_1_to_24 ();
    parameter_check #(.OK(FRAC >= `EVCOT_FRAC_MIN && FRAC <= `EVCOT_FRAC_MAX)) FRAC_must_be_0_to_8 ();

    localparam EXT = (W > 15 ? W : 15) + 2;  // room for the difference, its sign and half a step

    wire signed [EXT-1:0] difference = $signed({{(EXT - W) {1'b0}}, target}) - $signed({{(EXT - W) {1'b0}}, value});
    wire        [EXT-1:0] half = (FRAC > 0) ? ({{(EXT - 1) {1'b0}}, 1'b1} << k) >> 1 : {EXT{1'b0}};
    wire signed [EXT-1:0] step = (difference + $signed(half)) >>> k;

    assign result = value + step[W-1:0];

    wire unused = &{1'b0, step[EXT-1:W]};

endmodule

`default_nettype wire
