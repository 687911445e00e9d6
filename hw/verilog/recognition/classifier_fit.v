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
    input  wire signed [17:0] s_product,
    input  wire        [2:0]  s_shift,    // of the product, to the right: at most 6
    output reg         [11:0] value
);

    reg signed [17:0] correction;
    reg        [2:0]  left;
    reg signed [13:0] sum;
    reg               far, minus;  // the correction is beyond 13 bits: so is the field then
    wire              sign = !is_scale && field[11];

    // A clock after the sum: which of its bits are all 1, and all 0.
    reg        [13:0] sum_1;
    reg               far_1, minus_1;
    reg               ones_12_10, ones_9_7, zeros_12_10, zeros_9_7, zeros_6_4, zeros_3_0;

    wire above = is_scale ? sum_1[12] : !zeros_12_10 || (is_skew && !zeros_9_7);  // where not negative
    wire below = is_scale || !ones_12_10 || (is_skew && (!ones_9_7 || (zeros_6_4 && zeros_3_0)));  // where negative
    wire tiny  = is_scale && zeros_12_10 && zeros_9_7 && zeros_6_4;

    reg        [11:0] sum_2;
    reg               limited;
    reg               low;  // of a limit
    wire       [11:0] lowest  = is_scale ? 12'd16 : is_skew ? -12'd127 : -12'd1024;
    wire       [11:0] highest = is_scale ? 12'd4095 : is_skew ? 12'd127 : 12'd1023;
    wire       [11:0] limit   = low ? lowest : highest;

    always @(posedge clk) begin
        if (s_valid) begin
            correction <= s_product;
            left       <= s_shift;
        end else if (left != 3'd0) begin
            correction <= correction >>> 1;
            left       <= left - 3'd1;
        end
        sum         <= $signed({sign, field}) + $signed(correction[12:0]);
        far         <= !(&correction[17:12]) && |correction[17:12];
        minus       <= correction[17];
        sum_1       <= sum;
        far_1       <= far;
        minus_1     <= minus;
        ones_12_10  <= &sum[12:10];
        ones_9_7    <= &sum[9:7];
        zeros_12_10 <= ~|sum[12:10];
        zeros_9_7   <= ~|sum[9:7];
        zeros_6_4   <= ~|sum[6:4];
        zeros_3_0   <= ~|sum[3:0];
        sum_2       <= sum_1[11:0];
        limited     <= far_1 || (sum_1[13] ? below : above || tiny);
        low         <= far_1 ? minus_1 : sum_1[13] || (is_scale && !sum_1[12]);
        value       <= limited ? limit : sum_2;
        if (clears) value <= 12'd0;
    end

endmodule

`default_nettype wire
