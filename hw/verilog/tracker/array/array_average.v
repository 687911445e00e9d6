// SPDX-License-Identifier: Apache-2.0
// One axis of a slot's average and centre, an event per clock, even where events of one slot follow each other.
//
// av <- av + (event - av) * 2^-k and, where the centre moves, cm <- cm + (av - cm) * 2^-k, rounded as in approach.v: the bit
// below the shifted value is the carry into the adder. The next event is not given the average, but its own distance to the
// average, in the same clock: it is larger by the difference of the two events, and smaller by the step. The difference
// is added while the step is shifted.
//
// This loop limits the clock frequency, so it contains only one shift and one addition: the distance read from memory and the
// forwarded one are registers, all but one of which hold zero, and array_shift takes their bitwise or. These two are stored as
// complements, so that a step only has to be added.
//
// The centre uses the same shifter and adder one clock later (`again`): nothing else is in U then. Its distance is computed
// outside the loop, in a third register.
//
// Latency: C in; u_ in U, one clock later; the average in V, two clocks later, the centre in W, three.
// Throughput: an event per clock.
// Stall:      none.
// Reset:      none: a life begins with values of its own.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

module array_average #(
    parameter A_W  = 9,  // bits of an address
    parameter FRAC = 4,  // fractional bits of a centre and of an average
    parameter COPY = 0   // see array_shift.v
) (
    input  wire                clk,
    input  wire                rst,

    // E, C
    input  wire [A_W-1:0]      next_at,   // address of the event behind
    input  wire [A_W-1:0]      event_at,  // address of the event
    input  wire [3:0]          k,
    input  wire                forward,   // of the same slot as the event in U
    input  wire [A_W+FRAC-1:0] av,
    input  wire                passes,    // no: v_av, which is on its way there
    input  wire [A_W+FRAC-1:0] cm,
    input  wire                place,     // instead: the centre at `position`; the average of the slot means nothing until set to it
    input  wire [A_W+FRAC-1:0] position,

    // U
    input  wire                again,     // the centre is next: nothing comes from C
    input  wire                moves,     // `again`, and it moves towards the new average; else it stays
    output wire [A_W+FRAC-1:0] u_cm,
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

    wire [W:0]   target      = {1'b0, event_at, {FRAC{1'b0}}};
    wire [W+1:0] read_not    = {1'b0, av, 1'b0} - {target, 1'b1};
    wire [W+1:0] passed_not  = {1'b0, v_av, 1'b0} - {target, 1'b1};
    wire [W:0]   from_centre = (target | CEIL[W:0]) - {1'b0, cm};

    // ---- U ---------------------------------------------------------------------------------------------------------

    reg         u_follows;     // the average is the one that has just been made
    reg [W-1:0] u_av_read;     // or this one
    reg [W-1:0] u_cm_not;
    reg [A_W:0] back_by;       // the event in U minus the one in C

    // Signed, the distance to go, all but one of them 0: event - average, either; average - centre.
    reg [W:0]   u_d_read_not, u_d_back_not, u_d_again;

    assign u_cm = ~u_cm_not;

    wire [W-1:0] u_av = u_follows ? v_av : u_av_read;

    wire signed [W+1:0] u_evenly;                 // the step, its rounding bit below it
    wire        [W+1:0] u_step = u_evenly >>> 1;  // if odd
    wire                u_odd;

    array_shift #(
        .W   (W + 1),
        .COPY(COPY)
    ) u_shift (
        .clk   (clk),
        .rst   (rst),
        .load  (!again),
        .k     (k),
        .a_not (u_d_read_not),
        .b_not (u_d_back_not),
        .c     (u_d_again),
        .evenly(u_evenly),
        .odd   (u_odd)
    );

    // `gap` is the average before minus the centre, `past_not` the complement of the event in C minus the average before.
    wire [W:0] new_av, past_not, back_not, gap, to_av;

    array_sum #(
        .W    (W + 1),
        .ROUND(FRAC > 0)
    ) u_new (
        .a     ({1'b0, u_av}),
        .choice(u_odd),
        .one   (u_step),
        .other (u_evenly),
        .y     (new_av)
    );
    array_sum #(
        .W    (W + 1),
        .ROUND(0)
    ) u_past (
        .a     ({back_by, {FRAC{1'b0}}}),
        .choice(u_follows),
        .one   ({u_d_back_not, 1'b0}),
        .other ({u_d_read_not, 1'b0}),
        .y     (past_not)
    );
    array_sum #(
        .W    (W + 1),
        .ROUND(FRAC > 0)
    ) u_back (
        .a     (past_not),
        .choice(u_odd),
        .one   (u_step),
        .other (u_evenly),
        .y     (back_not)
    );
    array_sum #(
        .W    (W + 1),
        .ROUND(1)
    ) u_gap (
        .a     ({1'b1, u_cm_not}),
        .choice(u_follows),
        .one   ({1'b0, v_av, 1'b1}),
        .other ({1'b0, u_av_read, 1'b1}),
        .y     (gap)
    );
    array_sum #(
        .W    (W + 1),
        .ROUND(FRAC > 0)
    ) u_to (
        .a     (gap),
        .choice(u_odd),
        .one   (u_step),
        .other (u_evenly),
        .y     (to_av)
    );

    always @(posedge clk) begin
        u_cm_not     <= ~(place ? position : cm);
        u_follows    <= forward;
        back_by      <= {1'b0, event_at} - {1'b0, next_at};
        u_av_read    <= again ? u_cm : passes ? v_av : av;
        u_d_read_not <= (forward || again) ? {(W + 1) {1'b1}} : passes ? passed_not[W+1:1] : read_not[W+1:1];
        u_d_back_not <= forward ? back_not : {(W + 1) {1'b1}};
        u_d_again    <= moves ? to_av : {(W + 1) {1'b0}};
        u_offset     <= place ? {(A_W + 1) {1'b0}} : from_centre[W:FRAC];
        v_av         <= new_av[W-1:0];
        // `forward` comes late: a reset of its own keeps synthesis from making one of it. That of u_follows keeps it apart from
        // the other axis'.
        if (rst) begin
            u_d_read_not <= {(W + 1) {1'b0}};
            u_follows    <= COPY != 0;
        end
    end

    wire unused = &{1'b0, from_centre, read_not[0], passed_not[0], new_av[W]};

endmodule

`default_nettype wire
