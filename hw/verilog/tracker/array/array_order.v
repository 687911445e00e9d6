// SPDX-License-Identifier: Apache-2.0
// Which of two slots was born first, however many births ago.
//
// All slots are kept in a list, the first born first. A birth moves its slot to the end, and those behind it up by one;
// so there is no counter that could wrap. Slots without a birth so far come before all others, in any order.
//
// A slot that is given while `asked` is high is located a clock later (otherwise nothing is computed). `born` then registers its
// birth. Of two slots given in two clocks, `second_first` says in the clock after them whether the second was born before the first.
//
// Latency:    2 clocks from `born` until the list is updated: until then `asked` must be low.
// Reset:      the list is in the order of slot numbers.
// Throughput: a birth or a comparison per clock.
// Stall:      none.
// Combinational paths: none.
`default_nettype none

module array_order #(
    parameter N      = 8,  // slots
    parameter SLOT_W = 3   // bits of a slot number
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              asked,
    input  wire [SLOT_W-1:0] slot,
    input  wire              born,
    output wire              second_first
);

    reg [N*SLOT_W-1:0] row;
    reg [N-1:0]        at;      // where the slot named last stands
    reg [N-1:0]        behind;  // from where the one before it stands, to the end
    reg [SLOT_W-1:0]   slot_at, slot_behind;
    reg                moves;

    assign second_first = |(at & ~behind);

    // Each slot behind the one that moves goes one place forward; the last place takes that slot. A simulator computes it only where
    // it is needed.
    reg [N*SLOT_W-1:0] next_row;

    always @* begin : move
        integer i;
        reg [(N+1)*SLOT_W-1:0] onward;
        i        = 0;
        onward   = {((N + 1) * SLOT_W) {1'bx}};
        next_row = {(N * SLOT_W) {1'bx}};
        if (moves) begin
            onward   = {slot_behind, row};
            next_row = row;
            for (i = 0; i < N; i = i + 1) if (behind[i]) next_row[SLOT_W*i+:SLOT_W] = onward[SLOT_W*(i+1)+:SLOT_W];
        end
    end

    always @(posedge clk) begin : update
        integer i;
        slot_at     <= slot;
        slot_behind <= slot_at;
        behind      <= -at;  // one bit is set: it and all above
        moves       <= born && !rst;
        if (asked)
            for (i = 0; i < N; i = i + 1) at[i] <= row[SLOT_W*i+:SLOT_W] == slot;
        if (moves) row <= next_row;
        if (rst)
            for (i = 0; i < N; i = i + 1) row[SLOT_W*i+:SLOT_W] <= i[SLOT_W-1:0];
    end

endmodule

`default_nettype wire
