// SPDX-License-Identifier: Apache-2.0
// The upper part of a time whose marks wrap around: a mark that falls by more than half of its range has begun a new turn.
//
// Any other mark stays in its turn, also one that falls a little: then time runs back, as the stream says.
//
// Latency:    1 clock from set to high and known.
// Throughput: a mark every clock. What a mark does is found out in the clock after it, with registers alone.
// Reset:      no mark is known, high is 0.
`default_nettype none

module time_mark #(
    parameter MARK_W = 28,  // bits of a mark, at least 2
    parameter HIGH_W = 42   // bits with the turns, more than MARK_W
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              set,
    input  wire [MARK_W-1:0] mark,

    output wire              differs,  // the mark on offer is none, or not the one before
    output wire [HIGH_W-1:0] high,
    output reg               known     // there was a mark
);

    parameter_check #(.OK(MARK_W >= 2)) MARK_W_must_be_at_least_2 ();
    parameter_check #(.OK(HIGH_W > MARK_W)) HIGH_W_must_exceed_MARK_W ();

    localparam TURN_W = HIGH_W - MARK_W;
    localparam TOP = MARK_W - 1;
    localparam [63:0] ONE = 1;

    reg [TURN_W-1:0] turn, next_turn;  // while fresh, of the mark before; and that plus 1
    reg [MARK_W-1:0] last, previous;
    reg              fresh;            // last was set a clock ago; turn does not know of it

    // previous - last > half of the range: only from the upper half to the lower one; previous is 0 where there was none.
    wire wraps = fresh && previous[TOP] && !last[TOP] && previous[TOP-1:0] > last[TOP-1:0];

    assign high = {wraps ? next_turn : turn, last};
    assign differs = !known || mark != last;

    always @(posedge clk) begin
        fresh <= set;
        if (set) begin
            known    <= 1'b1;
            previous <= last;
            last     <= mark;
        end
        if (wraps) begin
            turn      <= next_turn;
            next_turn <= next_turn + 1'b1;
        end
        if (rst) begin
            known     <= 1'b0;
            fresh     <= 1'b0;
            last      <= {MARK_W{1'b0}};
            turn      <= {TURN_W{1'b0}};
            next_turn <= ONE[TURN_W-1:0];
        end
    end

endmodule

`default_nettype wire
