// SPDX-License-Identifier: Apache-2.0
// Box and window of a slot from its sides and its velocity: docs/motion.md, rule W1. Both axes go through one circuit, x first.
//
// Latency:    6 clocks from start to done; sides need stay for two, other inputs until then. Speeds, and whether they count, must be
//             there at start, lengths 4 clocks before. 5 clocks from the lengths to is_long_x and is_long_y.
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
    input  wire                     widest,    // the window is as far from the box as it may be

    input  wire [3:0]               elongation,
    input  wire [3:0]               ring_across,
    input  wire [3:0]               ring_along,
    input  wire [3:0]               ring_any,
    input  wire [7:0]               ring_px,
    input  wire [7:0]               ring_max,

    output wire                     soon,      // the box is there, and two clocks later the window
    output reg                      done,
    output reg                      is_long_x, // it is at least `elongation` times as long as the other axis
    output reg                      is_long_y,
    output wire [4*PX_W-1:0]        box,       // lo and hi on x, lo and hi on y
    output reg  [4*PX_W-1:0]        window
);

    // ---- how long each axis must be: x and y in turn, at any time -----------------------------------------------------------

    reg              second, second_1, second_2;  // of the axis that comes, of that before, and before
    reg [PX_W+3:0]   times_x, times_y;
    wire [PX_W+5:0]  times;

    // ---- the ring, the box and the window: x, then y ----------------------------------------------------------------------

    reg [4:0]             step;                  // one of them is high, from the clock after start: y is in the first stage, x in the second
    reg                   along_x, along_y;      // the direction of the motion
    reg signed [PX_W-1:0] low, high;             // pixels of the sides
    wire [PX_W-1:0]       next_low, next_high, window_low, window_high;
    reg signed [PX_W-1:0] low_x, high_x, low_y, high_y;
    wire [PX_W-1:0]       part;                  // what a ring follows from
    wire [PX_W+17:0]      parts;                 // 2^15 times that: a shift to the right is a product with a power of two
    reg [7:0]             ring;
    reg [7:0]             ring_less;             // its complement
    reg [8:0]             room;                  // for `part`, within the widest ring, less one pixel

    wire signed [PX_W:0]     sum    = {low[PX_W-1], low} + {high[PX_W-1], high};
    wire [PX_W:0]            apart  = {high[PX_W-1], high} - {low[PX_W-1], low};
    wire                     crossed = apart[PX_W];
    wire signed [PX_W-1:0]   first  = crossed ? sum[PX_W:1] : low;
    wire signed [PX_W-1:0]   last   = crossed ? sum[PX_W:1] : high;
    wire                     on_y   = step[1];   // in the second stage
    wire                     short  = on_y ? along_y && !is_long_y : along_x && !is_long_x;  // along the motion, and not long
    wire [7:0]               far    = part[7:0] + ring_px;
    wire signed [PX_W:0]     spare  = {{(PX_W - 8) {room[8]}}, room} - {1'b0, part};  // negative where the ring is as wide as it may be
    wire [7:0]               next_ring = widest || spare[PX_W] ? ring_max : far;
    wire                     leans_x = {1'b0, speed_y} < {speed_x, 1'b0};  // it does not move along y
    wire                     leans_y = {1'b0, speed_x} < {speed_y, 1'b0};

    assign soon = step[3];
    assign box = {low_x, high_x, low_y, high_y};

    multiplier #(
        .A_W(PX_W + 1),
        .B_W(5)
    ) u_times (
        .clk(clk),
        .a  ({1'b0, second ? length_y : length_x}),
        .b  ({1'b0, elongation}),
        .p  (times)
    );

    assign part = parts[15+:PX_W];

    multiplier #(
        .A_W(PX_W + 1),
        .B_W(17)
    ) u_part (
        .clk(clk),
        .a  ({1'b0, on_y != short ? length_y : length_x}),
        .b  (17'h8000 >> (short ? ring_along : along_x || along_y ? ring_across : ring_any)),
        .p  (parts)
    );

    // A side's pixel, rounded to nearest: half a pixel is the carry.
    array_sum #(
        .W(PX_W)
    ) u_low (
        .a     ({PX_W{1'b0}}),
        .choice(step[0]),
        .one   (lo_y[SIDE_W-1:11]),
        .other (lo_x[SIDE_W-1:11]),
        .y     (next_low)
    );

    array_sum #(
        .W(PX_W)
    ) u_high (
        .a     ({PX_W{1'b0}}),
        .choice(step[0]),
        .one   (hi_y[SIDE_W-1:11]),
        .other (hi_x[SIDE_W-1:11]),
        .y     (next_high)
    );

    // a - b is a + ~b + 1.
    array_sum #(
        .W(PX_W)
    ) u_window_low (
        .a     ({{(PX_W - 8) {1'b1}}, ring_less}),
        .choice(step[3]),
        .one   ({low_x, 1'b1}),
        .other ({low_y, 1'b1}),
        .y     (window_low)
    );

    array_sum #(
        .W    (PX_W),
        .ROUND(0)
    ) u_window_high (
        .a     ({{(PX_W - 8) {1'b0}}, ring}),
        .choice(step[3]),
        .one   ({high_x, 1'b0}),
        .other ({high_y, 1'b0}),
        .y     (window_high)
    );

    always @(posedge clk) begin
        second   <= !second;
        second_1 <= second;
        second_2 <= second_1;
        if (second_2) times_y <= times[PX_W+3:0];
        else times_x <= times[PX_W+3:0];
        is_long_x <= !({4'd0, length_x} < times_y);
        is_long_y <= !({4'd0, length_y} < times_x);

        // Of two speeds of 0, that of y.
        along_y <= known && !leans_x;
        along_x <= known && !leans_y && leans_x;

        // Of the pixel of a side, rounded to nearest, and of the length, which the inputs have.
        step <= {step[3:0], start};
        done <= step[4];
        if (start || |step) begin  // otherwise a simulator can leave it out
            low  <= next_low;
            high <= next_high;
            if (step[0]) {low_x, high_x} <= {first, last};
            if (step[1]) {low_y, high_y} <= {first, last};

            room  <= {1'b0, ring_max} - {1'b0, ring_px} - 9'd1;
            ring      <= next_ring;
            ring_less <= ~next_ring;
            if (step[3]) window[4*PX_W-1:2*PX_W] <= {window_low, window_high};
            if (step[4]) window[2*PX_W-1:0] <= {window_low, window_high};
        end

        if (rst) begin
            second   <= 1'b0;
            second_1 <= 1'b0;
            second_2 <= 1'b0;
            step     <= 5'd0;
            done     <= 1'b0;
        end
    end

    wire unused = &{1'b0, sum[0], lo_x, hi_x, lo_y, hi_y, apart, times, spare, parts};

endmodule

`default_nettype wire
