// SPDX-License-Identifier: Apache-2.0
// The slots for which all four comparisons hold and that are enabled: one level of logic for each, of five inputs.
//
// Combinational. Synthesised separately: instances with common comparisons would otherwise share the first of two levels.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> hits.
`default_nettype none

(* keep_hierarchy *)
module array_hits #(
    parameter N = 8
) (
    input  wire [N-1:0] not_left, not_right, not_above, not_below,  // where the probe is not, beside the window
    input  wire [N-1:0] counts,
    output wire [N-1:0] hits
);

    assign hits = not_left & not_right & not_above & not_below & counts;

endmodule

`default_nettype wire
