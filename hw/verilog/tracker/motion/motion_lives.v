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

    wire ends = appear || lapse;  // the candidate, if it is one

    genvar i;
    generate
        for (i = 0; i < N; i = i + 1) begin : g_slot
            wire here  = at == i[SLOT_W-1:0];
            wire comes = begins && begins_slot == i[SLOT_W-1:0];

            always @(posedge clk) begin
                if (here && ends) visible[i] <= appear;
                if (comes || (here && ends)) candidate[i] <= !(here && ends);
                if (here && (seed || lapse)) left[i] <= lapse && leave;
                if (here && (seed || settle)) settled[i] <= settle;
                if (rst) {visible[i], candidate[i], left[i], settled[i]} <= 4'd0;
            end
        end
    endgenerate

endmodule

`default_nettype wire
