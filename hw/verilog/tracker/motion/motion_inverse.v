// SPDX-License-Identifier: Apache-2.0
// What a division by a number is done with: docs/motion.md, rule C3. The position of its leading bit, and the inverse by
// the three bits below it.
//
// Latency:    1 to 7 clocks from start, with which goes_on rises, to its falling, and 4 more to the results.
// Throughput: one at a time.
// Stall:      the results stay until the next start.
// Reset:      not busy.
// Combinational paths: start -> goes_on.
`default_nettype none

module motion_inverse (
    input  wire        clk,
    input  wire        rst,

    input  wire        start,
    input  wire [23:0] number,    // at least 1
    input  wire        beyond,    // in the clock after start: the number is 2^24 - 1 instead
    output wire        goes_on,   // in the next clock the leading bit is still looked for
    output reg  [4:0]  leading,   // position of the leading bit
    output reg  [6:0]  inverse    // round(1024 / (8.5 + m)), m the three bits below it
);

    reg         busy, begun;
    reg  [23:0] left;
    wire        by_8 = left[23:16] == 8'd0;
    wire        by_1 = !by_8 && !left[23];

    assign goes_on = start || busy && left[23:20] == 4'd0;

    always @(posedge clk) begin
        case (left[22:20])
            3'd0: inverse <= 7'd120;
            3'd1: inverse <= 7'd108;
            3'd2: inverse <= 7'd98;
            3'd3: inverse <= 7'd89;
            3'd4: inverse <= 7'd82;
            3'd5: inverse <= 7'd76;
            3'd6: inverse <= 7'd71;
            3'd7: inverse <= 7'd66;
        endcase
        busy <= goes_on;
        if (by_8) left <= {left[15:0], 8'd0};
        if (by_1) left <= {left[22:0], 1'b0};
        leading <= leading - {1'b0, by_8, 2'b00, by_1};
        if (start) begin
            left    <= number;
            leading <= 5'd23;
        end
        begun <= start;
        if (begun && beyond) begin
            left    <= 24'hffffff;
            leading <= 5'd23;
        end
        if (rst) busy <= 1'b0;
    end

endmodule

`default_nettype wire
