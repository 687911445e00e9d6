// SPDX-License-Identifier: Apache-2.0
// Which slots have a visible track, a candidate, a track that was lost and may return, and four corrections behind them; the last of a
// free slot is of the life before.
//
// Latency:    1 clock.
// Throughput: a change of one slot per clock.
// Stall:      none.
// Reset:      every slot is free.
// Combinational paths: none.
`default_nettype none

module motion_lives #(
    parameter N      = 8,
    parameter SLOT_W = 3
) (
    input  wire              clk,
    input  wire              rst,

    input  wire [SLOT_W-1:0] at,           // of this slot
    input  wire              seed,         // a candidate begins
    input  wire              settle,       // the fourth correction is done
    input  wire              appear,       // the candidate becomes visible
    input  wire              lapse,        // the life ends,
    input  wire              leave,        // with it: it may return

    output reg  [N-1:0]      visible,
    output reg  [N-1:0]      candidate,
    output reg  [N-1:0]      left,
    output reg  [N-1:0]      settled
);

    wire [N-1:0] one    = {{(N - 1) {1'b0}}, 1'b1};
    wire [N-1:0] here   = one << at;
    wire         leaves = lapse && leave;
    wire         ends   = appear || lapse;  // the candidate, if it is one

    always @(posedge clk) begin
        candidate <= (candidate & ~(ends ? here : {N{1'b0}})) | (seed ? here : {N{1'b0}});
        visible   <= (visible & ~(lapse ? here : {N{1'b0}})) | (appear ? here : {N{1'b0}});
        left      <= (left & ~(seed || lapse ? here : {N{1'b0}})) | (leaves ? here : {N{1'b0}});
        settled   <= (settled & ~(seed ? here : {N{1'b0}})) | (settle ? here : {N{1'b0}});
        if (rst) {visible, candidate, left, settled} <= {(4 * N) {1'b0}};
    end

endmodule

`default_nettype wire
