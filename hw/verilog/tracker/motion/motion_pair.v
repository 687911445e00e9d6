// SPDX-License-Identifier: Apache-2.0
// Whether a slot and another one are one object that moves together: docs/motion.md, rules M1 and M2. `one` is the slot, `other` the other.
//
// One subtractor for velocities and one for boxes, of which the operands come one after the other. Velocities say along which axis the
// one with more support moves; then boxes are compared, first on the axis across that motion, then along it.
//
// Latency:    22 clocks from start to done; inputs must stay until then.
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

    // ---- velocities: x and y in turn, first those of the one with more support ---------------------------------------------

    reg [4:0]             step;              // one of them is high, from the clock after start
    reg                   on_y;              // of the axis that comes
    reg signed [15:0]     v, own_v;
    reg [14:0]            speed;
    reg signed [16:0]     between;
    reg [14:0]            fast;              // the fastest one's, then by how much velocities may differ, but for 64
    reg [3:0]             fast_down;
    reg                   leads_y;           // the one with more support moves along y
    reg                   agrees, agrees_1;  // velocities differ by no more, on this axis, and on the one before

    reg                   takes_own;         // in this clock
    wire                  less      = one_support < other_support;
    wire [15:0]           taken     = takes_own ? own_v : v;
    wire [15:0]           faster    = {1'b0, speed} - {1'b0, fast};
    wire                  slower    = faster[15];
    reg  signed [17:0]    most;              // by how much they may differ
    wire [17:0]           margin;            // of that, beside their difference: negative where it is more
    wire [14:0]           taken_speed;

    // ---- boxes: both lengths, then the two other differences of a high and a low bound; the least is how far they overlap --

    reg [5:0]              part;                // one of them is high
    reg                    waits;               // for the shift, where that counts
    reg                    along;               // on the axis along the motion
    reg signed [PX_W-1:0]  hi, lo;
    reg signed [GAP_W-1:0] side;
    reg signed [GAP_W-1:0] least;
    reg [PX_W-1:0]         last_side;
    reg                    is_longer;           // the second length is not the smaller one
    reg [PX_W-2:0]         half;                // of the smaller length
    reg [PX_W-1:0]         reach;               // the larger length across, then what is as far
    reg [3:0]              reach_down;
    reg                    abreast, close;      // of the last axis
    reg                    abreast_1, close_1;  // of the one across
    reg [2:0]              last;

    wire                   box_y      = leads_y == along;
    wire                   other_hi   = part[1] || part[3];
    wire                   other_lo   = part[1] || part[2];
    wire [PX_W-1:0]        next_hi, next_lo;
    wire signed [GAP_W:0]  beyond     = {side[GAP_W-1], side} - {least[GAP_W-1], least};  // the sign of a difference is a comparison
    wire                   lower      = beyond[GAP_W];
    wire signed [GAP_W:0]  wider      = {least[GAP_W-1], least} - {3'b000, half};
    wire [PX_W-1:0]        near;
    wire signed [GAP_W-1:0] spare     = least + $signed({1'b0, near});
    wire                   shifted    = fast_down == 4'd0 && reach_down == 4'd0;
    wire                   busy       = |step || |part || waits;
    wire                   lowers_fast  = fast_down != 4'd0 && !step[4];
    wire                   lowers_reach = reach_down != 4'd0 && (along || !part[4]);
    wire                   judges     = waits && (!along || shifted);

    mux4 #(
        .W(PX_W)
    ) u_hi (
        .select({other_hi, box_y}),
        .words ({other_box[0+:PX_W], other_box[2*PX_W+:PX_W], one_box[0+:PX_W], one_box[2*PX_W+:PX_W]}),
        .y     (next_hi)
    );

    mux4 #(
        .W(PX_W)
    ) u_lo (
        .select({other_lo, box_y}),
        .words ({other_box[PX_W+:PX_W], other_box[3*PX_W+:PX_W], one_box[PX_W+:PX_W], one_box[3*PX_W+:PX_W]}),
        .y     (next_lo)
    );

    motion_sum #(
        .W(PX_W)
    ) u_near (
        .adds (along),
        .a    (reach),
        .minus(1'b0),
        .b    ({{(PX_W - 8) {1'b0}}, join_px}),
        .y    (near)
    );

    motion_sum #(
        .W(15)
    ) u_speed (
        .adds (1'b0),
        .a    (15'd0),
        .minus(taken[15]),
        .b    (taken[14:0]),
        .y    (taken_speed)
    );

    motion_sum #(
        .W(18)
    ) u_margin (
        .adds (1'b1),
        .a    (most),
        .minus(!between[16]),
        .b    ({between[16], between}),
        .y    (margin)
    );

    always @(posedge clk) begin
        weaker <= less;
        step <= {step[3:0], start};
        on_y <= start || (busy && !on_y);
        part <= {part[4:0], step[3] || (judges && !along)};
        waits <= part[5] || (waits && !judges);
        last <= {last[1:0], judges && along};
        done <= last[2];
        if (start || busy || |last) begin  // otherwise a simulator can leave it out
            takes_own <= less == (step[1] || step[2]);

            v        <= on_y ? other_v_y : other_v_x;
            own_v    <= on_y ? one_v_y : one_v_x;
            speed    <= taken_speed;
            between  <= {v[15], v} - {own_v[15], own_v};
            most     <= {2'b00, {1'b0, fast[14:6]} + 10'd1, fast[5:0]};
            agrees   <= !margin[17];
            agrees_1 <= agrees;
            if (lowers_fast || step[1] || (|step[4:2] && !slower)) fast <= lowers_fast ? {1'b0, fast[14:1]} : speed;
            if (step[2]) leads_y <= !slower;
            if (step[4]) fast_down <= join_speed;
            else if (lowers_fast) fast_down <= fast_down - 4'd1;

            hi   <= next_hi;
            lo   <= next_lo;
            side <= {hi[PX_W-1], hi} - {lo[PX_W-1], lo};
            if (part[2] || (|part[5:3] && lower)) least <= side;
            if (part[4]) half <= least[PX_W-1:1];
            last_side <= side[PX_W-1:0];
            is_longer <= part[3] && !lower;
            if (lowers_reach || (!along && (part[2] || is_longer)))
                reach <= lowers_reach ? {1'b0, reach[PX_W-1:1]} : part[2] ? side[PX_W-1:0] : last_side;
            if (!along && part[4]) reach_down <= join_reach;
            else if (lowers_reach) reach_down <= reach_down - 4'd1;
            if (judges) begin
                abreast   <= !wider[GAP_W];
                close     <= !spare[GAP_W-1];
                abreast_1 <= abreast;
                close_1   <= close;
                along     <= 1'b1;
            end
            if (start) along <= 1'b0;
            if (last[2]) alike <= agrees && agrees_1 && ((abreast_1 && close) || (abreast && close_1));
        end

        if (rst) begin
            step       <= 5'd0;
            part       <= 6'd0;
            last       <= 3'd0;
            waits      <= 1'b0;
            done       <= 1'b0;
            fast_down  <= 4'd0;
            reach_down <= 4'd0;
        end
    end

    wire unused = &{1'b0, taken, faster, margin[16:0], spare[GAP_W-2:0], beyond, wider};

endmodule

`default_nettype wire
