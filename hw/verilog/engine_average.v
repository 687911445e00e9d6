// SPDX-License-Identifier: Apache-2.0
// One axis of a slot's average and centre, an event per clock, even where events of one slot follow each other.
//
// av <- av + (event - av) * 2^-k and, where the centre moves, cm <- cm + (av - cm) * 2^-k, rounded as in approach.v: the bit
// below the shifted value is the carry into the adder. Instead of the average of the event before, the event behind it
// is given its own distance to that average, in the same clock: (event - av) - step, where the first difference is formed while the
// step is shifted.
//
// The centre takes the same shifter and adder one clock later (`again`): nothing else is in U then.
//
// Latency: C in; u_ and new_av in U, one clock later; w_cm in W, three clocks later.
`default_nettype none
`include "evcot_defs.vh"

module engine_average #(
    parameter A_W  = 9,  // bits of an address
    parameter FRAC = 4   // fractional bits of a centre and of an average
) (
    input  wire                clk,

    // C
    input  wire [A_W-1:0]      event_at,  // address of the event
    input  wire [3:0]          k,
    input  wire                forward,   // of the same slot as the event in U
    input  wire [A_W+FRAC-1:0] av,
    input  wire [A_W+FRAC-1:0] cm,
    input  wire                place,     // instead: average and centre at `position`
    input  wire [A_W+FRAC-1:0] position,

    // U
    input  wire                again,     // the centre is next: nothing comes from C
    input  wire                moves,     // it moves towards the new average; else it stays
    output wire [A_W+FRAC-1:0] new_av,
    output reg  [A_W+FRAC-1:0] u_cm,
    output reg  [A_W:0]        u_offset,  // signed: the event minus the pixel of the centre

    // W
    output reg  [A_W+FRAC-1:0] w_cm
);

    localparam W = A_W + FRAC;

    parameter_check #(.OK(A_W >= `EVCOT_X_W_MIN && A_W <= `EVCOT_X_W_MAX)) A_W_must_be_1_to_16 ();
    parameter_check #(.OK(FRAC >= `EVCOT_FRAC_MIN && FRAC <= `EVCOT_FRAC_MAX)) FRAC_must_be_0_to_8 ();

    // ---- C ---------------------------------------------------------------------------------------------------------

    // event - pixel = ceil(event - cm - 1/2) in fractions, and ceil(a) = floor(a + 1 - 1/2^FRAC).
    localparam [31:0] CEIL = (FRAC > 0) ? (1 << (FRAC > 0 ? FRAC - 1 : 0)) - 1 : 0;

    wire [W:0] target      = {1'b0, event_at, {FRAC{1'b0}}};
    wire [W:0] from_centre = (target | CEIL[W:0]) - {1'b0, cm};

    // ---- U ---------------------------------------------------------------------------------------------------------

    (* keep *) reg [3:0] u_k;  // one for each axis
    reg  [W-1:0] u_av;
    reg  [W:0]   u_d;  // signed: event - average

    wire signed [W+1:0] u_shifted = $signed({u_d, 1'b0}) >>> u_k;
    wire        [W:0]   u_step    = u_shifted[W+1:1];
    wire                u_round   = (FRAC > 0) && u_shifted[0];

    // Adders with a carry into their lowest bit.
    wire [W:0]   av_sum   = {u_av, 1'b1} + {u_step[W-1:0], u_round};
    wire [W:0]   gap      = again ? {1'b0, u_av} - {1'b0, u_cm} : target - {1'b0, u_av};
    wire [W+1:0] next_sum = {gap, 1'b1} + ({u_step, u_round} ^ {(W + 2) {!again}});

    assign new_av = av_sum[W:1];

    always @(posedge clk) begin
        u_k      <= again ? u_k : k;
        u_cm     <= place ? position : cm;
        u_av     <= forward ? new_av : again ? u_cm : place ? position : av;
        u_d      <= (forward || again) ? next_sum[W+1:1] : target - {1'b0, av};
        if (again ? !moves : place) u_d <= {(W + 1) {1'b0}};
        u_offset <= place ? {(A_W + 1) {1'b0}} : from_centre[W:FRAC];
        w_cm     <= new_av;
    end

    wire unused = &{1'b0, from_centre, av_sum[0], next_sum[0]};

endmodule

`default_nettype wire
