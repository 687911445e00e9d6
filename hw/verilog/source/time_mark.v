// SPDX-License-Identifier: Apache-2.0
// Extends time marks that wrap around: a mark that decreases by more than half of its range has wrapped, and the upper part is incremented.
//
// With any other mark the upper part is kept, also if the mark decreases a little: then time runs backwards, as in the stream.
//
// Latency:    1 clock from set to high and known.
// Throughput: a mark every clock.
// Reset:      no mark is known, high is 0.
// Stall:      none.
// Combinational paths: mark -> differs.
`default_nettype none

module time_mark #(
    parameter MARK_W = 28,  // bits of a mark, at least 2
    parameter HIGH_W = 42   // bits of the whole time, more than MARK_W
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              set,
    input  wire [MARK_W-1:0] mark,

    output wire              differs,  // `mark` is not the last one, or no mark is known
    output wire [HIGH_W-1:0] high,
    output reg               known     // a mark has been received since reset
);

    parameter_check #(.OK(MARK_W >= 2)) MARK_W_must_be_at_least_2 ();
    parameter_check #(.OK(HIGH_W > MARK_W)) HIGH_W_must_exceed_MARK_W ();

    localparam TURN_W = HIGH_W - MARK_W;
    localparam TOP = MARK_W - 1;

    reg [TURN_W-1:0] turn, turn_next;  // a turn begins with every second mark at most
    reg              wrapped;          // the turn of the last mark is the next one
    reg [MARK_W-1:0] last;

    // last - mark > half of the range: only from the upper half to the lower one. Without a mark, last is 0.
    wire wraps = last[TOP] && !mark[TOP] && last[TOP-1:0] > mark[TOP-1:0];

    assign high = {wrapped ? turn_next : turn, last};
    assign differs = !known || mark != last;

    always @(posedge clk) begin
        turn_next <= turn + 1'b1;
        if (set) begin
            known   <= 1'b1;
            last    <= mark;
            wrapped <= wraps;
            if (wrapped) turn <= turn_next;
        end
        if (rst) begin
            known   <= 1'b0;
            last    <= {MARK_W{1'b0}};
            wrapped <= 1'b0;
            turn    <= {TURN_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
