// SPDX-License-Identifier: Apache-2.0
// Stops elaboration when a parameter is outside its range: parameter_check #(.OK(rule)) W_must_be_1_to_16 ();
//
// The instance's name states the rule, and every tool's message shows it. Nothing is built when the rule holds. When it does
// not, the module instantiates itself without end, which Verilator, Icarus and Yosys refuse. (An instance of an undefined
// module would read more simply, but Verilator resolves modules before it drops an untaken generate branch.)
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
            parameter_check #(.OK(0)) refused ();
        end
    endgenerate

endmodule

`default_nettype wire
