// SPDX-License-Identifier: Apache-2.0
// floor(value / 2^shift), or all ones where that has more than OUT_W bits: as wide as the result, not as the value.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> y.
`default_nettype none

module shift_saturate #(
    parameter IN_W  = 21,  // bits of the value
    parameter OUT_W = 9    // bits of the result, fewer than IN_W
) (
    input  wire [IN_W-1:0]  value,
    input  wire [3:0]       shift,
    output wire [OUT_W-1:0] y
);

    parameter_check #(.OK(OUT_W >= 1 && OUT_W < IN_W)) OUT_W_must_be_1_to_IN_W_minus_1 ();

    localparam WIDE_W = (IN_W > OUT_W + 15) ? IN_W : OUT_W + 15;  // what can be shifted into the result

    // From the largest step down, so that each needs few more bits than the next.
    wire [WIDE_W:0]   wide = {{(WIDE_W + 1 - IN_W) {1'b0}}, value};
    wire [OUT_W+6:0]  by_8 = shift[3] ? wide[OUT_W+14:8] : wide[OUT_W+6:0];
    wire [OUT_W+2:0]  by_4 = shift[2] ? by_8[OUT_W+6:4] : by_8[OUT_W+2:0];
    wire [OUT_W:0]    by_2 = shift[1] ? by_4[OUT_W+2:2] : by_4[OUT_W:0];
    wire [OUT_W-1:0]  by_1 = shift[0] ? by_2[OUT_W:1] : by_2[OUT_W-1:0];

    // Bits that leave the result, at each step.
    wire beyond = (!shift[3] && wide >> OUT_W + 7 != {(WIDE_W + 1) {1'b0}}) || (shift[3] && wide >> OUT_W + 15 != {(WIDE_W + 1) {1'b0}})
               || (!shift[2] && |by_8[OUT_W+6:OUT_W+3]) || (!shift[1] && |by_4[OUT_W+2:OUT_W+1]) || (!shift[0] && by_2[OUT_W]);

    assign y = by_1 | {OUT_W{beyond}};

    wire unused = &{1'b0, wide};

endmodule

`default_nettype wire
