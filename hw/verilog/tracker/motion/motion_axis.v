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

    reg                     below, above;
    reg signed [SIDE_W-1:0] old_lo, old_hi;
    reg signed [OFF_W-1:0]  old_off_lo, old_off_hi;
    reg [1:0]               hides;
    reg [16:0]              far, near;

    wire signed [SIDE_W-1:0] at = {{(SIDE_W - AT_W - 12) {1'b0}}, place, 12'd0};

    always @(posedge clk) begin
        below      <= at < lo;
        above      <= at > hi;
        old_lo     <= lo;
        old_hi     <= hi;
        old_off_lo <= off_lo;
        old_off_hi <= off_hi;
        hides      <= hidden;
        far        <= out;
        near       <= back;
    end

    // A hidden side goes where the other one goes; where both are hidden, none does.
    wire signed [17:0] way_lo   = below ? -$signed({1'b0, far}) : $signed({1'b0, near});
    wire signed [17:0] way_hi   = above ? $signed({1'b0, far}) : -$signed({1'b0, near});
    wire signed [17:0] moved_lo = &hides ? 18'sd0 : hides[0] ? way_hi : way_lo;
    wire signed [17:0] moved_hi = &hides ? 18'sd0 : hides[1] ? way_lo : way_hi;

    assign beyond      = &hides ? 2'b00 : {above, below};
    assign lo_next     = old_lo + {{(SIDE_W - 18) {moved_lo[17]}}, moved_lo};
    assign hi_next     = old_hi + {{(SIDE_W - 18) {moved_hi[17]}}, moved_hi};
    assign off_lo_next = old_off_lo + {{(OFF_W - 18) {moved_lo[17]}}, moved_lo};
    assign off_hi_next = old_off_hi + {{(OFF_W - 18) {moved_hi[17]}}, moved_hi};

endmodule

`default_nettype wire
