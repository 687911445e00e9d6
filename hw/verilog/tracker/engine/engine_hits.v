// SPDX-License-Identifier: Apache-2.0
// Where four comparisons hold and the slot counts: one level of logic each, of five inputs.
//
// Combinational. Synthesised on its own: two that share their comparisons would share the first of two levels.
`default_nettype none

(* keep_hierarchy *)
module engine_hits #(
    parameter N = 8
) (
    input  wire [N-1:0] not_left, not_right, not_above, not_below,  // where the probe is not, beside the window
    input  wire [N-1:0] counts,
    output wire [N-1:0] hits
);

    assign hits = not_left & not_right & not_above & not_below & counts;

endmodule

`default_nettype wire
