// SPDX-License-Identifier: Apache-2.0
// Whether a candidate becomes visible: by support, size, time and the way that it has gone. docs/motion.md, "A motion step of a slot",
// point 5.
//
// Latency:    5 clocks from the inputs to appears.
// Throughput: a candidate per clock.
// Stall:      none.
// Reset:      none, nothing is used before it was computed.
// Combinational paths: none.
`default_nettype none

module motion_birth #(
    parameter SIDE_W = 25,
    parameter SUP_W  = 16,
    parameter TIME_W = 48
) (
    input  wire                  clk,

    input  wire [SIDE_W:0]       sum_x,      // of both sides
    input  wire [SIDE_W:0]       sum_y,
    input  wire [SIDE_W-1:0]     side_x,
    input  wire [SIDE_W-1:0]     side_y,
    input  wire [2*SIDE_W+1:0]   start,      // sum_x and sum_y at the fourth correction
    input  wire                  too_small,  // or too young
    input  wire [SUP_W-1:0]      support,
    input  wire [TIME_W-1:0]     age,
    input  wire [15:0]           birth_support,
    input  wire [23:0]           birth_ticks,
    input  wire [3:0]            birth_travel,
    output reg                   appears
);

    reg  [SIDE_W+1:0] way_x, way_y, abs_x, abs_y;  // twice the way
    reg  [SIDE_W:0]   sides;
    reg  [SIDE_W+1:0] far_2, far_3;                // so much must it be
    reg               few, early, goes_far;
    wire [SIDE_W:0]   start_x, start_y;
    wire [SUP_W+15:0] wide_support = {16'd0, support};
    wire [SUP_W+15:0] wide_birth   = {{SUP_W{1'b0}}, birth_support};

    assign {start_x, start_y} = start;

    always @(posedge clk) begin
        way_x    <= {sum_x[SIDE_W], sum_x} - {start_x[SIDE_W], start_x};
        way_y    <= {sum_y[SIDE_W], sum_y} - {start_y[SIDE_W], start_y};
        sides    <= {1'b0, side_x} + {1'b0, side_y};
        abs_x    <= way_x[SIDE_W+1] ? -way_x : way_x;
        abs_y    <= way_y[SIDE_W+1] ? -way_y : way_y;
        far_2    <= {1'b0, sides} >> ({1'b0, birth_travel} + 5'd1);
        far_3    <= far_2 + {{(SIDE_W - 12) {1'b0}}, 14'h2000};
        few      <= wide_support < wide_birth;
        early    <= age < {{(TIME_W - 24) {1'b0}}, birth_ticks};
        goes_far <= abs_x >= far_3 || abs_y >= far_3;
        appears  <= goes_far && !too_small && !few && !early;
    end

endmodule

`default_nettype wire
