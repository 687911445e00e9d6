// SPDX-License-Identifier: Apache-2.0
// Merges two tracks: finds the survivor and its new state. The first born survives, at the mean of both centres weighted
// by support, with the larger g and the sum of both supports.
//
// Latency:    5 clocks from take_b to stays, goes, join_g and join_support; `done` is high once join_x and join_y are valid too, after
//          2 W + 5 clocks where MEANS is 2 and 4 W + 10 where it is 1, W the bits of a centre (of the wider axis).
// Throughput: one merge at a time.
// Stall:      none.
// Reset:      nothing is under way.
// Combinational paths: none.
`default_nettype none

module array_merge #(
    parameter POS_X   = 13,  // bits of a centre
    parameter POS_Y   = 13,
    parameter ROUND   = 1,   // centres are rounded to nearest; 0: down
    parameter RADIX_W = 8,   // bits of a radius register
    parameter SUP_W   = 16,  // bits of a support count
    parameter ID_W    = 32,  // bits of a track id
    parameter SLOT_W  = 3,   // bits of a slot number
    parameter MEANS   = 1    // 1: one axis after the other; 2: both at once
) (
    input  wire               clk,

    // the context of one slot, taken twice; its number, id and support follow a clock later
    input  wire               take_a,
    input  wire               take_b,
    input  wire [SLOT_W-1:0]  slot,
    input  wire [ID_W-1:0]    id,
    input  wire [POS_X-1:0]   cm_x,
    input  wire [POS_Y-1:0]   cm_y,
    input  wire [RADIX_W-1:0] g,
    input  wire [SUP_W-1:0]   support,
    input  wire               b_first,  // the second of them was born first: two clocks after take_b

    output reg  [SLOT_W-1:0]  stays,
    output reg  [SLOT_W-1:0]  goes,
    output reg  [ID_W-1:0]    stays_id,
    output wire               done,
    output wire [POS_X-1:0]   join_x,
    output wire [POS_Y-1:0]   join_y,
    output reg  [RADIX_W-1:0] join_g,
    output reg  [SUP_W-1:0]   join_support
);

    reg [SLOT_W-1:0]  a_slot, b_slot;
    reg [ID_W-1:0]    a_id, b_id;
    reg [POS_X-1:0]   a_x, b_x;
    reg [POS_Y-1:0]   a_y, b_y;
    reg [RADIX_W-1:0] a_g, b_g;
    reg [SUP_W-1:0]   a_support, b_support;
    reg               start, take_a_reg, take_b_reg;
    reg               under_way;

    reg            b_older;
    reg  [SUP_W:0] both;

    generate
        if (MEANS == 2) begin : g_both
            wire done_x, done_y;

            assign done = done_x && done_y;

            weighted_mean #(
                .W       (POS_X),
                .WEIGHT_W(SUP_W),
                .ROUND   (ROUND)
            ) u_mean_x (
                .clk     (clk),
                .start   (start),
                .a       (a_x),
                .b       (b_x),
                .weight_b(b_support),
                .weight  (both),
                .done    (done_x),
                .mean    (join_x)
            );
            weighted_mean #(
                .W       (POS_Y),
                .WEIGHT_W(SUP_W),
                .ROUND   (ROUND)
            ) u_mean_y (
                .clk     (clk),
                .start   (start),
                .a       (a_y),
                .b       (b_y),
                .weight_b(b_support),
                .weight  (both),
                .done    (done_y),
                .mean    (join_y)
            );
        end else begin : g_turns
            localparam POS_W = (POS_X > POS_Y) ? POS_X : POS_Y;

            reg              on_y, turns;
            reg  [POS_X-1:0] mean_x;
            wire             done_axis;
            wire [POS_W-1:0] mean;

            assign join_x = mean_x;
            assign join_y = mean[POS_Y-1:0];
            assign done   = on_y && done_axis && !turns;

            weighted_mean #(
                .W       (POS_W),
                .WEIGHT_W(SUP_W),
                .ROUND   (ROUND)
            ) u_mean (
                .clk     (clk),
                .start   (start || turns),
                .a       (on_y ? {{(POS_W - POS_Y) {1'b0}}, a_y} : {{(POS_W - POS_X) {1'b0}}, a_x}),
                .b       (on_y ? {{(POS_W - POS_Y) {1'b0}}, b_y} : {{(POS_W - POS_X) {1'b0}}, b_x}),
                .weight_b(b_support),
                .weight  (both),
                .done    (done_axis),
                .mean    (mean)
            );

            always @(posedge clk) begin
                turns <= 1'b0;
                if (take_b_reg) on_y <= 1'b0;
                else if (under_way && !on_y && done_axis && !start) begin
                    {on_y, turns} <= 2'b11;
                    mean_x        <= mean[POS_X-1:0];
                end
            end
        end
    endgenerate

    always @(posedge clk) begin
        if (take_a) begin
            a_x       <= cm_x;
            a_y       <= cm_y;
            a_g       <= g;
        end
        if (take_b) begin
            b_x       <= cm_x;
            b_y       <= cm_y;
            b_g       <= g;
        end
        take_a_reg <= take_a;
        take_b_reg <= take_b;
        if (take_a_reg) begin
            a_slot    <= slot;
            a_id      <= id;
            a_support <= support;
        end
        if (take_b_reg) begin
            b_slot    <= slot;
            b_id      <= id;
            b_support <= support;
        end
        start <= take_b_reg;
        if (under_way) begin
            if (done && !start) under_way <= 1'b0;
            if (start) b_older <= b_first;
            stays        <= b_older ? b_slot : a_slot;
            goes         <= b_older ? a_slot : b_slot;
            stays_id     <= b_older ? b_id : a_id;
            join_g       <= (b_g > a_g) ? b_g : a_g;
            both         <= {1'b0, a_support} + {1'b0, b_support};
            join_support <= both[SUP_W] ? {SUP_W{1'b1}} : both[SUP_W-1:0];
        end
        if (take_b_reg) under_way <= 1'b1;  // also where a merge that a reset has broken off ends in this clock
    end

endmodule

`default_nettype wire
