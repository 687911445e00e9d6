// SPDX-License-Identifier: Apache-2.0
// One axis of a cluster's window, as cot_window.v has it, but not cut off at the edges of the sensor: one addition per bound,
// the half that rounds a centre to its pixel, the highest bit of the fraction, carried into both. The lower bound is given as its
// complement, which is what a comparison adds.
//
// Every window has its centre's pixel on the sensor, so whether two windows share a pixel there is whether they share one
// at all.
//
// Combinational.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> lo_not, hi.
`default_nettype none

module engine_window #(
    parameter W    = 9,  // bits of an address
    parameter FRAC = 4,  // fractional bits of a centre
    parameter R_W  = 9,  // bits of a radius
    parameter AT_W = (W > R_W ? W : R_W) + 2  // derived: leave it alone
) (
    input  wire              asked,   // low if the result is not used, so that a simulator can skip it
    input  wire [W+FRAC-1:0] centre,
    input  wire [R_W-1:0]    radius,
    input  wire [R_W:0]      inset,   // radius - 1, signed
    output reg  [AT_W-1:0]   lo_not,  // of both bounds with 2^(AT_W-1) added, so that they are not negative
    output reg  [AT_W-1:0]   hi
);

    // 2^(AT_W-1) goes into an addend, so that nothing comes behind the carry.
    reg          half;
    reg [W-1:0]  whole;
    reg [AT_W:0] low, high;

    always @* begin
        {half, whole, low, high, lo_not, hi} = {(4 * AT_W + W + 3) {1'bx}};
        if (asked) begin
            half   = (FRAC > 0) && centre[FRAC > 0 ? FRAC - 1 : 0];
            whole  = centre[W+FRAC-1:FRAC];
            low    = {!inset[R_W], {(AT_W - R_W - 2) {inset[R_W]}}, inset, 1'b0} - {{(AT_W - W) {1'b0}}, whole, half};
            high   = {1'b1, {(AT_W - W - 1) {1'b0}}, whole, 1'b1} + {{(AT_W - R_W) {1'b0}}, radius, half};
            lo_not = low[AT_W:1];
            hi     = high[AT_W:1];
        end
    end

    wire unused = &{1'b0, centre, low[0], high[0]};

endmodule

`default_nettype wire
