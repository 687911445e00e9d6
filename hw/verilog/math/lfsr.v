// SPDX-License-Identifier: Apache-2.0
// Maximal-length linear feedback shift register: every state but all ones, once in 2^WIDTH - 1 steps.
//
// The register shifts towards its high end and the XNOR of its taps enters at bit 0, so it starts from all zeros.
//
// Latency:    1 clock from enable or load to state.
// Throughput: 1 step per clock with enable high; enable low holds everything.
// Load:       wins over enable; the state becomes seed. All ones would never change: that seed is refused, the state
//             stays for this clock and seed_error is high.
// done:       high for the clock in which a step has brought the state back to where the period started (zero, or the
//             seed that was loaded last), also for as long as enable then stays low.
// Reset:      state, start of the period and done become 0.
// Combinational paths: load, seed -> seed_error.
// Stall:      none but enable.
`default_nettype none

module lfsr #(
    // bits of the register, 2..64
    parameter WIDTH = 16
) (
    input  wire             clk,
    input  wire             rst,

    input  wire             enable,
    input  wire             load,
    input  wire [WIDTH-1:0] seed,
    output wire             seed_error,

    output wire [WIDTH-1:0] state,
    output wire             done
);

    parameter_check #(.OK(WIDTH >= 2 && WIDTH <= 64)) WIDTH_must_be_2_to_64 ();

`include "lfsr_taps.vh"

    localparam [63:0] TABLE_ROW = lfsr_taps(WIDTH);
    localparam [WIDTH-1:0] TAPS = TABLE_ROW[WIDTH-1:0];

    wire feedback = ~^(state & TAPS);
    wire load_seed = load && !seed_error;
    wire step = enable && !load;
    wire [WIDTH-1:0] state_next = load_seed ? seed : step ? {state[WIDTH-2:0], feedback} : state;

    reg [WIDTH-1:0] start_reg;
    reg done_reg;

    assign seed_error = load && (&seed);
    assign done = done_reg;

    genvar i;
    generate
        for (i = 0; i < WIDTH; i = i + 1) begin : g_bit
            dff bit_dff (
                .clk(clk),
                .rst(rst),
                .d(state_next[i]),
                .q(state[i])
            );
        end
    endgenerate

    always @(posedge clk) begin
        if (load_seed) start_reg <= seed;
        if (load_seed) done_reg <= 1'b0;
        else if (step) done_reg <= state_next == start_reg;
        if (rst) begin
            start_reg <= {WIDTH{1'b0}};
            done_reg <= 1'b0;
        end
    end

endmodule

`default_nettype wire
