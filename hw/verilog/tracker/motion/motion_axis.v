// SPDX-License-Identifier: Apache-2.0
// What an event does to both sides of an axis, as docs/motion.md says under "What an event does to its owner", point 3.
//
// Latency:    1 clock.
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

    wire [SIDE_W-1:0]       at = {{(SIDE_W - AT_W - 12) {1'b0}}, place, 12'd0};
    reg                     below, above;
    reg signed [SIDE_W-1:0] old_lo, old_hi;
    reg signed [OFF_W-1:0]  old_off_lo, old_off_hi;
    reg [1:0]               hides;
    reg [17:0]              far, near, minus_far, minus_near;
    wire [SIDE_W:0]         over_lo = {1'b0, at} - {lo[SIDE_W-1], lo};  // the sign of a difference is a comparison
    wire [SIDE_W:0]         under_hi = {hi[SIDE_W-1], hi} - {1'b0, at};

    always @(posedge clk) begin
        below      <= over_lo[SIDE_W];
        above      <= under_hi[SIDE_W];
        old_lo     <= lo;
        old_hi     <= hi;
        old_off_lo <= off_lo;
        old_off_hi <= off_hi;
        hides      <= hidden;
        far        <= {1'b0, out};
        near       <= {1'b0, back};
        minus_far  <= -{1'b0, out};
        minus_near <= -{1'b0, back};
    end

    // A hidden side goes where the other one goes; where both are hidden, none does.
    wire signed [17:0] way_lo   = below ? minus_far : near;
    wire signed [17:0] way_hi   = above ? far : minus_near;
    wire signed [17:0] moved_lo = &hides ? 18'sd0 : hides[0] ? way_hi : way_lo;
    wire signed [17:0] moved_hi = &hides ? 18'sd0 : hides[1] ? way_lo : way_hi;

    assign beyond      = &hides ? 2'b00 : {above, below};
    assign lo_next     = old_lo + {{(SIDE_W - 18) {moved_lo[17]}}, moved_lo};
    assign hi_next     = old_hi + {{(SIDE_W - 18) {moved_hi[17]}}, moved_hi};
    assign off_lo_next = old_off_lo + {{(OFF_W - 18) {moved_lo[17]}}, moved_lo};
    assign off_hi_next = old_off_hi + {{(OFF_W - 18) {moved_hi[17]}}, moved_hi};

    wire unused = &{1'b0, over_lo, under_hi};

endmodule

`default_nettype wire
