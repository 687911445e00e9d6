// SPDX-License-Identifier: Apache-2.0
// Sequential restoring divider of unsigned integers: num = quot * den + rem with rem < den.
//
// Division by zero is defined: quot is all ones, rem the low DEN_W bits of num.
//
// Latency:    NUM_W + 1 clocks from the operands taken to m_valid: one quotient bit per clock.
// Throughput: one division in NUM_W + 2 clocks.
// Stall:      the result stays until taken; s_ready is low from the operands taken until then.
// Reset:      drops a division under way and becomes ready. Operands and result are not reset.
// Combinational paths: none from port to port.
`default_nettype none

module divider #(
    // bits of the numerator and of the quotient, at least 1
    parameter NUM_W = 16,
    // bits of the denominator and of the remainder, at least 1
    parameter DEN_W = 8
) (
    input  wire             clk,
    input  wire             rst,

    input  wire             s_valid,
    output wire             s_ready,
    input  wire [NUM_W-1:0] s_num,
    input  wire [DEN_W-1:0] s_den,

    output wire             m_valid,
    input  wire             m_ready,
    output wire [NUM_W-1:0] m_quot,
    output wire [DEN_W-1:0] m_rem
);

    parameter_check #(.OK(NUM_W >= 1)) NUM_W_must_be_at_least_1 ();
    parameter_check #(.OK(DEN_W >= 1)) DEN_W_must_be_at_least_1 ();

    localparam COUNT_W = (NUM_W > 1) ? $clog2(NUM_W) : 1;
    localparam [31:0] LAST = NUM_W - 1;

    reg busy_reg, m_valid_reg;
    reg [COUNT_W-1:0] later_steps_reg;
    // Numerator bits leave at the top while quotient bits enter at the bottom.
    reg [NUM_W-1:0] quot_reg;
    reg [DEN_W-1:0] rem_reg, den_reg;

    wire [DEN_W:0] partial = {rem_reg, quot_reg[NUM_W-1]};
    // One subtraction for both: negative where it does not fit. What is left is below the denominator, so the low bits suffice.
    wire [DEN_W+1:0] difference = {1'b0, partial} - {2'b00, den_reg};
    wire fits = !difference[DEN_W+1];
    wire [DEN_W-1:0] restored = fits ? difference[DEN_W-1:0] : partial[DEN_W-1:0];
    wire unused = &{1'b0, difference[DEN_W]};

    assign s_ready = !busy_reg && !m_valid_reg;
    assign m_valid = m_valid_reg;
    assign m_quot = quot_reg;
    assign m_rem = rem_reg;

    always @(posedge clk) begin
        if (s_valid && s_ready) begin
            busy_reg <= 1'b1;
            later_steps_reg <= LAST[COUNT_W-1:0];
            quot_reg <= s_num;
            rem_reg <= {DEN_W{1'b0}};
            den_reg <= s_den;
        end
        if (busy_reg) begin
            later_steps_reg <= later_steps_reg - 1'b1;
            quot_reg <= quot_reg << 1;
            quot_reg[0] <= fits;
            rem_reg <= restored;
            if (later_steps_reg == {COUNT_W{1'b0}}) begin
                busy_reg <= 1'b0;
                m_valid_reg <= 1'b1;
            end
        end
        if (m_valid_reg && m_ready) m_valid_reg <= 1'b0;
        if (rst) begin
            busy_reg <= 1'b0;
            m_valid_reg <= 1'b0;
        end
    end

endmodule

`default_nettype wire
