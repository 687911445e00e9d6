// SPDX-License-Identifier: Apache-2.0
// The lowest bit that is set, found in a tree: of two halves the lower one wins if it has any.
//
// Combinational.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: among, asked -> lowest, any.
`default_nettype none

module array_lowest #(
    parameter N      = 8,
    parameter SLOT_W = 3   // bits of its number
) (
    input  wire              asked,  // low if the result is not used, so that a simulator can skip it
    input  wire [N-1:0]      among,
    output wire              any,
    output reg  [SLOT_W-1:0] lowest  // any if there is none
);

    localparam LEAVES = 1 << SLOT_W;

    assign any = |among;

    // Node 1 is the root; the children of node i are 2 i and 2 i + 1. Its `place` is the number of its first leaf that is set.
    always @* begin : tree
        integer i;
        reg [2*LEAVES-1:0]        has;
        reg [2*LEAVES*SLOT_W-1:0] place;
        i      = 0;
        has    = {{(2 * LEAVES - N) {1'b0}}, among} << LEAVES;
        place  = {(2 * LEAVES * SLOT_W) {1'b0}};
        lowest = {SLOT_W{1'bx}};
        if (asked && any) begin
            for (i = 0; i < LEAVES; i = i + 1) place[(LEAVES+i)*SLOT_W+:SLOT_W] = i[SLOT_W-1:0];
            for (i = LEAVES - 1; i > 0; i = i - 1) begin
                has[i] = has[2*i] || has[2*i+1];
                place[i*SLOT_W+:SLOT_W] = has[2*i] ? place[2*i*SLOT_W+:SLOT_W] : place[(2*i+1)*SLOT_W+:SLOT_W];
            end
            lowest = place[SLOT_W+:SLOT_W];
        end
    end

endmodule

`default_nettype wire
