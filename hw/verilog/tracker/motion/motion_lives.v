// SPDX-License-Identifier: Apache-2.0
// Which slots have a visible track, a candidate, a track that was lost and may return, and four corrections behind them; the last of a
// free slot is of the life before.
//
// Latency:    1 clock.
// Throughput: a change of one slot, and a candidate that is put in force, per clock.
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

    input  wire              begins,       // a candidate is in force
    input  wire [SLOT_W-1:0] begins_slot,

    input  wire [SLOT_W-1:0] at,           // of this slot
    input  wire              seed,         // a candidate is being placed
    input  wire              settle,       // the fourth correction is done
    input  wire              appear,       // the candidate becomes visible
    input  wire              lapse,        // the life ends,
    input  wire              leave,        // with it: it may return

    output reg  [N-1:0]      visible,
    output reg  [N-1:0]      candidate,
    output reg  [N-1:0]      left,
    output reg  [N-1:0]      settled
);

    wire         ends  = appear || lapse;  // the candidate, if it is one
    wire [N-1:0] one   = {{(N - 1) {1'b0}}, 1'b1};
    wire [N-1:0] here  = one << at;
    wire [N-1:0] comes = begins ? one << begins_slot : {N{1'b0}};

    always @(posedge clk) begin
        candidate <= (candidate | comes) & ~(ends ? here : {N{1'b0}});
        if (ends) visible <= appear ? visible | here : visible & ~here;
        if (seed || lapse) left <= lapse && leave ? left | here : left & ~here;
        if (seed || settle) settled <= settle ? settled | here : settled & ~here;
        if (rst) {visible, candidate, left, settled} <= {(4 * N) {1'b0}};
    end

endmodule

`default_nettype wire
