// SPDX-License-Identifier: Apache-2.0
// The cell of an event in the image of its slot: rule N1 of docs/recognition.md.
//
// A cell is counter `lane` of word
// `word`, eight to a word: of row v and column u, word v and lane u for u < 8, else word 12 + v / 2 and lane 4 (v % 2) + u - 8.
//
// Latency:    16 clocks from s_ to m_.
// Throughput: 1 event per clock.
// Stall:      none.
// Reset:      no event is inside. The skews are not reset.
// Combinational paths: none.
`default_nettype none

module classifier_cell #(
    parameter N      = 8,   // slots of the tracker
    parameter REL_W  = 10,  // bits of a relative address
    parameter SLOT_W = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire              clk,
    input  wire              rst,

    // events that count
    input  wire              s_valid,
    input  wire [SLOT_W-1:0] s_slot,
    input  wire [REL_W-1:0]  s_dx,         // half pixels, signed
    input  wire [REL_W-1:0]  s_dy,
    input  wire              s_first,      // of its window
    input  wire              s_young,      // in the first window of a track

    // fields of its slot, from 3 clocks after it; in the first window of a track the start scale
    input  wire [11:0]       scale_x,      // 2^-12 cells per half pixel
    input  wire [11:0]       scale_y,
    input  wire [10:0]       off_u,        // 2^-8 cells, signed
    input  wire [10:0]       off_v,

    input  wire              skew_valid,   // a new value of another field, which stays here
    input  wire [SLOT_W-1:0] skew_slot,
    input  wire [7:0]        skew_value,   // 2^-7 cells per cell, signed

    output wire              m_valid,
    output wire [SLOT_W-1:0] m_slot,
    output wire              m_first,
    output wire [4:0]        m_word,
    output wire [2:0]        m_lane
);

    parameter_check #(.OK(N >= 1)) N_must_be_at_least_1 ();
    parameter_check #(.OK(REL_W >= 2 && REL_W <= 18)) REL_W_must_be_2_to_18 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam LATENCY = 16;
    localparam WIDE_W  = (REL_W > 4) ? REL_W + 14 : 18;  // of a product with a scale, no less than is looked at

    // ---- the normalisations ------------------------------------------------------------------------------------------

    reg        [7:0]       skew [0:N-1];
    reg                    young_s2, young_s3, young_s4;
    reg        [REL_W-1:0] dx_s2, dy_s2, dx_s3, dy_s3, dx_s4, dy_s4;
    reg        [10:0]      off_u_s5, off_v_s5;
    reg signed [12:0]      off_u_s6, off_v_s6;
    reg signed [7:0]       skew_s2, skew_s3, skew_s4, skew_s5, skew_s6, skew_s7, skew_s8, skew_s9, skew_s10;

    always @(posedge clk) begin
        if (skew_valid) skew[skew_slot] <= skew_value;
        {young_s2, young_s3, young_s4}  <= {s_young, young_s2, young_s3};
        {dx_s2, dx_s3, dx_s4} <= {s_dx, dx_s2, dx_s3};
        {dy_s2, dy_s3, dy_s4} <= {s_dy, dy_s2, dy_s3};
        skew_s2               <= skew[s_slot];
        {skew_s3, skew_s4, skew_s5, skew_s6} <= {skew_s2, skew_s3, skew_s4, skew_s5};
        {skew_s7, skew_s8, skew_s9, skew_s10} <= {skew_s6, skew_s7, skew_s8, skew_s9};
        {off_u_s5, off_v_s5} <= {off_u, off_v};
        if (young_s2) skew_s3 <= 8'd0;
        if (young_s4) {off_u_s5, off_v_s5} <= 22'd0;
        {off_u_s6, off_v_s6} <= {from_edge(off_u_s5), from_edge(off_v_s5)};
    end

    // ---- v, and u without its shear ----------------------------------------------------------------------------------

    wire signed [REL_W+12:0] scaled_x, scaled_y;
    wire signed [WIDE_W-1:0] wide_x_s6 = {{(WIDE_W - REL_W - 13) {scaled_x[REL_W+12]}}, scaled_x};
    wire signed [WIDE_W-1:0] wide_y_s6 = {{(WIDE_W - REL_W - 13) {scaled_y[REL_W+12]}}, scaled_y};

    multiplier #(
        .A_W(REL_W),
        .B_W(13)
    ) u_scale_x (
        .clk(clk),
        .a  (dx_s4),
        .b  ({1'b0, scale_x}),
        .p  (scaled_x)
    );

    multiplier #(
        .A_W(REL_W),
        .B_W(13)
    ) u_scale_y (
        .clk(clk),
        .a  (dy_s4),
        .b  ({1'b0, scale_y}),
        .p  (scaled_y)
    );

    // Addresses from the edge of the image: 1536 more than from its middle. An offset less 1536, in 13 bits:
    function [12:0] from_edge;
        input [10:0] off;
        from_edge = {1'b1, !off[10] || off[9], off[10] ^ off[9], !off[9], off[8:0]};
    endfunction

    // A scaled address that has more than 13 bits is beyond the image, or below it, whatever is subtracted.
    function far;
        input [WIDE_W-1:16] scaled;
        far = !(&scaled) && |scaled;
    endfunction

    // From 3072 on.
    function beyond;
        input [13:10] value;
        beyond = !value[13] && (value[12] || value[11:10] == 2'b11);
    endfunction

    reg signed [13:0]       straight_u_s7, straight_u_s8, straight_u_s9, straight_u_s10, straight_u_s11, straight_u_s12;
    reg signed [13:0]       sum_v_s7, sum_u_s13;
    reg                     far_u_s7, far_v_s7, minus_u_s7, minus_v_s7;
    reg        [5:0]        far_u_s13, minus_u_s13;  // of the clocks from s8 on
    reg        [11:0]       low_v_s8;
    reg                     below_v_s8, beyond_v_s8;
    reg                     beyond_v_s9;
    reg        [11:0]       v_s9, v_s10;  // 0 to 3071
    wire       [11:0]       middle_v_s10 = {v_s10[11:8] - 4'd6, v_s10[7:0]};
    wire signed [19:0]      sheared;  // s12
    wire signed [12:0]      shear_s12 = sheared[19:7];
    wire signed [12:0]      x_s6 = wide_x_s6[16:4];
    wire signed [12:0]      y_s6 = wide_y_s6[16:4];

    multiplier #(
        .A_W(8),
        .B_W(12)
    ) u_shear (
        .clk(clk),
        .a  (skew_s10),
        .b  (middle_v_s10),
        .p  (sheared)
    );

    always @(posedge clk) begin
        straight_u_s7 <= x_s6 - off_u_s6;
        sum_v_s7      <= y_s6 - off_v_s6;
        straight_u_s8 <= straight_u_s7;
        straight_u_s9 <= straight_u_s8;
        straight_u_s10 <= straight_u_s9;
        straight_u_s11 <= straight_u_s10;
        low_v_s8      <= sum_v_s7[11:0];
        {far_u_s7, minus_u_s7} <= {far(wide_x_s6[WIDE_W-1:16]), wide_x_s6[WIDE_W-1]};
        {far_v_s7, minus_v_s7} <= {far(wide_y_s6[WIDE_W-1:16]), wide_y_s6[WIDE_W-1]};
        far_u_s13     <= {far_u_s13[4:0], far_u_s7};
        minus_u_s13   <= {minus_u_s13[4:0], minus_u_s7};
        below_v_s8    <= far_v_s7 ? minus_v_s7 : sum_v_s7[13];
        beyond_v_s8   <= far_v_s7 ? !minus_v_s7 : beyond(sum_v_s7[13:10]);
        beyond_v_s9   <= beyond_v_s8;
        v_s9          <= low_v_s8;
        v_s10         <= v_s9;
        if (below_v_s8) v_s9 <= 12'd0;
        if (beyond_v_s9) v_s10 <= 12'd3071;
        straight_u_s12 <= straight_u_s11;
        sum_u_s13      <= straight_u_s12 - shear_s12;
    end

    // ---- the cell ----------------------------------------------------------------------------------------------------

    reg [3:0] row_s11, row_s12, row_s13, row_s14, row_s15, row_s16;
    reg [3:0] column_s14, column_s15, column_s16;
    reg       below_u_s14, beyond_u_s14, beyond_u_s15;
    reg [4:0] word_s17;
    reg [2:0] lane_s17;

    reg [LATENCY-1:0]        valids;
    reg [LATENCY-1:0]        firsts;
    reg [LATENCY*SLOT_W-1:0] slots;

    always @(posedge clk) begin
        {row_s11, row_s12, row_s13} <= {v_s10[11:8], row_s11, row_s12};
        {row_s14, row_s15, row_s16} <= {row_s13, row_s14, row_s15};

        column_s14   <= sum_u_s13[11:8];
        below_u_s14  <= far_u_s13[5] ? minus_u_s13[5] : sum_u_s13[13];
        beyond_u_s14 <= far_u_s13[5] ? !minus_u_s13[5] : beyond(sum_u_s13[13:10]);
        beyond_u_s15 <= beyond_u_s14;
        column_s15   <= column_s14;
        column_s16   <= column_s15;
        if (below_u_s14) column_s15 <= 4'd0;
        if (beyond_u_s15) column_s16 <= 4'd11;
        word_s17 <= column_s16[3] ? {row_s16[3], {2{!row_s16[3]}}, row_s16[2:1]} : {1'b0, row_s16};
        lane_s17 <= {column_s16[3] ? row_s16[0] : column_s16[2], column_s16[1:0]};

        valids  <= {valids[LATENCY-2:0], s_valid};
        firsts  <= {firsts[LATENCY-2:0], s_first};
        slots   <= {slots[(LATENCY-1)*SLOT_W-1:0], s_slot};
        if (rst) valids <= {LATENCY{1'b0}};
    end

    assign m_valid = valids[LATENCY-1];
    assign m_first = firsts[LATENCY-1];
    assign m_slot  = slots[(LATENCY-1)*SLOT_W +: SLOT_W];
    assign m_word  = word_s17;
    assign m_lane  = lane_s17;

    wire unused = &{1'b0, sum_u_s13[7:0], sheared[6:0], wide_x_s6[3:0], wide_y_s6[3:0]};

endmodule

`default_nettype wire
