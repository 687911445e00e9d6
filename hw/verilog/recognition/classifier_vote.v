// SPDX-License-Identifier: Apache-2.0
// The vote of a track: rules V5 to V7 of docs/recognition.md, class by class.
//
// Latency:    1 clock from s_ to `vote`, 2 to `winner`, 3 to `margin`.
// Throughput: 1 class per clock.
// Stall:      none.
// Reset:      none; `begins` forgets the classes before.
// Combinational paths: none.
`default_nettype none

module classifier_vote (
    input  wire        clk,

    input  wire        begins,
    input  wire        blank,   // the vote before is none
    input  wire        halves,  // the vote before counts half

    // a class, from the first to the last
    input  wire        s_valid,
    input  wire [3:0]  s_class,
    input  wire [14:0] s_vote,  // before this window
    input  wire [7:0]  s_loss,

    output reg  [14:0] vote,
    output reg  [3:0]  winner,
    output reg  [14:0] margin
);

    reg        valid_1;
    reg [3:0]  class_1;
    reg [14:0] least, second;

    wire [14:0] base = blank ? 15'd0 : halves ? {1'b0, s_vote[14:1]} : s_vote;

    always @(posedge clk) begin
        vote    <= base + {7'd0, s_loss};
        valid_1 <= s_valid;
        class_1 <= s_class;
        margin  <= second - least;
        if (valid_1) begin
            if (vote < least) begin
                least  <= vote;
                second <= least;
                winner <= class_1;
            end else if (vote < second) begin
                second <= vote;
            end
        end
        if (begins) begin
            least   <= 15'h7FFF;
            second  <= 15'h7FFF;
            valid_1 <= 1'b0;
        end
    end

endmodule

`default_nettype wire
