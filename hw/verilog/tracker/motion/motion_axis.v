// SPDX-License-Identifier: Apache-2.0
// What an event does to both sides of an axis, as docs/motion.md says under "What an event does to its owner", point 3.
//
// A clock after `compare` it is known on which side the event lies; with that the outputs follow from the other inputs.
//
// Latency:    1 clock from compare to the outputs.
// Throughput: an event per clock.
// Stall:      while compare is low, the comparison stays.
// Reset:      none, nothing is used before it was computed.
// Combinational paths: lo, hi, off_lo, off_hi, hidden, out, back -> every output.
`default_nettype none

module motion_axis #(
    parameter AT_W   = 9,   // bits of an address
    parameter SIDE_W = 25,  // bits of a side, 2^-12 px, signed
    parameter OFF_W  = 30   // bits of an offset, likewise
) (
    input  wire                     clk,

    input  wire                     compare,
    input  wire [AT_W-1:0]          place,
    input  wire signed [SIDE_W-1:0] lo,
    input  wire signed [SIDE_W-1:0] hi,
    input  wire signed [OFF_W-1:0]  off_lo,
    input  wire signed [OFF_W-1:0]  off_hi,
    input  wire [1:0]               hidden,   // hi, lo
    input  wire [17:0]              out,      // way of a side that the event is beyond
    input  wire [17:0]              back,     // and of one that it is not

    output wire [1:0]               beyond,   // hi, lo: the event is beyond this side, which is measured
    output wire signed [SIDE_W-1:0] lo_next,
    output wire signed [SIDE_W-1:0] hi_next,
    output wire signed [OFF_W-1:0]  off_lo_next,
    output wire signed [OFF_W-1:0]  off_hi_next
);

    reg below, above;

    wire signed [SIDE_W-1:0] at = {{(SIDE_W - AT_W - 12) {1'b0}}, place, 12'd0};

    always @(posedge clk)
        if (compare) begin
            below <= at < lo;
            above <= at > hi;
        end

    // A hidden side goes where the other one goes; where both are hidden, none does.
    wire signed [18:0] way_lo   = below ? -$signed({1'b0, out}) : $signed({1'b0, back});
    wire signed [18:0] way_hi   = above ? $signed({1'b0, out}) : -$signed({1'b0, back});
    wire signed [18:0] moved_lo = &hidden ? 19'sd0 : hidden[0] ? way_hi : way_lo;
    wire signed [18:0] moved_hi = &hidden ? 19'sd0 : hidden[1] ? way_lo : way_hi;

    assign beyond      = &hidden ? 2'b00 : {above, below};
    assign lo_next     = lo + {{(SIDE_W - 19) {moved_lo[18]}}, moved_lo};
    assign hi_next     = hi + {{(SIDE_W - 19) {moved_hi[18]}}, moved_hi};
    assign off_lo_next = off_lo + {{(OFF_W - 19) {moved_lo[18]}}, moved_lo};
    assign off_hi_next = off_hi + {{(OFF_W - 19) {moved_hi[18]}}, moved_hi};

endmodule

`default_nettype wire
