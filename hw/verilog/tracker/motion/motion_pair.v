// SPDX-License-Identifier: Apache-2.0
// Whether a slot and another one are one object that moves together: docs/motion.md, "Merging". `one` is the slot, `other` the other.
//
// Both axes go through one circuit, x first; what was found on x is then in the registers named _x.
//
// Latency:    9 clocks from start to done, and as many as the larger of both shifts; inputs must stay until then.
// Throughput: a pair at a time.
// Stall:      outputs stay until a clock after the next start.
// Reset:      done is low until the next start has come through.
// Combinational paths: none.
`default_nettype none

module motion_pair #(
    parameter PX_W  = 13,  // bits of a bound in pixels, signed
    parameter SUP_W = 16   // bits of a support count
) (
    input  wire               clk,
    input  wire               rst,

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

    output reg                done,
    output reg                alike,       // they move together, and can be one object
    output reg                weaker       // one has less support than the other
);

    localparam GAP_W = PX_W + 1;

    reg [6:0] step;              // one of them is high, from the clock after start: x is in the first stage, y is
    reg       shifts;
    wire      on_y = step[0];
    wire      sides_come = step[1] || step[2];  // to the third stage

    // ---- first stage: one axis --------------------------------------------------------------------------------------------

    reg signed [PX_W-1:0] lo, hi, own_lo, own_hi;
    reg signed [15:0]     v, own_v;

    // ---- second ------------------------------------------------------------------------------------------------------------

    reg signed [PX_W-1:0] from, to;             // what lies between them
    reg [PX_W-1:0]        side, own_side;
    reg [14:0]            speed, own_speed;
    reg signed [16:0]     between;

    // ---- third: stays, and x is kept when y comes --------------------------------------------------------------------------

    reg signed [GAP_W-1:0] shared, shared_x;    // how far they overlap; negative: how far they are apart
    reg [PX_W-1:0]         less, less_x, more, more_x;
    reg [14:0]             fast, fast_x, lead, lead_x;  // the faster one's, that of the one with more support
    reg [15:0]             apart, apart_x;

    // ---- both axes ---------------------------------------------------------------------------------------------------------

    reg                    leads_y;             // that one moves along y
    reg [14:0]             allowed;             // by how much velocities may differ
    reg [PX_W-1:0]         reach;               // along the motion
    reg [3:0]              allowed_down, reach_down;
    reg                    together, abreast_x, abreast_y, close_x, close_y;

    wire signed [GAP_W-1:0] half_x  = {2'b00, less_x[PX_W-1:1]};
    wire signed [GAP_W-1:0] half_y  = {2'b00, less[PX_W-1:1]};
    wire [PX_W-1:0]         near_px = {{(PX_W - 8) {1'b0}}, join_px};
    wire signed [GAP_W-1:0] spare_x = shared_x + $signed({1'b0, leads_y ? near_px : reach});
    wire signed [GAP_W-1:0] spare_y = shared + $signed({1'b0, leads_y ? reach : near_px});
    wire [15:0]             most    = {1'b0, allowed} + 16'd64;
    wire                    shifted = allowed_down == 4'd0 && reach_down == 4'd0;

    always @(posedge clk) begin
        step   <= {step[5:0], start};
        weaker <= one_support < other_support;

        lo     <= on_y ? other_box[PX_W+:PX_W] : other_box[3*PX_W+:PX_W];
        hi     <= on_y ? other_box[0+:PX_W] : other_box[2*PX_W+:PX_W];
        own_lo <= on_y ? one_box[PX_W+:PX_W] : one_box[3*PX_W+:PX_W];
        own_hi <= on_y ? one_box[0+:PX_W] : one_box[2*PX_W+:PX_W];
        v      <= on_y ? other_v_y : other_v_x;
        own_v  <= on_y ? one_v_y : one_v_x;

        from      <= own_lo > lo ? own_lo : lo;
        to        <= own_hi < hi ? own_hi : hi;
        side      <= hi - lo;
        own_side  <= own_hi - own_lo;
        speed     <= v[15] ? -v[14:0] : v[14:0];
        own_speed <= own_v[15] ? -own_v[14:0] : own_v[14:0];
        between   <= {v[15], v} - {own_v[15], own_v};

        if (sides_come) begin
            shared <= {to[PX_W-1], to} - {from[PX_W-1], from};
            less   <= side < own_side ? side : own_side;
            more   <= side < own_side ? own_side : side;
            fast   <= speed > own_speed ? speed : own_speed;
            lead   <= weaker ? speed : own_speed;
            apart  <= between[16] ? -between[15:0] : between[15:0];
            {shared_x, less_x, more_x, fast_x, lead_x, apart_x} <= {shared, less, more, fast, lead, apart};
        end

        if (step[3]) begin
            leads_y      <= lead >= lead_x;
            allowed      <= fast > fast_x ? fast : fast_x;
            allowed_down <= join_speed;
            reach_down   <= join_reach;
        end
        if (step[4]) begin
            reach  <= leads_y ? more_x : more;
            shifts <= 1'b1;
        end
        if (shifts) begin
            if (allowed_down != 4'd0) begin
                allowed      <= {1'b0, allowed[14:1]};
                allowed_down <= allowed_down - 4'd1;
            end
            if (reach_down != 4'd0) begin
                reach      <= {1'b0, reach[PX_W-1:1]};
                reach_down <= reach_down - 4'd1;
            end
            shifts <= !shifted;
        end
        step[5] <= shifts && shifted;
        if (step[5]) begin
            together  <= apart <= most && apart_x <= most;
            abreast_x <= shared_x >= half_x;
            abreast_y <= shared >= half_y;
            close_x   <= !spare_x[GAP_W-1];
            close_y   <= !spare_y[GAP_W-1];
        end
        if (step[6]) alike <= together && ((abreast_x && close_y) || (abreast_y && close_x));
        done <= step[6];
        if (rst) begin
            step   <= 7'd0;
            shifts <= 1'b0;
            done   <= 1'b0;
        end
    end

    wire unused = &{1'b0, less[0], less_x[0], spare_x[GAP_W-2:0], spare_y[GAP_W-2:0]};

endmodule

`default_nettype wire
