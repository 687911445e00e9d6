// SPDX-License-Identifier: Apache-2.0
// Box and window of a slot from its sides and its velocity: docs/motion.md, "Windows".
//
// Latency:    6 clocks from start to done; sides need stay for one, other inputs until then. Lengths must be there 2 clocks before start.
//             2 clocks from the lengths to long_x and long_y.
// Throughput: one at a time.
// Stall:      box and window stay until the next start.
// Reset:      done is low until the next start has come through.
// Combinational paths: none.
`default_nettype none

module motion_window #(
    parameter SIDE_W = 25,           // bits of a side, 2^-12 px, signed
    parameter PX_W   = SIDE_W - 12   // derived: leave it alone
) (
    input  wire                     clk,
    input  wire                     rst,

    input  wire                     start,
    input  wire signed [SIDE_W-1:0] lo_x,
    input  wire signed [SIDE_W-1:0] hi_x,
    input  wire signed [SIDE_W-1:0] lo_y,
    input  wire signed [SIDE_W-1:0] hi_y,
    input  wire [PX_W-1:0]          length_x,  // of the box, whole pixels
    input  wire [PX_W-1:0]          length_y,
    input  wire [14:0]              speed_x,
    input  wire [14:0]              speed_y,
    input  wire                     known,     // the velocity counts

    input  wire [3:0]               elongation,
    input  wire [3:0]               ring_across,
    input  wire [3:0]               ring_along,
    input  wire [3:0]               ring_any,
    input  wire [7:0]               ring_px,
    input  wire [7:0]               ring_max,

    output reg                      done,
    output reg  [PX_W+3:0]          long_x,    // so long must the other axis be at least, to be long
    output reg  [PX_W+3:0]          long_y,
    output wire [4*PX_W-1:0]        box,       // lo and hi on x, lo and hi on y
    output reg  [4*PX_W-1:0]        window
);

    reg [4:0] step;  // one of them is high: the values of the step before are there

    reg signed [PX_W-1:0] low_x, high_x, low_y, high_y;
    reg [PX_W-1:0]   width, height;
    reg [PX_W+3:0]   once_x, once_y, four_x, four_y;  // the lower and the upper two bits of elongation times a length
    reg              along_x, along_y;  // the direction of the motion
    reg [PX_W-1:0]   base_x, base_y;    // what a ring follows from
    reg [3:0]        shift_x, shift_y;
    reg [PX_W-1:0]   part_x, part_y;
    reg [7:0]        ring_x, ring_y;

    wire signed [PX_W:0] sum_x = {low_x[PX_W-1], low_x} + {high_x[PX_W-1], high_x};
    wire signed [PX_W:0] sum_y = {low_y[PX_W-1], low_y} + {high_y[PX_W-1], high_y};
    wire [PX_W:0] far_x = {1'b0, part_x} + {{(PX_W - 7) {1'b0}}, ring_px};
    wire [PX_W:0] far_y = {1'b0, part_y} + {{(PX_W - 7) {1'b0}}, ring_px};
    wire signed [PX_W-1:0] wide_x = {{(PX_W - 8) {1'b0}}, ring_x};
    wire signed [PX_W-1:0] wide_y = {{(PX_W - 8) {1'b0}}, ring_y};

    assign box = {low_x, high_x, low_y, high_y};

    // Of the pixel of a side, rounded to nearest, and of the length, which the inputs have.
    always @(posedge clk) begin
        step  <= {step[3:0], start};
        once_x <= (elongation[0] ? {4'd0, length_x} : {(PX_W + 4) {1'b0}}) + (elongation[1] ? {3'd0, length_x, 1'b0} : {(PX_W + 4) {1'b0}});
        once_y <= (elongation[0] ? {4'd0, length_y} : {(PX_W + 4) {1'b0}}) + (elongation[1] ? {3'd0, length_y, 1'b0} : {(PX_W + 4) {1'b0}});
        four_x <= (elongation[2] ? {2'd0, length_x, 2'd0} : {(PX_W + 4) {1'b0}}) + (elongation[3] ? {1'd0, length_x, 3'd0} : {(PX_W + 4) {1'b0}});
        four_y <= (elongation[2] ? {2'd0, length_y, 2'd0} : {(PX_W + 4) {1'b0}}) + (elongation[3] ? {1'd0, length_y, 3'd0} : {(PX_W + 4) {1'b0}});
        long_x <= once_x + four_x;
        long_y <= once_y + four_y;
        done <= step[4];
        if (start) begin
            width  <= length_x;
            height <= length_y;
            low_x  <= lo_x[SIDE_W-1:12] + {{(PX_W - 1) {1'b0}}, lo_x[11]};
            high_x <= hi_x[SIDE_W-1:12] + {{(PX_W - 1) {1'b0}}, hi_x[11]};
            low_y  <= lo_y[SIDE_W-1:12] + {{(PX_W - 1) {1'b0}}, lo_y[11]};
            high_y <= hi_y[SIDE_W-1:12] + {{(PX_W - 1) {1'b0}}, hi_y[11]};
        end
        if (step[0]) begin
            if (high_x < low_x) begin
                low_x  <= sum_x[PX_W:1];
                high_x <= sum_x[PX_W:1];
            end
            if (high_y < low_y) begin
                low_y  <= sum_y[PX_W:1];
                high_y <= sum_y[PX_W:1];
            end
            along_y <= known && {1'b0, speed_y} >= {speed_x, 1'b0};
            along_x <= known && {1'b0, speed_x} >= {speed_y, 1'b0};
        end
        if (step[1]) begin
            base_x  <= width;
            base_y  <= height;
            shift_x <= ring_any;
            shift_y <= ring_any;
            if (along_y || along_x) begin
                shift_x <= ring_across;
                shift_y <= ring_across;
            end
            if (along_y) begin
                if ({4'd0, height} < long_x) begin
                    base_y  <= width;
                    shift_y <= ring_along;
                end
            end else if (along_x) begin
                if ({4'd0, width} < long_y) begin
                    base_x  <= height;
                    shift_x <= ring_along;
                end
            end
        end
        if (step[2]) begin
            part_x <= base_x >> shift_x;
            part_y <= base_y >> shift_y;
        end
        if (step[3]) begin
            ring_x <= far_x < {{(PX_W - 7) {1'b0}}, ring_max} ? far_x[7:0] : ring_max;
            ring_y <= far_y < {{(PX_W - 7) {1'b0}}, ring_max} ? far_y[7:0] : ring_max;
        end
        if (step[4]) window <= {low_x - wide_x, high_x + wide_x, low_y - wide_y, high_y + wide_y};

        if (rst) begin
            step <= 5'd0;
            done <= 1'b0;
        end
    end

    wire unused = &{1'b0, sum_x[0], sum_y[0], lo_x[10:0], hi_x[10:0], lo_y[10:0], hi_y[10:0]};

endmodule

`default_nettype wire
