// SPDX-License-Identifier: Apache-2.0
// Finds the ends of lives: a bound before which no life ends, and walks over all slots when it is reached.
//
// The bound is the minimum of all deadlines and, for every slot that is on, of the times now + max_ticks and now + detect_ticks; a
// deadline set by a later event is not before these. So it is valid until the next walk, whatever is decided in between.
//
// A walk takes a slot every clock in ascending order with `step`, and is complete 5 clocks after the last one. After
// registers were written, two walks find the minima of max_ticks and detect_ticks, which are stored. Every other walk reads the
// deadlines.
// If a life has ended by `now`, `ended` is high with the slot that has the earliest deadline (then the lowest slot): clear it and
// walk again. Otherwise the bound has been updated.
// Times are compared by their low LIFE_W bits: they are less than half that range apart.
//
// Latency:    5 clocks from the last slot of a walk to its result.
// Throughput: a slot per clock of a walk.
// Stall:      step low holds a walk.
// Reset:      the steps of a walk under way are dropped. There is no bound: the first token waits for a walk.
// Combinational paths: m_time -> m_due.
`default_nettype none

module array_lives #(
    parameter TC_W    = 24,  // bits of a timer
    parameter TIME_W  = 48,  // bits of the tick count
    parameter LIFE_W  = 26,  // bits of a deadline
    parameter CLOCK_W = 48,  // bits of the time, at least TIME_W and LIFE_W
    parameter SLOT_W  = 3    // bits of a slot number
) (
    input  wire               clk,
    input  wire               rst,

    // M: has the bound come?
    input  wire [LIFE_W-1:0]  m_time,
    output wire               m_due,

    input  wire               walks,        // a walk is under way: from its beginning until it is complete
    input  wire               survey,       // a walk over max_ticks begins: forget the last survey
    input  wire               surveys,      // this walk is one over max_ticks or detect_ticks
    input  wire               start,        // a walk over deadlines begins
    input  wire               step,         // the slot's context is there
    input  wire               finish,       // the walk over deadlines is complete: take over the bound
    input  wire [CLOCK_W-1:0] now,
    input  wire [SLOT_W-1:0]  slot,
    input  wire               timed,
    input  wire [LIFE_W-1:0]  deadline,
    input  wire               on,           // mode is not off
    input  wire [TC_W-1:0]    grant,        // max_ticks, in the second survey detect_ticks

    output reg                ended,        // a life ended by now
    output reg  [SLOT_W-1:0]  ended_slot,
    output wire [TIME_W-1:0]  ended_time
);

    localparam [LIFE_W:0] FAR = {1'b0, {LIFE_W{1'b1}}};

    // Ticks from now, signed; below them a bit that lets a deadline come before a bound at the same tick.
    reg [LIFE_W:0]   ticks_1, ticks_2, least, granted;
    reg [SLOT_W-1:0] slot_reg, slot_1, slot_2;
    reg              step_reg, step_1, step_2;
    reg [LIFE_W-1:0] at, base;                   // the slot's deadline or grant, and what it counts from
    reg              under_least, under_before;  // ticks_2 is less than `least` was, than what was in ticks_2 before
    reg              took;                       // that one became the least
    reg [LIFE_W-1:0] bound;

    wire [LIFE_W-1:0] over  = m_time - bound;

    // Sign extended by one bit: the sign of the difference is the comparison.
    wire [LIFE_W+1:0] to_least  = {ticks_1[LIFE_W], ticks_1} - {least[LIFE_W], least};
    wire [LIFE_W+1:0] to_before = {ticks_1[LIFE_W], ticks_1} - {ticks_2[LIFE_W], ticks_2};

    // `least` is two clocks old here: then what was taken in between decides.
    wire takes = step_2 && (took ? under_before : under_least);

    wire [CLOCK_W+LIFE_W-1:0] wide = {{CLOCK_W{least[LIFE_W]}}, least[LIFE_W:1]};
    reg  [CLOCK_W-1:0]        when;

    assign ended_time = when[TIME_W-1:0];
    assign m_due = !over[LIFE_W-1];

    always @(posedge clk) begin
        if (walks) begin
            step_reg     <= step && (surveys ? on : timed);
            ended        <= !least[0] && (least[LIFE_W] || least[LIFE_W:1] == {LIFE_W{1'b0}});
            when         <= now + wide[CLOCK_W-1:0];
            base         <= surveys ? {LIFE_W{1'b0}} : now[LIFE_W-1:0];
            at           <= surveys ? {{(LIFE_W - TC_W) {1'b0}}, grant} : deadline;
            slot_reg     <= slot;
            step_1       <= step_reg;
            ticks_1      <= {at - base, surveys};
            slot_1       <= slot_reg;
            step_2       <= step_1;
            ticks_2      <= ticks_1;
            slot_2       <= slot_1;
            under_least  <= to_least[LIFE_W+1];
            under_before <= to_before[LIFE_W+1];
            took         <= takes;

            if (survey) least <= FAR;
            else if (start) least <= granted;
            else if (takes) begin
                least      <= ticks_2;
                ended_slot <= slot_2;
            end
            if (surveys) granted <= least;
        end
        if (finish) bound <= when[LIFE_W-1:0];
        if (rst) {step_reg, step_1, step_2, took} <= 4'd0;  // of a walk that reset has broken off
    end

    wire unused = &{1'b0, over, to_least, to_before, wide, when};

endmodule

`default_nettype wire
