// SPDX-License-Identifier: Apache-2.0
// Synchronises an asynchronous signal with a chain of flip-flops, which gives a metastable one time to settle.
//
// d must come from a pin or a register without logic in between: a glitch would be taken for a change.
//
// Latency:    STAGES clocks, one more when d changes too close to the clock edge.
// Reset:      q and all flip-flops before it become RESET.
// Throughput: a change per clock at most.
// Stall:      none.
// Combinational paths: none.
`default_nettype none

module synchronizer #(
    parameter STAGES = 2,  // flip-flops, 2..4
    parameter RESET  = 0   // 0 or 1
) (
    input  wire clk,
    input  wire rst,
    input  wire d,
    output wire q
);

    parameter_check #(.OK(STAGES >= 2 && STAGES <= 4)) STAGES_must_be_2_to_4 ();
    parameter_check #(.OK(RESET == 0 || RESET == 1)) RESET_must_be_0_or_1 ();

    // Registers that stay as they are, side by side: for Vivado, Quartus, Synplify and Lattice, Yosys.
    (* ASYNC_REG = "TRUE", SHREG_EXTRACT = "NO" *)
    (* altera_attribute = "-name SYNCHRONIZER_IDENTIFICATION FORCED", preserve, dont_merge *)
    (* syn_preserve = 1, syn_srlstyle = "registers" *)
    (* keep = 1 *)
    reg [STAGES-1:0] stages;

    assign q = stages[STAGES-1];

    always @(posedge clk) begin
        stages <= {stages[STAGES-2:0], d};
        if (rst) stages <= {STAGES{RESET[0]}};
    end

endmodule

`default_nettype wire
