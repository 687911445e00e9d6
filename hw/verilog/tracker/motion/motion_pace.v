// SPDX-License-Identifier: Apache-2.0
// The velocity that records state: the displacement of the box per motion step, averaged twice. docs/motion.md, rule V1.
//
// Each axis has a word in two memories. Words of x and y are read in turn, and both means go through one circuit, first that of displacements.
// `at` must be there 3 clocks before a command; it, sums and sides must stay until that is carried out.
//
// Latency:    14 clocks from `follow`, 7 from `begins`, 2 from `settle` until memory has it; 4 from `at` to `v_x` and `v_y`.
// Throughput: a command at a time.
// Stall:      none.
// Reset:      no command; memory is written by `begins` before it counts.
// Combinational paths: none.
`default_nettype none

module motion_pace #(
    parameter SLOT_W = 3,
    parameter SIDE_W = 25
) (
    input  wire              clk,
    input  wire              rst,

    input  wire [SLOT_W-1:0] at,      // the slot that is worked on

    // commands
    input  wire              begins,  // its fourth correction
    input  wire              settle,  // what it was united with is no displacement
    input  wire              follow,  // a motion step

    input  wire [31:0]       v,       // velocity of its box, y, x, 4 clocks after `begins`
    input  wire [SIDE_W:0]   sum_x,   // of both sides
    input  wire [SIDE_W:0]   sum_y,
    input  wire [SIDE_W-1:0] side_x,  // hi - lo, at least 0
    input  wire [SIDE_W-1:0] side_y,

    output reg  [SIDE_W-1:0] shorter, // of both sides
    output reg  [15:0]       v_x,     // the stated velocity
    output reg  [15:0]       v_y
);

    localparam ADDR_W   = SLOT_W > 6 ? SLOT_W + 1 : 7;  // more than 64 words, for block RAM on every device
    localparam SLOW_MAX = 4;   // log2 of the steps that a mean is over, at most
    localparam WAS_W    = 20;  // bits that count of a place
    localparam PACE_W   = 17;  // bits of a displacement in a step

    // Of the axis that was read, y if `on_y`; that before is the other one.
    reg                      on_y;
    wire [WAS_W-1:0]         was;
    wire signed [PACE_W-1:0] pace, stated;
    wire signed [WAS_W-1:0]  sum   = on_y ? sum_y[WAS_W-1:0] : sum_x[WAS_W-1:0];
    reg         [WAS_W-1:0]  sum_1;

    reg  [6:1]               begun;      // a one for each clock since `begins`,
    reg  [13:1]              followed;   // since `follow`,
    reg                      settle_1;   // and since `settle`
    wire                     begins_now = begun[5] || begun[6];
    wire                     follows_now = followed[12] || followed[13];

    // ---- how many steps the means are over -------------------------------------------------------------------------------

    reg  [PACE_W-1:0]          speed_1, speed_2, speed;
    wire [PACE_W-1:0]          size;      // of the velocity that was read
    reg  [1:0]                 slow;      // log2 of them, less 1
    reg  [SIDE_W-1:0]          way_slow;  // in 2^slow steps
    wire                       too_slow = slow != 2'd0 && shorter < way_slow;

    motion_sum #(
        .W(PACE_W)
    ) u_size (
        .adds (1'b0),
        .a    ({PACE_W{1'b0}}),
        .minus(stated[PACE_W-1]),
        .b    (stated),
        .y    (size)
    );

    // ---- the pipeline: an axis enters it in every second clock and goes through its stages 3 to 5 twice ------------------------

    reg  signed [WAS_W-1:0]    way_1;
    reg  signed [PACE_W-1:0]   way_2, mean_5, mean_6, mean_7, mean_8, mean_9;
    wire        [PACE_W:0]     more_2;
    wire        [PACE_W+5:0]   steps_4;     // 16 times the step: a shift to the right is a product with a power of two
    wire        [PACE_W-1:0]   step_4  = steps_4[4+:PACE_W];
    wire                       half_4  = steps_4[3];  // what is rounded off is half or more: step_4 is one more
    reg                        again;       // in stages 2 and 4: the mean of the mean
    wire                       is_wide = way_1[WAS_W-1:PACE_W-1] != {(WAS_W + 1 - PACE_W) {way_1[WAS_W-1]}};
    wire signed [PACE_W-1:0]   value   = again ? stated : pace;
    wire        [PACE_W-1:0]   sum_4;
    wire        [1:0]          next_slow = followed[2] ? 2'd3 : too_slow ? slow - 2'd1 : slow;

    // aim - value: a - b is a + ~b + 1.
    array_sum #(
        .W(PACE_W + 1)
    ) u_more (
        .a     ({!value[PACE_W-1], ~value}),
        .choice(again),
        .one   ({mean_6[PACE_W-1], mean_6, 1'b1}),
        .other ({way_2[PACE_W-1], way_2, 1'b1}),
        .y     (more_2)
    );

    multiplier #(
        .A_W(PACE_W + 1),
        .B_W(5)
    ) u_steps (
        .clk(clk),
        .a  (more_2),
        .b  (5'd8 >> next_slow),
        .p  (steps_4)
    );

    array_sum #(
        .W(PACE_W)
    ) u_mean (
        .a     (step_4),
        .choice(again),
        .one   ({stated, half_4}),
        .other ({pace, half_4}),
        .y     (sum_4)
    );

    function [ADDR_W-1:0] place;
        input [SLOT_W-1:0] slot;
        input              is_y;
        place = {{(ADDR_W - SLOT_W) {1'b0}}, slot} | ({{(ADDR_W - 1) {1'b0}}, is_y} << SLOT_W);
    endfunction

    block_memory #(
        .W    (WAS_W),
        .DEPTH(1 << ADDR_W)
    ) u_places (
        .clk          (clk),
        .write        (begins_now || settle || settle_1 || follows_now),
        .write_address(place(at, !on_y)),
        .write_data   (sum_1),
        .read_enable  (1'b1),
        .read_address (place(at, on_y)),
        .out_enable   (1'b1),
        .read_data    (was)
    );

    block_memory #(
        .W    (2 * PACE_W),
        .DEPTH(1 << ADDR_W)
    ) u_paces (
        .clk          (clk),
        .write        (begins_now || follows_now),
        .write_address(place(at, !on_y)),
        .write_data   (begins_now ? {2{on_y ? v[15:0] : v[31:16], 1'b0}} : {mean_9, mean_5}),
        .read_enable  (1'b1),
        .read_address (place(at, on_y)),
        .out_enable   (1'b1),
        .read_data    ({pace, stated})
    );

    always @(posedge clk) begin
        on_y     <= !on_y;
        sum_1    <= sum;
        settle_1 <= settle;
        begun    <= {begun[5:1], begins};
        followed <= {followed[12:1], follow};
        if (on_y) v_y <= stated[PACE_W-1:1];
        else v_x <= stated[PACE_W-1:1];

        speed_1 <= size;
        speed_2 <= speed_1;
        speed   <= speed_2 < speed_1 ? speed_1 : speed_2;
        shorter <= side_x < side_y ? side_x : side_y;
        if (followed[2]) begin
            way_slow <= {{(SIDE_W - PACE_W - SLOW_MAX) {1'b0}}, speed, {SLOW_MAX{1'b0}}};
        end else if (too_slow) way_slow <= way_slow >> 1;
        slow <= next_slow;

        // Of the axes that are read 3 and 4 clocks after `follow`: both come by again in every second clock.
        way_1  <= sum - was;
        way_2  <= is_wide ? {way_1[WAS_W-1], {(PACE_W - 1) {!way_1[WAS_W-1]}}} : way_1[PACE_W-1:0];
        again  <= followed[8] || followed[9] || followed[10] || followed[11];
        mean_5 <= sum_4;
        {mean_9, mean_8, mean_7, mean_6} <= {mean_8, mean_7, mean_6, mean_5};
        if (rst) begin
            on_y     <= 1'b0;
            begun    <= 6'd0;
            followed <= 13'd0;
        end
    end

    wire unused = &{1'b0, sum_x[SIDE_W:WAS_W], sum_y[SIDE_W:WAS_W], steps_4};

endmodule

`default_nettype wire
