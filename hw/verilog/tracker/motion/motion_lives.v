// SPDX-License-Identifier: Apache-2.0
// Which slots have a visible track, a candidate, a track that was lost and may return, and four corrections behind them; the last counts
// only while the slot has a track. Four corrections come before `appear`, and those of a candidate alone are counted.
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
    input  wire              leave,        // only with it: it may return

    output reg  [N-1:0]      visible,
    output reg  [N-1:0]      candidate,
    output reg  [N-1:0]      left,
    output reg  [N-1:0]      settled
);

    // The bits of a slot change together, so they share the enable of their flip-flops.
    wire    changes = seed || settle || appear || lapse;
    integer k;

    always @(posedge clk) begin
        for (k = 0; k < N; k = k + 1)
            if (changes && at == k[SLOT_W-1:0]) begin
                candidate[k] <= seed || settle;
                visible[k]   <= appear;
                left[k]      <= leave;
                settled[k]   <= !seed;
            end
        if (rst) {visible, candidate, left, settled} <= {(4 * N) {1'b0}};
    end

endmodule

`default_nettype wire
