// SPDX-License-Identifier: Apache-2.0
// known | lowest where that is wanted: the last level of logic before a register with the slot's number.
//
// Combinational. Synthesised on its own: each of several registers that load the same number has its look-up table beside it.
`default_nettype none

(* keep_hierarchy *)
module engine_choice #(
    parameter SLOT_W = 3  // bits of a slot number
) (
    input  wire [SLOT_W-1:0] known,   // 0 where `lowest` is wanted
    input  wire [SLOT_W-1:0] lowest,
    input  wire              wanted,
    output wire [SLOT_W-1:0] slot
);

    assign slot = known | (lowest & {SLOT_W{wanted}});

endmodule

`default_nettype wire
