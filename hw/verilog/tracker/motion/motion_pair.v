// SPDX-License-Identifier: Apache-2.0
// Whether a slot and another one are one object that moves together: docs/motion.md, "Merging". `one` is the slot, `other` the other.
//
// Latency:    6 clocks from start to alike; inputs of `other` need stay for one, all others until then.
// Throughput: a pair every sixth clock.
// Stall:      outputs stay until a clock after the next start.
// Reset:      none, nothing is used before it was computed.
// Combinational paths: none.
`default_nettype none

module motion_pair #(
    parameter PX_W  = 13,  // bits of a bound in pixels, signed
    parameter SUP_W = 16   // bits of a support count
) (
    input  wire               clk,

    input  wire               start,
    input  wire [4*PX_W-1:0]  one_box,     // lo and hi on x, lo and hi on y
    input  wire signed [15:0] one_v_x,
    input  wire signed [15:0] one_v_y,
    input  wire [SUP_W-1:0]   one_support,
    input  wire [4*PX_W-1:0]  other_box,
    input  wire signed [15:0] other_v_x,
    input  wire signed [15:0] other_v_y,
    input  wire [SUP_W-1:0]   other_support,

    input  wire [3:0]         join_speed,
    input  wire [3:0]         join_reach,
    input  wire [7:0]         join_px,

    output reg                alike,       // they move together, and can be one object
    output reg                weaker       // one has less support than the other
);

    localparam GAP_W = PX_W + 1;

    reg [4:0] step;  // one of them is high: the values of the step before are there

    // ---- the other's ---------------------------------------------------------------------------------------------------

    reg signed [PX_W-1:0] box_lo_x, box_hi_x, box_lo_y, box_hi_y;
    reg signed [15:0]     v_x, v_y;

    wire signed [PX_W-1:0] own_lo_x = one_box[3*PX_W+:PX_W];
    wire signed [PX_W-1:0] own_hi_x = one_box[2*PX_W+:PX_W];
    wire signed [PX_W-1:0] own_lo_y = one_box[PX_W+:PX_W];
    wire signed [PX_W-1:0] own_hi_y = one_box[0+:PX_W];

    // ---- velocities ----------------------------------------------------------------------------------------------------

    wire [14:0] speed_x     = v_x[15] ? -v_x[14:0] : v_x[14:0];
    wire [14:0] speed_y     = v_y[15] ? -v_y[14:0] : v_y[14:0];
    wire [14:0] own_speed_x = one_v_x[15] ? -one_v_x[14:0] : one_v_x[14:0];
    wire [14:0] own_speed_y = one_v_y[15] ? -one_v_y[14:0] : one_v_y[14:0];
    wire signed [16:0] between_x = {v_x[15], v_x} - {one_v_x[15], one_v_x};
    wire signed [16:0] between_y = {v_y[15], v_y} - {one_v_y[15], one_v_y};

    reg [14:0] fast, own_fast;       // the faster axis of each
    reg [15:0] apart_x, apart_y;
    reg        along_y, own_along_y; // its motion is along y
    reg        own_leads;            // one has at least as much support
    reg [14:0] fastest, allowed;
    reg        leads_y;
    wire [15:0] most = {1'b0, allowed} + 16'd64;

    // ---- boxes ---------------------------------------------------------------------------------------------------------

    reg signed [PX_W-1:0] from_x, to_x, from_y, to_y;  // what lies between them
    reg [PX_W-1:0] less_x, more_x, less_y, more_y;     // their sides
    reg [PX_W-1:0] side_x, side_y, own_side_x, own_side_y;
    reg signed [GAP_W-1:0] shared_x, shared_y;  // how far they overlap; negative: how far they are apart
    reg [PX_W-1:0] near_x, near_y;
    reg together, abreast_x, abreast_y, close_x, close_y;

    wire signed [GAP_W-1:0] half_x = {2'b00, less_x[PX_W-1:1]};
    wire signed [GAP_W-1:0] half_y = {2'b00, less_y[PX_W-1:1]};
    wire signed [GAP_W-1:0] spare_x = shared_x + $signed({1'b0, near_x});
    wire signed [GAP_W-1:0] spare_y = shared_y + $signed({1'b0, near_y});

    always @(posedge clk) begin
        step <= {step[3:0], start};
        if (start) begin
            {box_lo_x, box_hi_x, box_lo_y, box_hi_y} <= other_box;
            v_x       <= other_v_x;
            v_y       <= other_v_y;
            weaker    <= one_support < other_support;
            own_leads <= one_support >= other_support;
        end
        if (step[0]) begin
            fast        <= speed_x > speed_y ? speed_x : speed_y;
            own_fast    <= own_speed_x > own_speed_y ? own_speed_x : own_speed_y;
            along_y     <= speed_y >= speed_x;
            own_along_y <= own_speed_y >= own_speed_x;
            apart_x     <= between_x[16] ? -between_x[15:0] : between_x[15:0];
            apart_y     <= between_y[16] ? -between_y[15:0] : between_y[15:0];
            from_x      <= own_lo_x > box_lo_x ? own_lo_x : box_lo_x;
            to_x        <= own_hi_x < box_hi_x ? own_hi_x : box_hi_x;
            from_y      <= own_lo_y > box_lo_y ? own_lo_y : box_lo_y;
            to_y        <= own_hi_y < box_hi_y ? own_hi_y : box_hi_y;
            side_x      <= box_hi_x - box_lo_x;
            side_y      <= box_hi_y - box_lo_y;
            own_side_x  <= own_hi_x - own_lo_x;
            own_side_y  <= own_hi_y - own_lo_y;
        end
        if (step[1]) begin
            fastest  <= fast > own_fast ? fast : own_fast;
            leads_y  <= own_leads ? own_along_y : along_y;
            shared_x <= {to_x[PX_W-1], to_x} - {from_x[PX_W-1], from_x};
            shared_y <= {to_y[PX_W-1], to_y} - {from_y[PX_W-1], from_y};
            less_x   <= side_x < own_side_x ? side_x : own_side_x;
            less_y   <= side_y < own_side_y ? side_y : own_side_y;
            more_x   <= side_x > own_side_x ? side_x : own_side_x;
            more_y   <= side_y > own_side_y ? side_y : own_side_y;
        end
        if (step[2]) begin
            allowed   <= fastest >> join_speed;
            abreast_x <= shared_x >= half_x;
            abreast_y <= shared_y >= half_y;
            near_x    <= leads_y ? {{(PX_W - 8) {1'b0}}, join_px} : more_y >> join_reach;
            near_y    <= leads_y ? more_x >> join_reach : {{(PX_W - 8) {1'b0}}, join_px};
        end
        if (step[3]) begin
            together <= apart_x <= most && apart_y <= most;
            close_x  <= !spare_x[GAP_W-1];
            close_y  <= !spare_y[GAP_W-1];
        end
        if (step[4]) alike <= together && ((abreast_x && close_y) || (abreast_y && close_x));
    end

    wire unused = &{1'b0, less_x[0], less_y[0], spare_x[GAP_W-2:0], spare_y[GAP_W-2:0]};

endmodule

`default_nettype wire
