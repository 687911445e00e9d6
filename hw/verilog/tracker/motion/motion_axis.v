// SPDX-License-Identifier: Apache-2.0
// What an event does to both sides of an axis, as docs/motion.md says under "What an event does to its owner", point 3.
//
// Latency:    2 clocks.
// Throughput: an event per clock.
// Stall:      none.
// Reset:      none, nothing is used before it was computed.
// Combinational paths: none.
`default_nettype none

module motion_axis #(
    parameter AT_W   = 9,   // bits of an address
    parameter SIDE_W = 25,  // bits of a side, 2^-12 px, signed
    parameter OFF_W  = 30   // bits of an offset, likewise
) (
    input  wire                     clk,

    input  wire [AT_W-1:0]          place,
    input  wire signed [SIDE_W-1:0] lo,
    input  wire signed [SIDE_W-1:0] hi,
    input  wire signed [OFF_W-1:0]  off_lo,
    input  wire signed [OFF_W-1:0]  off_hi,
    input  wire [1:0]               hidden,   // hi, lo
    input  wire [16:0]              out,      // way of a side that the event is beyond
    input  wire [16:0]              back,     // and of one that it is not

    output wire [1:0]               beyond,   // hi, lo: the event is beyond this side, which is measured
    output wire signed [SIDE_W-1:0] lo_next,
    output wire signed [SIDE_W-1:0] hi_next,
    output wire signed [OFF_W-1:0]  off_lo_next,
    output wire signed [OFF_W-1:0]  off_hi_next
);

    // The sign of a difference is a comparison.
    wire [SIDE_W-1:0] at       = {{(SIDE_W - AT_W - 12) {1'b0}}, place, 12'd0};
    wire [SIDE_W:0]   over_lo  = {1'b0, at} - {lo[SIDE_W-1], lo};
    wire [SIDE_W:0]   under_hi = {hi[SIDE_W-1], hi} - {1'b0, at};

    // Compared; then it is known how far each side moves.
    reg                     below, above;
    reg [1:0]               hides;
    reg [16:0]              far, near;
    reg signed [SIDE_W-1:0] lo_1, hi_1, lo_2, hi_2;
    reg signed [OFF_W-1:0]  off_lo_1, off_hi_1, off_lo_2, off_hi_2;
    reg [17:0]              way_lo, way_hi;    // less one where the way is negative, which is added with it
    reg [1:0]               is_beyond;

    // A hidden side goes where the other one goes; where both are hidden, none does.
    wire [17:0] own_lo = below ? ~{1'b0, far} : {1'b0, near};
    wire [17:0] own_hi = above ? {1'b0, far} : ~{1'b0, near};

    wire [SIDE_W:0] lo_sum     = {lo_2, 1'b1} + {{(SIDE_W - 18) {way_lo[17]}}, way_lo, way_lo[17]};
    wire [SIDE_W:0] hi_sum     = {hi_2, 1'b1} + {{(SIDE_W - 18) {way_hi[17]}}, way_hi, way_hi[17]};
    wire [OFF_W:0]  off_lo_sum = {off_lo_2, 1'b1} + {{(OFF_W - 18) {way_lo[17]}}, way_lo, way_lo[17]};
    wire [OFF_W:0]  off_hi_sum = {off_hi_2, 1'b1} + {{(OFF_W - 18) {way_hi[17]}}, way_hi, way_hi[17]};

    assign beyond      = is_beyond;
    assign lo_next     = lo_sum[SIDE_W:1];
    assign hi_next     = hi_sum[SIDE_W:1];
    assign off_lo_next = off_lo_sum[OFF_W:1];
    assign off_hi_next = off_hi_sum[OFF_W:1];

    always @(posedge clk) begin
        below    <= over_lo[SIDE_W];
        above    <= under_hi[SIDE_W];
        hides    <= hidden;
        far      <= out;
        near     <= back;
        lo_1     <= lo;
        hi_1     <= hi;
        off_lo_1 <= off_lo;
        off_hi_1 <= off_hi;

        way_lo    <= &hides ? 18'd0 : hides[0] ? own_hi : own_lo;
        way_hi    <= &hides ? 18'd0 : hides[1] ? own_lo : own_hi;
        is_beyond <= &hides ? 2'b00 : {above, below};
        lo_2      <= lo_1;
        hi_2      <= hi_1;
        off_lo_2  <= off_lo_1;
        off_hi_2  <= off_hi_1;
    end

    wire unused = &{1'b0, over_lo, under_hi, lo_sum[0], hi_sum[0], off_lo_sum[0], off_hi_sum[0]};

endmodule

`default_nettype wire
