// SPDX-License-Identifier: Apache-2.0
// The vote of a track: rules V5 to V7 of docs/recognition.md, class by class.
//
// Latency:    2 clocks from s_before and 1 from s_loss to `vote`, 1 more to `winner`; the second time, 2 more to `margin`.
// Throughput: 1 class per clock.
// Stall:      none.
// Reset:      none; `begins` forgets the classes before.
// Combinational paths: none.
`default_nettype none

module classifier_vote (
    input  wire        clk,

    input  wire        begins,
    input  wire        clears,    // `vote` is 0
    input  wire        blank,     // the vote before is none
    input  wire        halves,    // the vote before counts half

    input  wire [14:0] s_before,  // the vote before this window
    input  wire [7:0]  s_loss,    // a clock later
    input  wire        s_more,    // 1 more

    // `vote` is that of a class. Classes come from the first to the last, and then, after `turns`, once more: `again` is high
    input  wire        is_class,
    input  wire [3:0]  class_id,
    input  wire        turns,
    input  wire        again,

    output reg  [14:0] vote,
    output reg  [3:0]  winner,
    output reg  [14:0] margin
);

    reg [14:0] whole, half;  // the vote before: one of them is 0
    reg [14:0] least;    // of these votes; the second time, of those but the winner's
    reg [14:0] smallest; // of all

    wire [14:0] total;

    classifier_vote_sum #(
        .W(15)
    ) u_total (
        .a    (whole),
        .or_a (half),
        .b    ({7'd0, s_loss}),
        .carry(s_more),
        .y    (total)
    );

    always @(posedge clk) begin
        whole <= s_before;
        half  <= {1'b0, s_before[14:1]};
        if (blank || halves) whole <= 15'd0;
        if (blank || !halves) half <= 15'd0;
        vote   <= total;
        if (clears) vote <= 15'd0;
        margin <= least - smallest;
        if (is_class && vote < least) least <= vote;
        if (is_class && vote < least && !again) winner <= class_id;
        if (turns) smallest <= least;
        if (begins || turns) least <= 15'h7FFF;
    end

endmodule

`default_nettype wire
