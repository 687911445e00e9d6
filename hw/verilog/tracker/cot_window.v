// SPDX-License-Identifier: Apache-2.0
// One axis of a cluster's window: the pixel that its centre lies in, and the first and last pixel within radius R of it.
//
// The centre is rounded to nearest (halves up), so a window is always 2R + 1 pixels wide: it is not cut off at the edges of the
// sensor. Every window has its centre's pixel on the sensor, so whether two windows share a pixel there is whether they share one
// at all.
//
// One addition per bound: the half that rounds a centre to its pixel, the highest bit of the fraction, is carried into both. The
// lower bound is given as its complement, which is what a comparison adds.
//
// Combinational.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> pixel, lo_not, hi.
`default_nettype none
`include "evcot_defs.vh"

module cot_window #(
    parameter W    = 9,  // bits of an address
    parameter FRAC = 4,  // fractional bits of a centre
    parameter R_W  = 9,  // bits of a radius
    parameter AT_W = (W > R_W ? W : R_W) + 2  // derived: leave it alone
) (
    input  wire              asked,   // low if the result is not used, so that a simulator can skip it
    input  wire [W+FRAC-1:0] centre,
    input  wire [R_W-1:0]    radius,
    input  wire [R_W:0]      inset,   // radius - 1, signed
    output reg  [W-1:0]      pixel,
    output reg  [AT_W-1:0]   lo_not,  // of both bounds with 2^(AT_W-1) added, so that they are not negative
    output reg  [AT_W-1:0]   hi
);

    parameter_check #(.OK(W >= `EVCOT_X_W_MIN && W <= `EVCOT_X_W_MAX)) W_must_be_1_to_16 ();
    parameter_check #(.OK(FRAC >= `EVCOT_FRAC_MIN && FRAC <= `EVCOT_FRAC_MAX)) FRAC_must_be_0_to_8 ();
    parameter_check #(.OK(R_W >= 1 && R_W <= 13)) R_W_must_be_1_to_13 ();

    // 2^(AT_W-1) goes into an addend, so that nothing comes behind the carry.
    reg          half;
    reg [W-1:0]  whole;
    reg [AT_W:0] low, high;

    always @* begin
        {half, whole, pixel, low, high, lo_not, hi} = {(4 * AT_W + 2 * W + 3) {1'bx}};
        if (asked) begin
            half   = (FRAC > 0) && centre[FRAC > 0 ? FRAC - 1 : 0];
            whole  = centre[W+FRAC-1:FRAC];
            pixel  = whole + {{(W - 1) {1'b0}}, half};  // a centre is never beyond the last pixel: no carry out
            low    = {!inset[R_W], {(AT_W - R_W - 2) {inset[R_W]}}, inset, 1'b0} - {{(AT_W - W) {1'b0}}, whole, half};
            high   = {1'b1, {(AT_W - W - 1) {1'b0}}, whole, 1'b1} + {{(AT_W - R_W) {1'b0}}, radius, half};
            lo_not = low[AT_W:1];
            hi     = high[AT_W:1];
        end
    end

    wire unused = &{1'b0, centre, low[0], high[0]};

endmodule

`default_nettype wire
