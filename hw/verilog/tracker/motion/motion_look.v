// SPDX-License-Identifier: Apache-2.0
// On which axes a box is looked at for a gap, how wide the gap must be, and where the box is cut: docs/motion.md, rules G2 and G4.
//
// Latency:    3 clocks from note to looks, 1 from on_y; 2 from on_y to narrowest; 2 from the gap to cut_px.
// Throughput: a slot at a time; an axis a clock, and a cut.
// Stall:      none.
// Reset:      none, nothing is used before it was computed.
// Combinational paths: none.
`default_nettype none

module motion_look #(
    parameter PX_W = 13  // bits of a length in pixels
) (
    input  wire            clk,

    input  wire            note,       // the lengths are those before the cut
    input  wire [PX_W-1:0] length_x,
    input  wire [PX_W-1:0] length_y,
    input  wire            is_long_x,  // long enough to be looked at along the motion; a clock behind note
    input  wire            is_long_y,
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

    input  wire [7:0]      gap_px
);

    reg  [PX_W-2:0] half_x, half_y;
    reg             across_x, across_y, looks_x, looks_y, noted;
    wire [PX_W-1:0] least   = {{(PX_W - 8) {1'b0}}, gap_px};
    reg  [PX_W-1:0] half;  // of the other axis
    reg             across;
    reg  [3:0]      cut_bin;
    reg  [4:0]      log2;

    always @(posedge clk) begin
        if (note) begin
            half_x  <= length_x[PX_W-1:1];
            half_y  <= length_y[PX_W-1:1];
        end
        noted <= note;
        if (noted) begin
            looks_x <= across_x || is_long_x;
            looks_y <= across_y || is_long_y;
        end
        across_x  <= !({speed_y, 1'b0} < {1'b0, speed_x});
        across_y  <= !({speed_x, 1'b0} < {1'b0, speed_y});
        looks     <= on_y ? looks_y : looks_x;
        half      <= {1'b0, on_y ? half_x : half_y};
        across    <= on_y ? across_y : across_x;
        narrowest <= across || half < least ? least : half;
        cut_bin   <= low_stays ? begins : ends;
        log2      <= bin_log2;
        cut_px    <= {{(PX_W - 4) {1'b0}}, cut_bin} << log2;
    end

    wire unused = &{1'b0, length_x[0], length_y[0]};

endmodule

`default_nettype wire
