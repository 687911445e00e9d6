// SPDX-License-Identifier: Apache-2.0
// A flag per slot. Synthesised alone: with what is around it, Yosys makes more logic of it.
//
// Latency:    1 clock.
// Throughput: in each clock one flag can be set and any can be cleared; to set is stronger.
// Stall:      none.
// Reset:      all flags are 0; this is stronger than to set.
// Combinational paths: none.
`default_nettype none

(* keep_hierarchy *)
module classifier_flags #(
    parameter N = 8  // slots
) (
    input  wire         clk,
    input  wire         rst,
    input  wire         sets,      // the flag of set_slot
    input  wire [N-1:0] set_slot,  // one bit
    input  wire [N-1:0] clears,
    output reg  [N-1:0] flags
);

    always @(posedge clk) begin
        flags <= (flags & ~clears) | (set_slot & {N{sets}});
        if (rst) flags <= {N{1'b0}};
    end

endmodule

`default_nettype wire
