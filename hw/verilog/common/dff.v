// SPDX-License-Identifier: Apache-2.0
// D flip-flop.
//
// Latency:    1 clock from d to q.
// Throughput: 1 value per clock; never stalls.
// Reset:      synchronous, active high. RESET_TO_COMPLEMENT = 0: q becomes 0.
//             RESET_TO_COMPLEMENT = 1, the published flip-flop: q becomes ~d at every clock while rst is high.
//             Powers up at 0.
// Combinational paths: none.
// Stall:      none.
`default_nettype none

module dff #(
    // 0: reset to zero; 1: while in reset the output follows the complement of d
    parameter RESET_TO_COMPLEMENT = 0
) (
    input  wire clk,
    input  wire rst,
    input  wire d,
    output wire q
);

    parameter_check #(.OK(RESET_TO_COMPLEMENT == 0 || RESET_TO_COMPLEMENT == 1)) RESET_TO_COMPLEMENT_must_be_0_or_1 ();

    reg q_reg;
    assign q = q_reg;

    initial q_reg = 1'b0;

    always @(posedge clk) begin
        q_reg <= d;
        if (rst) q_reg <= (RESET_TO_COMPLEMENT == 1) ? ~d : 1'b0;
    end

endmodule

`default_nettype wire
