// SPDX-License-Identifier: Apache-2.0
// A counter of 4 bits that stays at 15. Synthesised alone: with what is around it, Yosys makes wider and more logic of it.
//
// Latency:    none, combinational.
// Throughput: a value per clock.
// Stall:      none.
// Reset:      none, it has no state.
// Combinational paths: every input -> next.
`default_nettype none

(* keep_hierarchy *)
module classifier_count (
    input  wire       adds,
    input  wire [3:0] count,
    output wire [3:0] next
);

    wire high = count[3] && count[2];

    assign next[0] = adds ? !count[0] || (count[1] && high) : count[0];
    assign next[1] = (adds && count[0]) ? !count[1] || high : count[1];
    assign next[2] = (adds && count[0] && count[1]) ? !count[2] || count[3] : count[2];
    assign next[3] = count[3] || (adds && count[0] && count[1] && count[2]);

endmodule

`default_nettype wire
