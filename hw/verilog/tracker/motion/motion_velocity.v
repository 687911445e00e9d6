// SPDX-License-Identifier: Apache-2.0
// The correction of a velocity on one axis: docs/motion.md, "Correction", point 3.
//
// d·2^-g over the time since the last correction, by the leading bit of that time and the three bits below it, which motion_inverse.v finds.
//
// Latency:    10 to 22 clocks from start to busy falling; inputs must stay.
// Throughput: one at a time.
// Stall:      the result stays until the next start.
// Reset:      not busy.
// Combinational paths: none.
`default_nettype none

module motion_velocity #(
    parameter OFF_W = 26  // bits of an offset, 2^-12 px, signed
) (
    input  wire                    clk,
    input  wire                    rst,

    input  wire                    start,
    input  wire signed [OFF_W-1:0] low,        // offsets of both sides
    input  wire signed [OFF_W-1:0] high,
    input  wire                    slower,     // take what both sides have in common
    input  wire [4:0]              leading,    // position of the leading bit of the time
    input  wire [6:0]              inverse,    // of that bit and the three below it
    input  wire [3:0]              gain,       // g, 1 to 13
    input  wire [4:0]              step_log2,
    input  wire [14:0]             speed_max,
    input  wire signed [15:0]      v,

    output reg                     busy,
    output reg signed [15:0]       v_next
);

    localparam D_W  = OFF_W + 1;   // bits of d
    localparam LOW  = 17;          // of its lower part
    localparam P_W  = D_W + 8;     // of its product with up to 120
    localparam LEFT = 12;          // most places to the left; all shifts are to the right from there
    localparam S_W  = P_W + LEFT;

    reg [6:0]             step;    // one of them is high: the values of the step before are there
    reg                   shifts;
    reg [OFF_W-1:0]       abs_low, abs_high;
    reg                   low_less;
    reg signed [D_W-1:0]  way;
    reg [LOW+6:0]         product_low;
    reg signed [P_W-LOW-1:0] product_high;
    reg signed [S_W-1:0]  shifted;
    reg [6:0]             down;    // places to the right
    reg signed [16:0]     change;
    reg signed [17:0]     sum;

    wire low_rises  = !low[OFF_W-1] && |low;
    wire high_rises = !high[OFF_W-1] && |high;
    wire signed [D_W-1:0] shorter = low_less ? {low, 1'b0} : {high, 1'b0};
    wire signed [D_W-1:0] both    = {low[OFF_W-1], low} + {high[OFF_W-1], high};
    wire signed [D_W-LOW-1:0] way_high = way[D_W-1:LOW];
    wire [P_W-1:0] product = {product_high, {LOW{1'b0}}} + {{(P_W - LOW - 7) {1'b0}}, product_low};

    // Beyond 16 bits only the sign of a change counts: no velocity has more.
    wire too_high = !shifted[S_W-1] && |shifted[S_W-2:16];
    wire too_low  = shifted[S_W-1] && !(&shifted[S_W-2:16]);
    wire signed [17:0] most  = {3'd0, speed_max};
    wire signed [17:0] bound = sum > most ? most : sum < -most ? -most : sum;
    wire unused = &{1'b0, bound[17:16]};

    always @(posedge clk) begin
        step <= {step[5:0], start};
        if (start) begin
            abs_low  <= low[OFF_W-1] ? -low : low;
            abs_high <= high[OFF_W-1] ? -high : high;
            busy     <= 1'b1;
        end
        if (step[0]) low_less <= abs_low < abs_high;
        if (step[1]) way <= !slower ? both : low_rises != high_rises ? {D_W{1'b0}} : shorter;
        if (step[2]) begin
            product_low  <= way[LOW-1:0] * inverse;
            product_high <= way_high * $signed({{(P_W - LOW - 7) {1'b0}}, inverse});
        end
        if (step[3]) begin
            shifted <= {product, {LEFT{1'b0}}};
            down    <= {2'b00, leading} + {3'd0, gain} + 7'd20 - {2'b00, step_log2};
            shifts  <= 1'b1;
        end
        if (shifts) begin
            if (down >= 7'd8) begin
                shifted <= {{8{shifted[S_W-1]}}, shifted[S_W-1:8]};
                down    <= down - 7'd8;
            end else if (down != 7'd0) begin
                shifted <= {shifted[S_W-1], shifted[S_W-1:1]};
                down    <= down - 7'd1;
            end else begin
                shifts <= 1'b0;
                change <= too_high ? 17'sh0ffff : too_low ? 17'sh10000 : shifted[16:0];
            end
        end
        step[4] <= shifts && down == 7'd0;
        if (step[4]) sum <= {{2{v[15]}}, v} + {change[16], change};
        if (step[5]) v_next <= bound[15:0];
        if (step[6]) busy <= 1'b0;
        if (rst) begin
            step   <= 7'd0;
            shifts <= 1'b0;
            busy   <= 1'b0;
        end
    end

endmodule

`default_nettype wire
