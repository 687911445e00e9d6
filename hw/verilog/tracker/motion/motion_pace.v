// SPDX-License-Identifier: Apache-2.0
// The velocity that records state: the displacement of the box per motion step, averaged twice. docs/motion.md, rule V1.
//
// Both axes go through one pipeline, y a clock after x. `at`, sums and sides must stay until a command is carried out.
//
// Latency:    13 clocks from `follow`, 6 from `begins`, 1 from `settle` until memory has it; 2 from `at` to `v_x` and `v_y`.
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

    output wire [15:0]       v_x,     // the stated velocity
    output wire [15:0]       v_y
);

    localparam ADDR_W   = SLOT_W > 7 ? SLOT_W : 7;  // more than 64 words, for block RAM on every device
    localparam SLOW_MAX = 4;   // log2 of the steps that a mean is over, at most
    localparam WAS_W    = 20;  // bits that count of a place
    localparam PACE_W   = 17;  // bits of a displacement in a step
    localparam FOUND    = 4;   // bit of `followed` that is high while y enters the pipeline; two clocks later `slow` is known

    wire [ADDR_W-1:0]        address = {{(ADDR_W - SLOT_W) {1'b0}}, at};
    wire [WAS_W-1:0]         was_x, was_y;
    wire signed [PACE_W-1:0] pace_x, pace_y, stated_x, stated_y;
    reg  [3:0]               begun;      // a one for each clock since `begins`
    reg  [FOUND+6:0]         followed;   // and since `follow`
    reg                      begins_now, follows_now;

    reg  signed [PACE_W-1:0] new_pace_x, new_pace_y, new_stated_x, new_stated_y;

    block_memory #(
        .W    (2 * WAS_W + 4 * PACE_W),
        .DEPTH(1 << ADDR_W)
    ) u_paces (
        .clk          (clk),
        .write        (begins_now || settle || follows_now),
        .write_address(address),
        .write_data   ({
            sum_x[WAS_W-1:0], sum_y[WAS_W-1:0],
            begins_now ? {2{v[15:0], 1'b0, v[31:16], 1'b0}}
            : settle ? {pace_x, pace_y, stated_x, stated_y}
            : {new_pace_x, new_pace_y, new_stated_x, new_stated_y}
        }),
        .read_enable  (1'b1),
        .read_address (address),
        .out_enable   (1'b1),
        .read_data    ({was_x, was_y, pace_x, pace_y, stated_x, stated_y})
    );

    assign v_x = stated_x[PACE_W-1:1];
    assign v_y = stated_y[PACE_W-1:1];

    // ---- how many steps the means are over -------------------------------------------------------------------------------

    reg  [PACE_W-1:0]          speed_x, speed_y, speed;
    reg  [SIDE_W-1:0]          shorter;
    reg  [2:0]                 slow;
    reg  [SIDE_W-1:0]          way_slow;  // in 2^slow steps
    wire                       too_slow = slow != 3'd1 && way_slow > shorter;

    // ---- the pipeline: x, then y -----------------------------------------------------------------------------------------

    reg  signed [WAS_W-1:0]    way_1;
    reg  signed [PACE_W:0]     more_2, more_5;
    reg  signed [PACE_W-1:0]   step_3, pace_4, step_6;
    wire                       is_wide = way_1[WAS_W-1:PACE_W-1] != {(WAS_W + 1 - PACE_W) {way_1[WAS_W-1]}};
    wire signed [PACE_W-1:0]   way     = is_wide ? {way_1[WAS_W-1], {(PACE_W - 1) {!way_1[WAS_W-1]}}} : way_1[PACE_W-1:0];

    // A difference to nearest, in parts of 2^slow.
    function signed [PACE_W-1:0] part_of;
        input signed [PACE_W:0] more;
        input        [2:0]      places;
        reg signed   [PACE_W+1:0] half;
        begin
            half    = {more[PACE_W], more} + (({{(PACE_W + 1) {1'b0}}, 1'b1} << places) >> 1);
            half    = half >>> places;
            part_of = half[PACE_W-1:0];
        end
    endfunction

    always @(posedge clk) begin
        begun       <= {begun[2:0], begins};
        begins_now  <= begun[3];
        followed    <= {followed[FOUND+5:0], follow};
        follows_now <= followed[FOUND+6];

        speed_x <= stated_x[PACE_W-1] ? -stated_x : stated_x;
        speed_y <= stated_y[PACE_W-1] ? -stated_y : stated_y;
        speed   <= speed_x > speed_y ? speed_x : speed_y;
        shorter <= side_x < side_y ? side_x : side_y;
        if (followed[1]) begin
            slow     <= SLOW_MAX;
            way_slow <= {{(SIDE_W - PACE_W - SLOW_MAX) {1'b0}}, speed, {SLOW_MAX{1'b0}}};
        end else if (too_slow) begin
            slow     <= slow - 3'd1;
            way_slow <= way_slow >> 1;
        end

        way_1  <= followed[FOUND] ? sum_y[WAS_W-1:0] - was_y : sum_x[WAS_W-1:0] - was_x;
        more_2 <= {way[PACE_W-1], way} - (followed[FOUND+1] ? {pace_y[PACE_W-1], pace_y} : {pace_x[PACE_W-1], pace_x});
        step_3 <= part_of(more_2, slow);
        pace_4 <= (followed[FOUND+3] ? pace_y : pace_x) + step_3;
        more_5 <= {pace_4[PACE_W-1], pace_4} - (followed[FOUND+4] ? {stated_y[PACE_W-1], stated_y} : {stated_x[PACE_W-1], stated_x});
        step_6 <= part_of(more_5, slow);
        if (followed[FOUND+3]) new_pace_x <= pace_4;
        if (followed[FOUND+4]) new_pace_y <= pace_4;
        if (followed[FOUND+5]) new_stated_x <= stated_x + step_6;
        if (followed[FOUND+6]) new_stated_y <= stated_y + step_6;
        if (rst) begin
            begun       <= 4'd0;
            followed    <= {(FOUND + 7) {1'b0}};
            begins_now  <= 1'b0;
            follows_now <= 1'b0;
        end
    end

    wire unused = &{1'b0, sum_x[SIDE_W:WAS_W], sum_y[SIDE_W:WAS_W]};

endmodule

`default_nettype wire
