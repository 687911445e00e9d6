// SPDX-License-Identifier: Apache-2.0
// The correction of a velocity: docs/motion.md, "Correction", point 3. One axis after the other.
//
// d·2^-g over the time since the last correction, by the leading bit of that time and the three bits below it.
//
// Latency:    22 to 56 clocks from start to done; inputs must stay, v_x and v_y as well.
// Throughput: one at a time.
// Stall:      the results stay until the next start.
// Reset:      waits for a start.
// Combinational paths: none.
`default_nettype none

module motion_velocity #(
    parameter OFF_W = 30  // bits of an offset, 2^-12 px, signed
) (
    input  wire                    clk,
    input  wire                    rst,

    input  wire                    start,
    input  wire [23:0]             ticks,      // since the last correction, at least 1
    input  wire signed [OFF_W-1:0] off_lo_x,
    input  wire signed [OFF_W-1:0] off_hi_x,
    input  wire signed [OFF_W-1:0] off_lo_y,
    input  wire signed [OFF_W-1:0] off_hi_y,
    input  wire                    slower,     // take what both sides have in common
    input  wire [3:0]              gain,       // g, 1 to 13
    input  wire [4:0]              step_log2,
    input  wire [14:0]             speed_max,
    input  wire signed [15:0]      v_x,
    input  wire signed [15:0]      v_y,

    output reg                     done,
    output reg signed [15:0]       v_x_next,
    output reg signed [15:0]       v_y_next
);

    localparam D_W = OFF_W + 1;  // bits of d
    localparam P_W = D_W + 8;    // of its product with up to 120

    localparam [3:0] WAIT    = 4'd0;
    localparam [3:0] NORM    = 4'd1;  // shifting the time until its leading bit is the highest
    localparam [3:0] SIDES   = 4'd2;  // the two offsets
    localparam [3:0] COMPARE = 4'd3;
    localparam [3:0] WAY     = 4'd4;  // d
    localparam [3:0] TIMES   = 4'd5;  // its product with the inverse of the time's leading bits
    localparam [3:0] SHIFT   = 4'd6;
    localparam [3:0] LIMIT   = 4'd7;  // of the change
    localparam [3:0] SUM     = 4'd8;
    localparam [3:0] BOUND   = 4'd9;  // and of the velocity
    localparam [3:0] SIZES   = 4'd10; // of the offsets

    reg [3:0]             state;
    reg                   on_y;
    reg [23:0]            time_left;
    reg [4:0]             leading;
    reg signed [OFF_W-1:0] low, high;
    reg                   low_less;
    reg signed [D_W-1:0]  way;
    reg signed [P_W-1:0]  product;
    reg signed [6:0]      down;     // places to the right, negative: to the left
    reg signed [16:0]     change;
    reg [6:0]             inverse;  // round(1024 / (8.5 + m)), m the three bits below the leading one

    reg [OFF_W-1:0] abs_low, abs_high;
    wire low_rises  = !low[OFF_W-1] && |low;
    wire high_rises = !high[OFF_W-1] && |high;
    wire signed [D_W-1:0] shorter = low_less ? {low, 1'b0} : {high, 1'b0};
    wire signed [D_W-1:0] both    = {low[OFF_W-1], low} + {high[OFF_W-1], high};

    // Beyond 16 bits only the sign of a change counts: no velocity has more.
    wire too_high = !product[P_W-1] && |product[P_W-2:16];
    wire too_low  = product[P_W-1] && !(&product[P_W-2:16]);
    wire signed [15:0] v_now = on_y ? v_y : v_x;
    wire signed [17:0] most  = {3'd0, speed_max};
    reg signed [17:0]  sum;
    wire signed [17:0] bound = sum > most ? most : sum < -most ? -most : sum;
    wire unused = &{1'b0, bound[17:16]};

    always @* begin
        case (time_left[22:20])
            3'd0: inverse = 7'd120;
            3'd1: inverse = 7'd108;
            3'd2: inverse = 7'd98;
            3'd3: inverse = 7'd89;
            3'd4: inverse = 7'd82;
            3'd5: inverse = 7'd76;
            3'd6: inverse = 7'd71;
            3'd7: inverse = 7'd66;
        endcase
    end

    always @(posedge clk) begin
        done <= 1'b0;
        case (state)
            WAIT: begin
                time_left <= ticks;
                leading   <= 5'd23;
                on_y      <= 1'b0;
                if (start) state <= NORM;
            end
            NORM:
            if (time_left[23]) state <= SIDES;
            else if (time_left[23:16] == 8'd0) begin
                time_left <= {time_left[15:0], 8'd0};
                leading   <= leading - 5'd8;
            end else begin
                time_left <= {time_left[22:0], 1'b0};
                leading   <= leading - 5'd1;
            end
            SIDES: begin
                low   <= on_y ? off_lo_y : off_lo_x;
                high  <= on_y ? off_hi_y : off_hi_x;
                state <= SIZES;
            end
            SIZES: begin
                abs_low  <= low[OFF_W-1] ? -low : low;
                abs_high <= high[OFF_W-1] ? -high : high;
                state    <= COMPARE;
            end
            COMPARE: begin
                low_less <= abs_low < abs_high;
                state    <= WAY;
            end
            WAY: begin
                way   <= !slower ? both : low_rises != high_rises ? {D_W{1'b0}} : shorter;
                down  <= {2'b00, leading} + {3'd0, gain} + 7'd8 - {2'b00, step_log2};
                state <= TIMES;
            end
            TIMES: begin
                product <= {{(P_W - D_W) {way[D_W-1]}}, way} * $signed({{(P_W - 7) {1'b0}}, inverse});
                state   <= SHIFT;
            end
            SHIFT:
            if (down == 7'sd0) state <= LIMIT;
            else if (down < 7'sd0) begin
                if (!too_high && !too_low) product <= {product[P_W-2:0], 1'b0};
                down <= down + 7'sd1;
            end else if (down < 7'sd8) begin
                product <= {product[P_W-1], product[P_W-1:1]};
                down    <= down - 7'sd1;
            end else begin
                product <= {{8{product[P_W-1]}}, product[P_W-1:8]};
                down    <= down - 7'sd8;
            end
            LIMIT: begin
                change <= too_high ? 17'sh0ffff : too_low ? 17'sh10000 : product[16:0];
                state  <= SUM;
            end
            SUM: begin
                sum   <= {{2{v_now[15]}}, v_now} + {change[16], change};
                state <= BOUND;
            end
            BOUND: begin
                on_y  <= 1'b1;
                done  <= on_y;
                state <= on_y ? WAIT : SIDES;
                if (on_y) v_y_next <= bound[15:0];
                else v_x_next <= bound[15:0];
            end
            default: state <= WAIT;
        endcase
        if (rst) begin
            state <= WAIT;
            done  <= 1'b0;
        end
    end

endmodule

`default_nettype wire
