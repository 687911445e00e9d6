// SPDX-License-Identifier: Apache-2.0
// Converts the ticks of a stream of tokens to units of 2^shift ticks, the step of time stamps of few bits (cell_memory.v).
//
// Units are those of the time since reset: with a sum of T ticks so far, floor(T / 2^shift) units have passed, whenever
// `shift` was written. Of one token no more are told than UNITS_W bits hold. In a clock without a token to shift, `other` is.
//
// Latency:    2 clocks from s_ to m_: sum, shift; none from `other` to its units.
// Throughput: 1 token per clock.
// Stall:      while m_ready is low, up to two tokens are held.
// Reset:      time 0, no token inside.
// Combinational paths: m_ready -> s_ready; other, shift -> other_units.
`default_nettype none

module stamp_units #(
    parameter TICK_W  = 20,  // bits of the tick input
    parameter UNITS_W = 9,   // bits of a token's units
    parameter DATA_W  = 1,   // bits that travel with a token
    parameter OTHER_W = 19   // bits of `other`
) (
    input  wire              clk,
    input  wire              rst,

    input  wire [3:0]        shift,

    input  wire              s_valid,
    output wire              s_ready,
    input  wire [TICK_W-1:0] s_tick,
    input  wire [DATA_W-1:0] s_data,

    output wire              m_valid,
    input  wire              m_ready,
    output wire [UNITS_W-1:0] m_units,
    output wire [DATA_W-1:0] m_data,

    input  wire [OTHER_W-1:0] other,
    output wire               other_valid,  // in this clock other_units are its
    output wire [UNITS_W-1:0] other_units,

    output wire              idle  // nothing inside
);

    localparam PLACE_W = 15;                                     // bits of a place in a unit, of 2^15 ticks at most
    localparam SUM_W   = (TICK_W > PLACE_W ? TICK_W : PLACE_W) + 1;
    localparam LONG_W  = (SUM_W > OTHER_W) ? SUM_W : OTHER_W;
    localparam WIDE_W  = (LONG_W > UNITS_W) ? LONG_W : UNITS_W + 1;

    reg  [PLACE_W-1:0] ticks;  // so far, modulo 2^15
    reg                sum_valid, units_valid;
    reg  [SUM_W-1:0]   sum;
    reg  [UNITS_W-1:0] units;
    reg  [DATA_W-1:0]  sum_data, units_data;

    wire [SUM_W-1:0]   step   = {{(SUM_W - TICK_W) {1'b0}}, s_tick};
    wire [PLACE_W-1:0] in_unit = ticks & ~({PLACE_W{1'b1}} << shift);
    wire               moves  = m_ready || !units_valid;

    wire [WIDE_W:0]    wide_sum   = {{(WIDE_W + 1 - SUM_W) {1'b0}}, sum};
    wire [WIDE_W:0]    wide_other = {{(WIDE_W + 1 - OTHER_W) {1'b0}}, other};
    wire               unused     = &{1'b0, wide_sum[WIDE_W], wide_other[WIDE_W]};

    assign other_valid = !sum_valid;

    shift_saturate #(
        .IN_W (WIDE_W),
        .OUT_W(UNITS_W)
    ) u_shift (
        .value(sum_valid ? wide_sum[WIDE_W-1:0] : wide_other[WIDE_W-1:0]),
        .shift(shift),
        .y    (other_units)
    );

    always @(posedge clk) begin
        if (moves) begin
            sum_valid   <= s_valid;
            sum_data    <= s_data;
            sum         <= step + {{(SUM_W - PLACE_W) {1'b0}}, in_unit};
            if (s_valid) ticks <= ticks + step[PLACE_W-1:0];

            units_valid <= sum_valid;
            units_data  <= sum_data;
            units       <= other_units;  // of the sum, if it is valid
        end
        if (rst) begin
            sum_valid   <= 1'b0;
            units_valid <= 1'b0;
            ticks       <= {PLACE_W{1'b0}};
        end
    end

    assign s_ready = moves;
    assign m_valid = units_valid;
    assign m_units = units;
    assign m_data  = units_data;
    assign idle    = !sum_valid && !units_valid;

endmodule

`default_nettype wire
