// SPDX-License-Identifier: Apache-2.0
// A field of a normalisation after a correction: rule F2 of docs/recognition.md.
//
// The product is shifted by one bit a clock.
//
// Latency:    11 clocks from s_valid to `value`, which stands until the next s_valid.
// Throughput: a field in 11 clocks; its kind must stand for them.
// Stall:      none.
// Reset:      none; `value` is 0 while `clears` is high.
// Combinational paths: none.
`default_nettype none

module classifier_fit (
    input  wire               clk,
    input  wire               clears,

    input  wire               is_scale,   // without sign, 16 to 4095
    input  wire               is_skew,    // signed, -127 to 127; else an offset, -1024 to 1023
    input  wire        [11:0] field,
    input  wire               s_valid,
    input  wire signed [18:0] s_product,
    input  wire        [2:0]  s_shift,    // of the product, to the right
    output reg         [11:0] value
);

    reg signed [18:0] correction;
    reg        [2:0]  left;
    reg signed [13:0] sum;
    reg               far, minus;  // the correction is beyond 13 bits: so is the field then
    reg        [11:0] sum_d;
    reg               limited;
    reg               low;

    wire sign = !is_scale && field[11];

    wire above = is_scale ? sum[12] : is_skew ? |sum[12:7] : |sum[12:10];  // where not negative
    wire below = is_scale || (is_skew ? !(&sum[12:7]) || ~|sum[6:0] : !(&sum[12:10]));  // where negative
    wire tiny  = is_scale && ~|sum[12:4];

    wire [11:0] lowest  = is_scale ? 12'd16 : is_skew ? -12'd127 : -12'd1024;
    wire [11:0] highest = is_scale ? 12'd4095 : is_skew ? 12'd127 : 12'd1023;
    wire [11:0] limit   = low ? lowest : highest;

    always @(posedge clk) begin
        if (s_valid) begin
            correction <= s_product;
            left       <= s_shift;
        end else if (left != 3'd0) begin
            correction <= correction >>> 1;
            left       <= left - 3'd1;
        end
        sum     <= $signed({sign, field}) + $signed(correction[12:0]);
        far     <= !(&correction[18:12]) && |correction[18:12];
        minus   <= correction[18];
        sum_d   <= sum[11:0];
        limited <= far || (sum[13] ? below : above || tiny);
        low     <= far ? minus : sum[13] || (is_scale && !sum[12]);
        value   <= limited ? limit : sum_d;
        if (clears) value <= 12'd0;
    end

endmodule

`default_nettype wire
