// SPDX-License-Identifier: Apache-2.0
// One axis of a cluster's window, as cot_window.v has it, in one addition per bound: the half that rounds a centre to its
// pixel is the highest bit of the fraction, carried into both.
//
// Combinational.
`default_nettype none

module engine_window #(
    parameter W    = 9,  // bits of an address
    parameter FRAC = 4,  // fractional bits of a centre
    parameter R_W  = 9   // bits of a radius
) (
    input  wire [W+FRAC-1:0] centre,
    input  wire [R_W-1:0]    radius,
    input  wire [R_W:0]      less,    // minus radius
    output wire [W-1:0]      lo,
    output wire [W-1:0]      hi
);

    localparam EXT = (W > R_W ? W : R_W) + 2;

    wire half = (FRAC > 0) && centre[FRAC > 0 ? FRAC - 1 : 0];

    wire [EXT-1:0] whole = {{(EXT - W) {1'b0}}, centre[W+FRAC-1:FRAC]};
    wire [EXT:0]   low   = {whole, 1'b1} + {{(EXT - R_W - 1) {less[R_W]}}, less, half};
    wire [EXT:0]   high  = {whole, 1'b1} + {{(EXT - R_W) {1'b0}}, radius, half};

    assign lo = low[EXT] ? {W{1'b0}} : low[W:1];
    assign hi = |high[EXT:W+1] ? {W{1'b1}} : high[W:1];

    wire unused = &{1'b0, centre, low, high[0]};

endmodule

`default_nettype wire
