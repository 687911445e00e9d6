// SPDX-License-Identifier: Apache-2.0
// One axis of a slot's average and centre, an event per clock, even where events of one slot follow each other.
//
// av <- av + (event - av) * 2^-k and, where the centre moves, cm <- cm + (av - cm) * 2^-k, rounded as in approach.v: the bit
// below the shifted value is the carry into the adder. Instead of the average of the event before, the event behind it
// is given its own distance to that average, in the same clock: (event - av) - step. The first difference is formed while
// the step is shifted.
//
// That loop limits the clock, so nothing but one shift and one subtraction is in it: what comes from the memory and what
// comes round are registers of which all but one are zero, and engine_shift takes their sum.
//
// The centre takes the same shifter and adder one clock later (`again`): nothing else is in U then. Its distance is formed
// beside the loop, in a third register.
//
// Latency: C in; u_ in U, one clock later; the average in V, two clocks later, the centre in W, three.
`default_nettype none
`include "evcot_defs.vh"

module engine_average #(
    parameter A_W  = 9,  // bits of an address
    parameter FRAC = 4,  // fractional bits of a centre and of an average
    parameter COPY = 0   // see engine_shift.v
) (
    input  wire                clk,
    input  wire                rst,

    // C
    input  wire [A_W-1:0]      event_at,  // address of the event
    input  wire [3:0]          k,
    input  wire                forward,   // of the same slot as the event in U
    input  wire [A_W+FRAC-1:0] av,
    input  wire                passes,    // no: v_av, which is on its way there
    input  wire [A_W+FRAC-1:0] cm,
    input  wire                place,     // instead: average and centre at `position`
    input  wire [A_W+FRAC-1:0] position,

    // U
    input  wire                again,     // the centre is next: nothing comes from C
    input  wire                moves,     // `again`, and it moves towards the new average; else it stays
    output reg  [A_W+FRAC-1:0] u_cm,
    output reg  [A_W:0]        u_offset,  // signed: the event minus the pixel of the centre

    // V: the new average; W: the new centre
    output reg  [A_W+FRAC-1:0] v_av
);

    localparam W = A_W + FRAC;

    parameter_check #(.OK(A_W >= `EVCOT_X_W_MIN && A_W <= `EVCOT_X_W_MAX)) A_W_must_be_1_to_16 ();
    parameter_check #(.OK(FRAC >= `EVCOT_FRAC_MIN && FRAC <= `EVCOT_FRAC_MAX)) FRAC_must_be_0_to_8 ();

    // ---- C ---------------------------------------------------------------------------------------------------------

    // event - pixel = ceil(event - cm - 1/2) in fractions, and ceil(a) = floor(a + 1 - 1/2^FRAC).
    localparam [31:0] CEIL = (FRAC > 0) ? (1 << (FRAC > 0 ? FRAC - 1 : 0)) - 1 : 0;

    wire [W:0] target      = {1'b0, event_at, {FRAC{1'b0}}};
    wire [W:0] from_read   = target - {1'b0, av};
    wire [W:0] from_passed = target - {1'b0, v_av};
    wire [W:0] from_centre = (target | CEIL[W:0]) - {1'b0, cm};

    // ---- U ---------------------------------------------------------------------------------------------------------

    reg         u_follows;                      // the average is the one that has just been made
    reg [W-1:0] u_av_read;                      // or this one
    reg [W:0]   u_d_read, u_d_back, u_d_again;  // signed, the distance to go: event - average, either; average - centre

    wire [W-1:0] u_av = u_follows ? v_av : u_av_read;

    wire [W:0] u_step;
    wire       u_round;

    engine_shift #(
        .W   (W + 1),
        .COPY(COPY)
    ) u_shift (
        .clk    (clk),
        .rst    (rst),
        .load   (!again),
        .k      (k),
        .a      (u_d_read),
        .b      (u_d_back),
        .c      (u_d_again),
        .shifted(u_step),
        .below  (u_round)
    );

    wire carry = (FRAC > 0) && u_round;

    // Adders with a carry or a borrow into their lowest bit.
    wire [W:0]   av_sum = {u_av, 1'b1} + {u_step[W-1:0], carry};
    wire [W:0]   gap    = target - {1'b0, u_av};
    wire [W+1:0] back   = {gap, 1'b0} - {u_step, carry};
    wire [W:0]   gap_cm = {1'b0, u_av} - {1'b0, u_cm};
    wire [W+1:0] to_av  = {gap_cm, 1'b1} + {u_step, carry};

    always @(posedge clk) begin
        u_cm      <= place ? position : cm;
        u_follows <= forward;
        u_av_read <= again ? u_cm : place ? position : passes ? v_av : av;
        u_d_read  <= (forward || again || place) ? {(W + 1) {1'b0}} : passes ? from_passed : from_read;
        u_d_back  <= forward ? back[W+1:1] : {(W + 1) {1'b0}};
        u_d_again <= moves ? to_av[W+1:1] : {(W + 1) {1'b0}};
        u_offset  <= place ? {(A_W + 1) {1'b0}} : from_centre[W:FRAC];
        v_av      <= av_sum[W:1];
        if (rst) v_av <= {W{1'b0}};
    end

    wire unused = &{1'b0, from_centre, av_sum[0], back[0], to_av[0]};

endmodule

`default_nettype wire
