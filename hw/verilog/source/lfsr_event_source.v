// SPDX-License-Identifier: Apache-2.0
// Pseudo-random events from an LFSR: stimulus for the trackers with no camera attached.
//
// The LFSR steps once per clock. The first candidate is read after `gap` steps, the next ones every gap + 1 steps:
//     x offset = state[X_W-1:0], y offset = state[X_W+Y_W-1:X_W], polarity = state[X_W+Y_W]
// Each offset is masked to the bits that its span needs. A candidate with both offsets inside the spans is an event at
// (x_min + x offset, y_min + y offset), which is uniform over the window x_min..x_min+x_span, y_min..y_min+y_span;
// others are dropped (at most 3 of 4). The window must lie on the sensor, since sums wrap. With gap < X_W + Y_W consecutive
// events share LFSR bits and are correlated; with a larger gap they do not.
//
// Latency:    1 clock from a candidate to m_valid.
// Throughput: 1 event per gap + 1 clocks in a window with power-of-two sides.
// Stall:      a waiting event stops the LFSR, so the sequence of events depends on seed, gap and window alone.
//             enable low stops it as well; a waiting event stays valid.
// Load:       the LFSR is set to the seed and the gap starts over; a waiting event stays valid. A refused seed has no other effect than
//             the loss of that clock. See lfsr.v for seed_error and done.
// Reset:      no event waits; the LFSR starts from zero.
// Combinational paths: load, seed -> seed_error.
`default_nettype none

module lfsr_event_source #(
    // bits of an address, at least 1
    parameter X_W = 9,
    parameter Y_W = 9,
    // bits of gap, at least 1
    parameter GAP_W = 16,
    // bits of the LFSR: more than X_W + Y_W, and what lfsr.v takes
    parameter LFSR_W = 32
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              enable,
    input  wire              load,
    input  wire [LFSR_W-1:0] seed,
    output wire              seed_error,
    output wire              done,

    // change these only together with load, or the sequence is no longer a function of the seed
    input  wire [GAP_W-1:0]  gap,
    input  wire [X_W-1:0]    x_min,
    input  wire [X_W-1:0]    x_span,
    input  wire [Y_W-1:0]    y_min,
    input  wire [Y_W-1:0]    y_span,

    output wire              m_valid,
    input  wire              m_ready,
    output wire [X_W-1:0]    m_x,
    output wire [Y_W-1:0]    m_y,
    output wire              m_p
);

    parameter_check #(.OK(X_W >= 1)) X_W_must_be_at_least_1 ();
    parameter_check #(.OK(Y_W >= 1)) Y_W_must_be_at_least_1 ();
    parameter_check #(.OK(GAP_W >= 1)) GAP_W_must_be_at_least_1 ();
    parameter_check #(.OK(LFSR_W > X_W + Y_W)) LFSR_W_must_exceed_X_W_plus_Y_W ();  // lfsr checks its own limit

    reg m_valid_reg, m_p_reg;
    reg [X_W-1:0] m_x_reg;
    reg [Y_W-1:0] m_y_reg;
    reg [GAP_W-1:0] skipped_reg;

    // Candidates use the low bits only.
    /* verilator lint_off UNUSEDSIGNAL */
    wire [LFSR_W-1:0] state;
    /* verilator lint_on UNUSEDSIGNAL */

    wire step = enable && !load && (m_ready || !m_valid_reg);
    wire candidate = step && skipped_reg >= gap;

    // Bit i of a mask is set when the span has a bit at i or above.
    wire [X_W-1:0] x_mask, x_offset;
    wire [Y_W-1:0] y_mask, y_offset;
    genvar i;
    generate
        for (i = 0; i < X_W; i = i + 1) begin : g_x_mask
            assign x_mask[i] = |x_span[X_W-1:i];
        end
        for (i = 0; i < Y_W; i = i + 1) begin : g_y_mask
            assign y_mask[i] = |y_span[Y_W-1:i];
        end
    endgenerate
    assign x_offset = state[X_W-1:0] & x_mask;
    assign y_offset = state[X_W+Y_W-1:X_W] & y_mask;

    assign m_valid = m_valid_reg;
    assign m_x = m_x_reg;
    assign m_y = m_y_reg;
    assign m_p = m_p_reg;

    lfsr #(
        .WIDTH(LFSR_W)
    ) lfsr_i (
        .clk(clk),
        .rst(rst),
        .enable(step),
        .load(load),
        .seed(seed),
        .seed_error(seed_error),
        .state(state),
        .done(done)
    );

    always @(posedge clk) begin
        if (m_ready) m_valid_reg <= 1'b0;
        if (step) skipped_reg <= candidate ? {GAP_W{1'b0}} : skipped_reg + 1'b1;
        if (candidate) begin
            m_valid_reg <= x_offset <= x_span && y_offset <= y_span;
            m_x_reg <= x_min + x_offset;
            m_y_reg <= y_min + y_offset;
            m_p_reg <= state[X_W+Y_W];
        end
        if (load && !seed_error) skipped_reg <= {GAP_W{1'b0}};
        if (rst) begin
            m_valid_reg <= 1'b0;
            skipped_reg <= {GAP_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
