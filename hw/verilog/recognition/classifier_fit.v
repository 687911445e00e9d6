// SPDX-License-Identifier: Apache-2.0
// A field of a normalisation after a correction, limited to its range: rule F2 of docs/recognition.md.
//
// Latency:    none.
// Throughput: none.
// Stall:      none.
// Reset:      none.
// Combinational paths: from all inputs to `value`.
`default_nettype none

module classifier_fit (
    input  wire               is_scale,    // without sign, 16 to 4095
    input  wire               is_skew,     // -127 to 127; else an offset, -1024 to 1023
    input  wire        [11:0] before,      // its lowest bits are the field
    input  wire signed [17:0] correction,
    output wire        [11:0] value
);

    wire sign = is_scale ? 1'b0 : is_skew ? before[7] : before[10];
    wire [11:0] extended = {is_scale ? before[11] : sign, (is_scale || !is_skew) ? before[10:8] : {3{sign}}, before[7:0]};
    wire signed [18:0] sum = {{7{sign}}, extended} + {correction[17], correction};

    wire below  = sum[18];
    wire beyond = is_scale ? |sum[17:12] : is_skew ? |sum[17:7] : |sum[17:10];     // above, where not below
    wire under  = is_scale ? 1'b1 : is_skew ? !(&sum[17:7]) || ~|sum[6:0] : !(&sum[17:10]);  // where below

    wire [11:0] lowest  = is_scale ? 12'd16 : is_skew ? 12'hF81 : 12'hC00;
    wire [11:0] highest = is_scale ? 12'd4095 : is_skew ? 12'd127 : 12'd1023;

    assign value = below ? (under ? lowest : sum[11:0])
        : beyond ? highest : (is_scale && ~|sum[11:4]) ? lowest : sum[11:0];

endmodule

`default_nettype wire
