// SPDX-License-Identifier: Apache-2.0
// When lives end: a bound before which none does, and a walk over all slots for what to do at it.
//
// The bound is the least of all deadlines and, for every slot that is on, of the times now + max_ticks and
// now + detect_ticks + 1 that a later event would set. So it holds until the walk after it, whatever is decided in between.
//
// A walk begins with `start`, takes one slot a clock in ascending order with `step`, and is complete 2 clocks after the last
// one. If a life has ended by `now`, `ended` and the slot with the earliest deadline (then the lowest) are there: clear it and
// walk again. Otherwise the bound is new.
// Times are compared by their low LIFE_W bits: they are less than half that range apart.
`default_nettype none

module engine_lives #(
    parameter TC_W    = 24,  // bits of a timer
    parameter TIME_W  = 48,  // bits of the tick count
    parameter LIFE_W  = 26,  // bits of a deadline
    parameter CLOCK_W = 48,  // bits of the time, at least TIME_W and LIFE_W
    parameter SLOT_W  = 3    // bits of a slot number
) (
    input  wire               clk,

    // M: has the bound come?
    input  wire [LIFE_W-1:0]  m_time,
    output wire               m_due,

    input  wire               start,
    input  wire               step,         // the slot's context is there
    input  wire               finish,       // the walk is complete: take over the bound
    input  wire [CLOCK_W-1:0] now,
    input  wire [SLOT_W-1:0]  slot,
    input  wire               timed,
    input  wire [LIFE_W-1:0]  deadline,
    input  wire               on,           // mode is not off
    input  wire [TC_W-1:0]    max_ticks,
    input  wire [TC_W-1:0]    detect_ticks,

    output wire               ended,        // a life ended by now
    output reg  [SLOT_W-1:0]  ended_slot,
    output reg  [TIME_W-1:0]  ended_time
);

    // Relative to now: ticks left, signed, and ticks that an event now would leave at least.
    reg              step_reg, timed_reg, on_reg;
    reg [LIFE_W-1:0] left_reg, grant_reg;
    reg [SLOT_W-1:0] slot_reg;

    wire [TC_W:0] detect = {1'b0, detect_ticks} + 1'b1;
    wire [TC_W:0] grant  = ({1'b0, max_ticks} < detect) ? {1'b0, max_ticks} : detect;

    reg              any_timed, any_on, bounded;
    reg [LIFE_W-1:0] least_left, least_grant, bound;

    wire first_left  = !any_timed || $signed(left_reg) < $signed(least_left);
    wire first_grant = !any_on || grant_reg < least_grant;

    wire left_first = any_timed && (!any_on || $signed(least_left) < $signed(least_grant));
    wire [LIFE_W-1:0] least = left_first ? least_left : least_grant;

    wire [LIFE_W-1:0]  over     = m_time - bound;
    wire [CLOCK_W+LIFE_W-1:0] wide_left = {{CLOCK_W{least_left[LIFE_W-1]}}, least_left};

    assign m_due      = bounded && !over[LIFE_W-1];
    assign ended      = any_timed && (least_left[LIFE_W-1] || least_left == {LIFE_W{1'b0}});

    always @(posedge clk) begin
        step_reg  <= step;
        timed_reg <= timed;
        on_reg    <= on;
        left_reg  <= deadline - now[LIFE_W-1:0];
        grant_reg <= {{(LIFE_W - TC_W - 1) {1'b0}}, grant};
        slot_reg  <= slot;
        ended_time <= now[TIME_W-1:0] + wide_left[TIME_W-1:0];

        if (start) begin
            any_timed <= 1'b0;
            any_on    <= 1'b0;
        end else if (step_reg) begin
            if (timed_reg) any_timed <= 1'b1;
            if (on_reg) any_on <= 1'b1;
        end
        if (step_reg && timed_reg && first_left) begin
            least_left <= left_reg;
            ended_slot <= slot_reg;
        end
        if (step_reg && on_reg && first_grant) least_grant <= grant_reg;
        if (finish) begin
            bounded <= any_timed || any_on;
            bound   <= now[LIFE_W-1:0] + least;
        end
    end

    wire unused = &{1'b0, over, now, wide_left};

endmodule

`default_nettype wire
