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
    input  wire [SIDE_W-13:0]    shorter,    // of both, whole pixels
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
    reg  [SIDE_W+1:0] less_far;       // the complement of: so much must it be, without two pixels
    reg  [4:0]        left;           // places that it is shifted
    reg               few, old, early, narrow, went_far;
    reg  [SIDE_W+2:0] over;           // by how much twice the way is more than that, less 1
    wire [PX_W-1:0]   least        = {{(PX_W - 8) {1'b0}}, birth_px};
    wire [WIDE_W-1:0] wide_support = {{(WIDE_W - SUP_W) {1'b0}}, support};
    wire [WIDE_W-1:0] wide_birth   = {{(WIDE_W - 16) {1'b0}}, birth_support};
    wire [SIDE_W+2:0] next_over;
    wire              goes_far     = !over[SIDE_W+2] && (|over[SIDE_W+1:13] || &over[12:0]);  // by two pixels of both sides

    motion_sum #(
        .W(SIDE_W + 3)
    ) u_over (
        .adds (1'b1),
        .a    ({1'b1, less_far}),
        .minus(way[SIDE_W+1]),
        .b    ({way[SIDE_W+1], way}),
        .y    (next_over)
    );

    always @(posedge clk) begin
        way      <= {sum[SIDE_W], sum} - {start[SIDE_W], start};
        sides    <= {1'b0, side_x} + {1'b0, side_y};
        if (measure) begin
            less_far <= {1'b1, ~sides};
            left <= {1'b0, birth_travel} + 5'd1;
        end else if (left != 5'd0) begin
            less_far <= {1'b1, less_far[SIDE_W+1:1]};
            left <= left - 5'd1;
        end
        over     <= next_over;
        few      <= wide_support < wide_birth;
        old      <= |age[TIME_W-1:24];
        early    <= age[23:0] < birth_ticks;  // if it is not old
        narrow    <= shorter < least;
        went_far <= goes_far;
        appears  <= (goes_far || went_far) && !young && !narrow && !few && (old || !early);
    end

endmodule

`default_nettype wire
