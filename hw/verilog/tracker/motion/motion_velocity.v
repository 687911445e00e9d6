// SPDX-License-Identifier: Apache-2.0
// The correction of the velocities on x and y, one after the other: docs/motion.md, rule C3.
//
// d·2^-g over the time since the last correction, by the leading bit of that time and the three bits below it, which motion_inverse.v finds.
// The gain rises with the corrections of the axis that went one way, this one among them. The shift is to the left by up to 7 with the
// factor of the product, then to the right in whole bytes: two of them, four or six, then one.
//
// Latency:    3 clocks from an axis' offsets to its run_next, 14 to its v_next.
// Throughput: an axis per clock.
// Stall:      none. Inputs that have no axis must stay from start to turn; `leading` and `inverse` need not be there before the second
//             clock after start.
// Reset:      nothing is under way.
// Combinational paths: none.
`default_nettype none

module motion_velocity #(
    parameter OFF_W = 26  // bits of an offset, 2^-12 px, signed
) (
    input  wire                    clk,
    input  wire                    rst,

    input  wire                    start,      // the offsets are those of x; in the next clock, of y
    input  wire signed [OFF_W-1:0] low,        // offsets of both sides
    input  wire signed [OFF_W-1:0] high,
    input  wire                    slower,     // take what both sides have in common
    input  wire [4:0]              leading,    // position of the leading bit of the time
    input  wire [6:0]              inverse,    // of that bit and the three below it
    input  wire [3:0]              gain,       // g, 1 to 13, of which
    input  wire [3:0]              room,       // so much may be taken off by corrections that go one way
    input  wire signed [3:0]       run_x,      // how many went up, or down if negative; two clocks after start
    input  wire signed [3:0]       run_y,      // three clocks after it
    input  wire [4:0]              step_log2,
    input  wire [14:0]             speed_max,
    input  wire signed [15:0]      v,          // of the axis, 10 clocks later

    output wire                    ran,        // run_next is that of x; in the next clock, of y
    output reg signed [3:0]        run_next,
    output wire                    turn,       // v_next is that of x; in the next clock, of y
    output reg signed [15:0]       v_next
);

    localparam D_W = OFF_W + 1;  // bits of d
    localparam LOW = 17;         // of its lower part
    localparam P_W = D_W + 15;   // of its product with up to 120 << 7
    localparam A_W = 25;         // what is left of the product after each of the two shifts to the right
    localparam B_W = 17;

    // (d · inverse) >> k is (d · inverse << 7 - down % 8 << 8) >> 8·(down / 8), k = down - 15.
    reg  [5:0]  most_down, down; // 4 to 59
    reg  [13:0] factor;
    reg  [2:0]  bytes_5, bytes_6, bytes_7, bytes_8;
    reg         byte_9;

    reg [13:0]               begun;
    reg signed [OFF_W-1:0]   low_1, high_1;
    reg signed [D_W-1:0]     way_2, way_3, way_4, way_5;
    wire [D_W-1:0]           next_way;
    reg  [1:0]               low_any, high_any;  // it is not 0: by its halves
    reg                      low_less;
    reg signed [P_W-1:0]     product;
    reg signed [A_W-1:0]     part_9;
    reg signed [B_W-1:0]     part_10, change;
    reg                      over_9, over_10, sign_9, sign_10;
    reg signed [15:0]        v_11, sum_13;
    reg signed [17:0]        sum;
    reg                      beyond;        // what sum_13 comes from is beyond the limit
    reg signed [15:0]        limit;         // with its sign

    wire                  low_rises  = !low_1[OFF_W-1] && |low_any;
    wire                  high_rises = !high_1[OFF_W-1] && |high_any;
    wire signed [D_W-1:0] less     = {low[OFF_W-1], low} - {high[OFF_W-1], high};
    wire                  takes_low  = slower && low_less == low_rises;  // twice, as the smaller one
    wire                  takes_high = slower && low_less != low_rises;
    wire                  sign_8   = product[P_W-1];
    wire [A_W+47:0]       wide_8   = {{(A_W + 40 - P_W) {sign_8}}, product, 8'd0};
    wire signed [3:0]     run      = begun[1] ? run_x : run_y;
    wire [3:0]            size     = run_next[3] ? -run_next : run_next;
    wire [3:0]            raised   = size < 4'd2 ? 4'd0 : size - 4'd2;
    wire [17:0]           spare;                   // from the size of `sum` to speed_max: negative where it is beyond
    wire [15:0]           next_limit;
    wire [LOW+15:0]       low_7;   // products of both parts of d
    wire [D_W-LOW+14:0]   high_7;

    assign ran  = begun[2];
    assign turn = begun[13];

    multiplier #(
        .A_W(LOW + 1),
        .B_W(15)
    ) u_low (
        .clk(clk),
        .a  ({1'b0, way_5[LOW-1:0]}),
        .b  ({1'b0, factor}),
        .p  (low_7)
    );

    multiplier #(
        .A_W(D_W - LOW),
        .B_W(15)
    ) u_high (
        .clk(clk),
        .a  (way_5[D_W-1:LOW]),
        .b  ({1'b0, factor}),
        .p  (high_7)
    );

    array_sum #(
        .W    (D_W),
        .ROUND(0)
    ) u_way (
        .a     (takes_high ? {high_1[OFF_W-1], high_1} : {low_1[OFF_W-1], low_1}),
        .choice(takes_low),
        .one   ({low_1[OFF_W-1], low_1, 1'b0}),
        .other ({high_1[OFF_W-1], high_1, 1'b0}),
        .y     (next_way)
    );

    motion_sum #(
        .W(18)
    ) u_spare (
        .adds (1'b1),
        .a    ({3'd0, speed_max}),
        .minus(!sum[17]),
        .b    (sum),
        .y    (spare)
    );

    motion_sum #(
        .W(16)
    ) u_limit (
        .adds (1'b0),
        .a    (16'd0),
        .minus(sum[17]),
        .b    ({1'b0, speed_max}),
        .y    (next_limit)
    );

    always @(posedge clk) begin
        begun <= {begun[12:0], start};
        if (start || |begun) begin  // otherwise a simulator can leave it out
            most_down <= {1'b0, leading} + {2'd0, gain} + 6'd23 - {1'b0, step_log2};

            low_1      <= low;
            high_1     <= high;
            low_less   <= less[D_W-1];
            low_any    <= {|low[OFF_W-1:13], |low[12:0]};
            high_any   <= {|high[OFF_W-1:13], |high[12:0]};

            way_2 <= slower && low_rises != high_rises ? {D_W{1'b0}} : next_way;

            way_3 <= way_2;
            if (way_2[D_W-1]) run_next <= run == -4'sd7 ? run : run[3] ? run - 4'sd1 : -4'sd1;
            else if (|way_2) run_next <= run == 4'sd7 ? run : run[3] ? 4'sd1 : run + 4'sd1;
            else run_next <= 4'sd0;

            way_4 <= way_3;
            down  <= most_down - {2'd0, raised < room ? raised : room};

            way_5   <= way_4;
            factor  <= {7'd0, inverse} << ~down[2:0];
            bytes_5 <= down[5:3];

            bytes_6 <= bytes_5;
            bytes_7 <= bytes_6;

            product <= {high_7, {LOW{1'b0}}} + {{(P_W - LOW - 16) {1'b0}}, low_7};
            bytes_8 <= bytes_7;

            // Beyond 16 bits only the sign of a change counts: no velocity has more.
            case (bytes_8[2:1])
                2'd0: part_9 <= wide_8[A_W-1:0];
                2'd1: part_9 <= wide_8[A_W+15:16];
                2'd2: part_9 <= wide_8[A_W+31:32];
                2'd3: part_9 <= wide_8[A_W+47:48];
            endcase
            over_9  <= !bytes_8[2] && (wide_8[A_W+47:A_W+16] != {32{sign_8}} || (!bytes_8[1] && wide_8[A_W+15:A_W] != {16{sign_8}}));
            sign_9  <= sign_8;
            byte_9  <= bytes_8[0];
            part_10 <= byte_9 ? part_9[A_W-1:8] : part_9[B_W-1:0];
            over_10 <= over_9 || (!byte_9 && part_9[A_W-1:B_W] != {(A_W - B_W) {sign_9}});
            sign_10 <= sign_9;

            change <= over_10 || part_10[16] != sign_10 ? (sign_10 ? 17'sh10000 : 17'sh0ffff) : part_10;
            v_11   <= v;
            sum    <= {{2{v_11[15]}}, v_11} + {change[16], change};

            beyond <= spare[17];
            limit  <= next_limit;
            sum_13 <= sum[15:0];
            v_next <= beyond ? limit : sum_13;
        end
        if (rst) begun <= 14'd0;
    end

    wire unused = &{1'b0, spare[16:0], less[D_W-2:0], size[3]};

endmodule

`default_nettype wire
