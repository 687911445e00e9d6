// SPDX-License-Identifier: Apache-2.0
// What one event inside its window does to a cluster: the arithmetic of EV_NO_PROC and EV_PROC, shared by one tracker and
// by the array.
//
// Combinational. Every event moves the average, marks the ring and counts as support. The N_ev-th event of a window
// (last) also moves the centre towards the new average, grows g if the ring was occupied and shrinks it if it was not, and
// doubles or halves N_ev when the window was slower or faster than the previous one by more than nev_th ticks. The first
// window of a life (active = 0) has no previous one and leaves N_ev alone.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> every output that depends on it.
`default_nettype none
`include "evcot_defs.vh"

module cot_update #(
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter FRAC    = 4,   // fractional bits of a centre and of an average
    parameter RADIX_W = 8,   // bits of a radius register
    parameter NEV_W   = 10,  // bits of N_ev
    parameter TC_W    = 24,  // bits of a timer
    parameter SUP_W   = 16   // bits of a support count
) (
    // the event
    input  wire [X_W-1:0]      x,
    input  wire [Y_W-1:0]      y,

    // the cluster before it
    input  wire                active,
    input  wire [X_W+FRAC-1:0] cm_x,
    input  wire [Y_W+FRAC-1:0] cm_y,
    input  wire [X_W-1:0]      pixel_x,   // the pixel of cm_x
    input  wire [Y_W-1:0]      pixel_y,
    input  wire [X_W+FRAC-1:0] av_x,
    input  wire [Y_W+FRAC-1:0] av_y,
    input  wire [RADIX_W-1:0]  g,
    input  wire                ring,      // the ring was occupied in this window
    input  wire [NEV_W-1:0]    n_ev,
    input  wire [NEV_W-1:0]    count,     // events of this window so far
    input  wire [SUP_W-1:0]    support,
    input  wire [TC_W-1:0]     tc2,       // ticks since this window began
    input  wire [TC_W-1:0]     last_tc2,  // ticks that the previous window took

    // its registers
    input  wire [RADIX_W-1:0]  radix_step,
    input  wire [RADIX_W-1:0]  radix_min,
    input  wire [RADIX_W-1:0]  radix_max,
    input  wire [3:0]          hist_avg,
    input  wire [NEV_W-1:0]    nev_min,
    input  wire [NEV_W-1:0]    nev_max,
    input  wire [TC_W-1:0]     nev_th,

    // the cluster after it
    output wire                last,      // this is the N_ev-th event: the outputs of the second group hold too
    output wire [X_W+FRAC-1:0] new_av_x,
    output wire [Y_W+FRAC-1:0] new_av_y,
    output wire                new_ring,
    output wire [SUP_W-1:0]    new_support,

    output wire [X_W+FRAC-1:0] new_cm_x,
    output wire [Y_W+FRAC-1:0] new_cm_y,
    output wire [RADIX_W-1:0]  new_g,
    output wire [NEV_W-1:0]    new_n_ev
);

    parameter_check #(.OK(RADIX_W >= `EVCOT_RADIX_W_MIN && RADIX_W <= `EVCOT_RADIX_W_MAX)) RADIX_W_must_be_1_to_12 ();
    parameter_check #(.OK(NEV_W >= `EVCOT_NEV_W_MIN && NEV_W <= `EVCOT_NEV_W_MAX)) NEV_W_must_be_1_to_16 ();
    parameter_check #(.OK(TC_W >= `EVCOT_TC_W_MIN && TC_W <= `EVCOT_TC_W_MAX)) TC_W_must_be_1_to_32 ();
    parameter_check #(.OK(SUP_W >= `EVCOT_SUP_W_MIN && SUP_W <= `EVCOT_SUP_W_MAX)) SUP_W_must_be_1_to_32 ();

    // The ring is what lies inside the window but further than g from the centre on either axis.
    localparam XY_W = X_W > Y_W ? X_W : Y_W;
    localparam D_W  = (XY_W > RADIX_W ? XY_W : RADIX_W) + 1;

    wire [X_W-1:0] dx = (x > pixel_x) ? x - pixel_x : pixel_x - x;
    wire [Y_W-1:0] dy = (y > pixel_y) ? y - pixel_y : pixel_y - y;
    wire [D_W-1:0] inner = {{(D_W - RADIX_W) {1'b0}}, g};
    assign new_ring = ring || {{(D_W - X_W) {1'b0}}, dx} > inner || {{(D_W - Y_W) {1'b0}}, dy} > inner;

    wire [NEV_W:0] counted = {1'b0, count} + 1'b1;
    assign last = counted >= {1'b0, n_ev};

    assign new_support = (support == {SUP_W{1'b1}}) ? support : support + 1'b1;

    // av += (event - av) * alpha, then cm += (av - cm) * alpha
    approach #(
        .W   (X_W + FRAC),
        .FRAC(FRAC)
    ) u_av_x (
        .value (av_x),
        .target({x, {FRAC{1'b0}}}),
        .k     (hist_avg),
        .result(new_av_x)
    );
    approach #(
        .W   (Y_W + FRAC),
        .FRAC(FRAC)
    ) u_av_y (
        .value (av_y),
        .target({y, {FRAC{1'b0}}}),
        .k     (hist_avg),
        .result(new_av_y)
    );
    approach #(
        .W   (X_W + FRAC),
        .FRAC(FRAC)
    ) u_cm_x (
        .value (cm_x),
        .target(new_av_x),
        .k     (hist_avg),
        .result(new_cm_x)
    );
    approach #(
        .W   (Y_W + FRAC),
        .FRAC(FRAC)
    ) u_cm_y (
        .value (cm_y),
        .target(new_av_y),
        .k     (hist_avg),
        .result(new_cm_y)
    );

    wire [RADIX_W:0] grown  = {1'b0, g} + {1'b0, radix_step};
    wire [RADIX_W:0] lowest = {1'b0, radix_min} + {1'b0, radix_step};
    assign new_g = new_ring ? ((grown > {1'b0, radix_max}) ? radix_max : grown[RADIX_W-1:0])
                            : (({1'b0, g} < lowest) ? radix_min : g - radix_step);

    wire             slower  = {1'b0, tc2} > {1'b0, last_tc2} + {1'b0, nev_th};
    wire             faster  = {1'b0, tc2} + {1'b0, nev_th} < {1'b0, last_tc2};
    wire [NEV_W:0]   doubled = {n_ev, 1'b0};
    wire [NEV_W-1:0] halved  = n_ev >> 1;
    assign new_n_ev = !active ? n_ev
                    : slower  ? ((doubled > {1'b0, nev_max}) ? nev_max : doubled[NEV_W-1:0])
                    : faster  ? ((halved < nev_min) ? nev_min : halved)
                              : n_ev;

endmodule

`default_nettype wire
