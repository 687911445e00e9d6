// SPDX-License-Identifier: Apache-2.0
// Whether a candidate becomes visible: by support, size, time and the way that it has gone. docs/motion.md, rule S6.
//
// Latency:    6 clocks and birth_travel from start to appears, if the inputs stay.
// Throughput: a candidate at a time.
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

    input  wire                  measure,    // how far is enough, by the sides
    input  wire [SIDE_W:0]       sum,        // of both sides of x and y in turn
    input  wire [SIDE_W:0]       start,      // that at the fourth correction, of the same axis
    input  wire [SIDE_W-1:0]     side_x,
    input  wire [SIDE_W-1:0]     side_y,
    input  wire                  young,      // it cannot be
    input  wire [SUP_W-1:0]      support,
    input  wire [TIME_W-1:0]     age,
    input  wire [15:0]           birth_support,
    input  wire [7:0]            birth_px,
    input  wire [23:0]           birth_ticks,
    input  wire [3:0]            birth_travel,
    output reg                   appears
);

    localparam PX_W   = SIDE_W - 12;
    localparam WIDE_W = SUP_W > 15 ? SUP_W + 1 : 17;

    reg signed [SIDE_W+1:0] way;      // twice the way
    reg  [SIDE_W:0]   sides;
    reg  [SIDE_W+1:0] far, too_near;  // so much must it be, without two pixels; just less with them
    reg  [4:0]        left;           // places that `far` is shifted
    reg               few, old, early, small_x, small_y, goes_far, went_far;
    wire [PX_W-1:0]   least        = {{(PX_W - 8) {1'b0}}, birth_px};
    wire [WIDE_W-1:0] wide_support = {{(WIDE_W - SUP_W) {1'b0}}, support};
    wire [WIDE_W-1:0] wide_birth   = {{(WIDE_W - 16) {1'b0}}, birth_support};
    wire [SIDE_W+2:0] short_of;       // so much, negative where it has gone far

    wire unused = &{1'b0, short_of[SIDE_W+1:0]};

    motion_sum #(
        .W(SIDE_W + 3)
    ) u_short_of (
        .adds (1'b1),
        .a    ({1'b0, too_near}),
        .minus(!way[SIDE_W+1]),
        .b    ({way[SIDE_W+1], way}),
        .y    (short_of)
    );

    always @(posedge clk) begin
        way      <= {sum[SIDE_W], sum} - {start[SIDE_W], start};
        sides    <= {1'b0, side_x} + {1'b0, side_y};
        if (measure) begin
            far  <= {1'b0, sides};
            left <= {1'b0, birth_travel} + 5'd1;
        end else if (left != 5'd0) begin
            far  <= {1'b0, far[SIDE_W+1:1]};
            left <= left - 5'd1;
        end
        too_near <= far + {{(SIDE_W - 12) {1'b0}}, 14'h1fff};
        few      <= wide_support < wide_birth;
        old      <= |age[TIME_W-1:24];
        early    <= age[23:0] < birth_ticks;  // if it is not old
        small_x  <= side_x[SIDE_W-1:12] < least;
        small_y  <= side_y[SIDE_W-1:12] < least;
        goes_far <= short_of[SIDE_W+2];
        went_far <= goes_far;
        appears  <= (goes_far || went_far) && !young && !small_x && !small_y && !few && (old || !early);
    end

endmodule

`default_nettype wire
