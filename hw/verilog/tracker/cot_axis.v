// SPDX-License-Identifier: Apache-2.0
// One axis of a cluster: centre, average and window, with a register behind every adder that is not needed at once.
//
// begins, takes and moves are the three steps of an event, a clock each: its distances are formed, the average moves to it, the
// centre moves to the average. A step is (target - value) * 2^-k, rounded to nearest, halves up; with FRAC = 0 it is the plain
// arithmetic shift; from k = EVCOT_HIST_AVG_STILL on there is no step. Steps of the centre begin where those of the average end:
// (av - cm) is formed beside (event - av).
//
// Latency:    1 clock from each of the steps to av and cm, 1 more to the window; from k to the next step 1.
// Throughput: a step per clock.
// Stall:      none of its own.
// Reset:      none; place loads all that decides.
// Combinational paths: token -> hit, rel; g -> ring.
`default_nettype none
`include "evcot_defs.vh"

module cot_axis #(
    parameter W       = 9,  // bits of an address
    parameter FRAC    = 4,  // fractional bits of a centre and of an average
    parameter RADIX_W = 8   // bits of a radius register
) (
    input  wire               clk,

    input  wire               place,   // centre and average to `at`
    input  wire [W-1:0]       at,

    input  wire [W-1:0]       token,
    input  wire               begins,  // form the distances of the token
    input  wire               seeds,   // with begins: the token is the centre, and all distances are 0
    input  wire               takes,   // move the average
    input  wire               moves,   // move the centre; one clock after takes

    input  wire [RADIX_W-1:0] g,
    input  wire [RADIX_W:0]   radius,  // a register
    input  wire [3:0]         k,       // hist_avg

    output reg  [W+FRAC-1:0]  cm,
    output reg  [W+FRAC-1:0]  av,
    output wire               hit,     // the token lies in the window
    output wire [RADIX_W+1:0] rel,     // its address in the window
    output wire               ring     // the token that began lies further than g from the centre
);

    parameter_check #(.OK(W >= `EVCOT_X_W_MIN && W <= `EVCOT_X_W_MAX)) W_must_be_1_to_16 ();
    parameter_check #(.OK(FRAC >= `EVCOT_FRAC_MIN && FRAC <= `EVCOT_FRAC_MAX)) FRAC_must_be_0_to_8 ();
    parameter_check #(.OK(RADIX_W >= `EVCOT_RADIX_W_MIN && RADIX_W <= `EVCOT_RADIX_W_MAX)) RADIX_W_must_be_1_to_12 ();

    localparam POS   = W + FRAC;
    localparam EXT   = (POS > 15 ? POS : 15) + 1;  // a distance, its sign, and room for every k
    localparam REL_W = (W > RADIX_W + 2 ? W : RADIX_W + 2) + 2;
    localparam AT_W  = (W > RADIX_W + 1 ? W : RADIX_W + 1) + 2;  // as in cot_window
    localparam D_W   = (W > RADIX_W ? W : RADIX_W) + 1;

    // ---- window ----------------------------------------------------------------------------------------------------------

    wire [W-1:0]    pixel;
    wire [AT_W-1:0] lo_not, hi;

    cot_window #(
        .W   (W),
        .FRAC(FRAC),
        .R_W (RADIX_W + 1)
    ) u_window (
        .asked (1'b1),
        .centre(cm),
        .radius(radius),
        .inset ({(RADIX_W + 2) {1'b0}}),
        .pixel (pixel),
        .lo_not(lo_not),
        .hi    (hi)
    );

    reg [W-1:0]     pixel_reg;
    reg [AT_W-1:0]  hi_reg;
    reg [REL_W-1:0] base;  // radius - pixel

    // Address within the window: x - centre + R, from 0 to 2R. Its sign tells the lower bound.
    wire [REL_W-1:0] wide_rel = {{(REL_W - W) {1'b0}}, token} + base;

    wire beyond = hi_reg < {1'b1, {(AT_W - W - 1) {1'b0}}, token};

    assign hit = !wide_rel[REL_W-1] && !beyond;
    assign rel = wide_rel[RADIX_W+1:0];

    reg signed [D_W-1:0] off;  // from the centre's pixel to the token
    wire signed [D_W:0]  wide_g = $signed({{(D_W + 1 - RADIX_W) {1'b0}}, g});
    wire signed [D_W:0]  wide_off = $signed({off[D_W-1], off});

    assign ring = wide_g < wide_off || wide_off < -wide_g;

    // ---- steps -----------------------------------------------------------------------------------------------------------

    reg                  steps;
    reg [3:0]            by;             // k, a clock later
    reg signed [EXT-1:0] distance, lag;  // event - av, or av - cm in the step of the centre; av - cm before the event
    wire [EXT-1:0]       shifted = $unsigned(distance >>> by) & {EXT{steps}};
    wire [EXT:0]         below   = {distance, 1'b0} >> by;
    wire                 up      = FRAC > 0 && below[0] && steps;  // the highest bit that the shift has cut off
    wire [POS-1:0]       value   = moves ? cm : av;
    wire [POS:0]         sum     = {value, 1'b1} + {shifted[POS-1:0], up};
    wire [EXT:0]         lagging = {lag, 1'b1} + {shifted, up};

    wire [POS-1:0] target = {token, {FRAC{1'b0}}};

    always @(posedge clk) begin
        steps <= k < `EVCOT_HIST_AVG_STILL;
        by    <= k;

        pixel_reg <= pixel;
        hi_reg    <= hi;
        base      <= {{(REL_W - RADIX_W - 1) {1'b0}}, radius} - {{(REL_W - W) {1'b0}}, pixel};

        if (begins) begin
            distance <= seeds ? {EXT{1'b0}} : {{(EXT - POS) {1'b0}}, target} - {{(EXT - POS) {1'b0}}, av};
            lag      <= seeds ? {EXT{1'b0}} : {{(EXT - POS) {1'b0}}, av} - {{(EXT - POS) {1'b0}}, cm};
            off      <= seeds ? {D_W{1'b0}} : {{(D_W - W) {1'b0}}, token} - {{(D_W - W) {1'b0}}, pixel_reg};
        end
        if (takes) begin
            av       <= sum[POS:1];
            distance <= lagging[EXT:1];
        end
        if (moves) cm <= sum[POS:1];
        if (place) begin
            cm <= {at, {FRAC{1'b0}}};
            av <= {at, {FRAC{1'b0}}};
        end
    end

    wire unused = &{1'b0, sum[0], lagging[0], below[EXT:1], lo_not};

endmodule

`default_nettype wire
