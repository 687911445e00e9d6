// SPDX-License-Identifier: Apache-2.0
// On which axes a box is looked at for a gap, how wide the gap must be, and where the box is cut: docs/motion.md, "Gaps".
//
// Latency:    4 clocks from note, 2 from on_y to looks and narrowest; 1 clock from the gap to cut_px.
// Throughput: a slot at a time.
// Stall:      none.
// Reset:      none, nothing is used before it was computed.
// Combinational paths: none.
`default_nettype none

module motion_look #(
    parameter PX_W = 13  // bits of a length in pixels
) (
    input  wire            clk,

    input  wire            note,       // lengths are those before the cut
    input  wire [PX_W-1:0] length_x,
    input  wire [PX_W-1:0] length_y,
    input  wire [14:0]     speed_x,
    input  wire [14:0]     speed_y,
    input  wire            on_y,       // the axis
    output reg             looks,      // it is looked at
    output reg  [PX_W-1:0] narrowest,  // pixels of a gap

    // a gap: see motion_gaps.v
    input  wire            low_stays,
    input  wire [3:0]      begins,
    input  wire [3:0]      ends,
    input  wire [4:0]      bin_log2,
    output reg  [PX_W-1:0] cut_px,     // from the low side

    input  wire [3:0]      elongation,
    input  wire [7:0]      gap_px
);

    reg  [PX_W-1:0] was_x, was_y;
    reg  [PX_W+3:0] long_x, long_y;  // so long must the other axis be
    reg  [3:0]      times;           // beside the multipliers
    reg             across_x, across_y, looks_x, looks_y;
    wire [PX_W-1:0] least   = {{(PX_W - 8) {1'b0}}, gap_px};
    wire [PX_W-1:0] half    = {1'b0, on_y ? was_x[PX_W-1:1] : was_y[PX_W-1:1]};
    wire [PX_W-1:0] cut_bin = {{(PX_W - 4) {1'b0}}, low_stays ? begins : ends};

    always @(posedge clk) begin
        if (note) begin
            was_x <= length_x;
            was_y <= length_y;
        end
        across_x  <= {speed_y, 1'b0} >= {1'b0, speed_x};
        across_y  <= {speed_x, 1'b0} >= {1'b0, speed_y};
        times     <= elongation;
        long_x    <= {4'd0, was_x} * {{PX_W{1'b0}}, times};
        long_y    <= {4'd0, was_y} * {{PX_W{1'b0}}, times};
        looks_x   <= across_x || {4'd0, was_x} >= long_y;
        looks_y   <= across_y || {4'd0, was_y} >= long_x;
        looks     <= on_y ? looks_y : looks_x;
        narrowest <= (on_y ? across_y : across_x) || least > half ? least : half;
        cut_px    <= cut_bin << bin_log2;
    end

endmodule

`default_nettype wire
