// SPDX-License-Identifier: Apache-2.0
// The lowest bit that is set, found in a tree: of two halves the lower one wins if it has any.
//
// Combinational.
`default_nettype none

module engine_lowest #(
    parameter N      = 8,
    parameter SLOT_W = 3   // bits of its number
) (
    input  wire [N-1:0]      among,
    output wire              any,
    output wire [SLOT_W-1:0] lowest  // any if there is none
);

    localparam LEAVES = 1 << SLOT_W;

    // Node 1 is the root; the children of node i are 2 i and 2 i + 1. `place` is the number of its first leaf that is set.
    wire [2*LEAVES-1:1] has;
    wire [SLOT_W-1:0]   place [1:2*LEAVES-1];

    genvar i;
    generate
        for (i = 0; i < LEAVES; i = i + 1) begin : g_leaf
            localparam [31:0] NUMBER = i;
            assign has[LEAVES+i]   = (i < N) && among[(i < N) ? i : 0];
            assign place[LEAVES+i] = NUMBER[SLOT_W-1:0];
        end
        for (i = 1; i < LEAVES; i = i + 1) begin : g_node
            assign has[i]   = has[2*i] || has[2*i+1];
            assign place[i] = has[2*i] ? place[2*i] : place[2*i+1];
        end
    endgenerate

    assign any    = has[1];
    assign lowest = place[1];

endmodule

`default_nettype wire
