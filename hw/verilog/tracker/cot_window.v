// SPDX-License-Identifier: Apache-2.0
// One axis of a cluster's window: the pixel that its centre lies in, and the first and last pixel within radius R of it.
//
// Combinational. The centre is rounded to nearest (halves up), so a window is always 2R + 1 pixels wide before it is clipped
// to the address range 0 .. 2^W - 1. Two windows share a pixel exactly when their clipped bounds overlap.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: centre, radius -> pixel, lo, hi.
`default_nettype none
`include "evcot_defs.vh"

module cot_window #(
    parameter W    = 9,  // bits of an address
    parameter FRAC = 4,  // fractional bits of a centre
    parameter R_W  = 9   // bits of a radius
) (
    input  wire [W+FRAC-1:0] centre,
    input  wire [R_W-1:0]    radius,
    output wire [W-1:0]      pixel,
    output wire [W-1:0]      lo,
    output wire [W-1:0]      hi
);

    parameter_check #(.OK(W >= `EVCOT_X_W_MIN && W <= `EVCOT_X_W_MAX)) W_must_be_1_to_16 ();
    parameter_check #(.OK(FRAC >= `EVCOT_FRAC_MIN && FRAC <= `EVCOT_FRAC_MAX)) FRAC_must_be_0_to_8 ();
    parameter_check #(.OK(R_W >= 1 && R_W <= 13)) R_W_must_be_1_to_13 ();

    generate
        if (FRAC == 0) begin : g_whole
            assign pixel = centre;
        end else begin : g_round
            // A centre never exceeds the last pixel, so rounding cannot carry out.
            assign pixel = centre[W+FRAC-1:FRAC] + {{(W - 1) {1'b0}}, centre[FRAC-1]};
            if (FRAC > 1) begin : g_rest
                wire unused = &{1'b0, centre[FRAC-2:0]};
            end
        end
    endgenerate

    localparam EXT = (W > R_W ? W : R_W) + 1;

    wire [EXT-1:0] wide_pixel  = {{(EXT - W) {1'b0}}, pixel};
    wire [EXT-1:0] wide_radius = {{(EXT - R_W) {1'b0}}, radius};
    wire [EXT-1:0] last_pixel  = {{(EXT - W) {1'b0}}, {W{1'b1}}};
    wire [EXT-1:0] low         = (wide_pixel < wide_radius) ? {EXT{1'b0}} : wide_pixel - wide_radius;
    wire [EXT-1:0] sum         = wide_pixel + wide_radius;
    wire [EXT-1:0] high        = (sum > last_pixel) ? last_pixel : sum;

    assign lo = low[W-1:0];
    assign hi = high[W-1:0];

    wire unused_top = &{1'b0, low[EXT-1:W], high[EXT-1:W]};

endmodule

`default_nettype wire
