// SPDX-License-Identifier: Apache-2.0
// Stops elaboration when a parameter is outside its range: parameter_check #(.OK(rule)) W_must_be_1_to_16 ();
//
// The instance's name states the rule. Nothing is built when the rule holds. When it does not, elaboration ends with an error
// for two reasons, because no single one is an error of every tool and shows the instance's name:
//   - The module instantiates itself without end: Verilator, Icarus and slang refuse it and show the name.
//   - A range depends on a wire: Yosys refuses it, with or without flattening, and shows the line below.
// (An instance of an undefined module would read more simply, but Verilator resolves modules before it drops an untaken generate
// branch.)
//
// Latency:    none, it has no ports.
// Throughput: none.
// Stall:      none.
// Reset:      none.
// Combinational paths: none.
`default_nettype none

module parameter_check #(
    parameter OK = 1  // the rule
) ();

    generate
        if (!OK) begin : g_refuse
            wire unknown;
            wire [unknown:0] a_parameter_is_out_of_range;
            parameter_check #(.OK(0)) refused ();
        end
    endgenerate

endmodule

`default_nettype wire
