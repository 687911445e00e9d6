// SPDX-License-Identifier: Apache-2.0
// A field of a normalisation after a correction, limited to its range: rule F2 of docs/recognition.md.
//
// Latency:    2 clocks.
// Throughput: 1 field per clock; its kind must stand for both clocks.
// Stall:      none.
// Reset:      none.
// Combinational paths: none.
`default_nettype none

module classifier_fit (
    input  wire               clk,

    input  wire               is_scale,    // without sign, 16 to 4095
    input  wire               is_skew,     // signed, -127 to 127; else an offset, -1024 to 1023
    input  wire        [11:0] field,
    input  wire signed [17:0] correction,
    output reg         [11:0] value
);

    reg  signed [18:0] sum;
    wire               sign = !is_scale && field[11];

    wire        above   = is_scale ? |sum[17:12] : is_skew ? |sum[17:7] : |sum[17:10];  // where not negative
    wire        below   = is_scale || (is_skew ? !(&sum[17:7]) || ~|sum[6:0] : !(&sum[17:10]));  // where negative
    wire        tiny    = is_scale && ~|sum[17:4];
    wire [11:0] lowest  = is_scale ? 12'd16 : is_skew ? -12'd127 : -12'd1024;
    wire [11:0] highest = is_scale ? 12'd4095 : is_skew ? 12'd127 : 12'd1023;

    always @(posedge clk) begin
        sum   <= {{7{sign}}, field} + {correction[17], correction};
        value <= (sum[18] ? below : tiny) ? lowest : (!sum[18] && above) ? highest : sum[11:0];
    end

endmodule

`default_nettype wire
