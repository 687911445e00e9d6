// SPDX-License-Identifier: Apache-2.0
// The cell of an event in the image of its slot, and the slots' normalisations: rule N1 of docs/recognition.md.
//
// In the first window of a track the default normalisation takes the place of the stored one. A cell is counter `lane` of word
// `word`, eight to a word: of row v and column u, word v and lane u for u < 8, else word 12 + v / 2 and lane 4 (v % 2) + u - 8.
//
// Latency:    12 clocks from s_ to m_.
// Throughput: 1 event per clock.
// Stall:      none.
// Reset:      no event is inside. The normalisations are not reset.
// Combinational paths: none.
`default_nettype none

module classifier_cell #(
    parameter N      = 8,   // slots of the tracker
    parameter REL_W  = 10,  // bits of a relative address
    parameter SLOT_W = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire              clk,
    input  wire              rst,

    input  wire [11:0]       scale_start,  // register

    // events that count
    input  wire              s_valid,
    input  wire [SLOT_W-1:0] s_slot,
    input  wire [REL_W-1:0]  s_dx,         // half pixels, signed
    input  wire [REL_W-1:0]  s_dy,
    input  wire              s_first,      // of its window
    input  wire              s_young,      // in the first window of a track

    // a new value of one field: one bit of fit_field, of off_u, scale_x, off_v, scale_y, skew
    input  wire [4:0]        fit_field,
    input  wire [SLOT_W-1:0] fit_slot,
    input  wire [11:0]       fit_value,

    output wire              m_valid,
    output wire [SLOT_W-1:0] m_slot,
    output wire              m_first,
    output wire [4:0]        m_word,
    output wire [2:0]        m_lane
);

    parameter_check #(.OK(N >= 1)) N_must_be_at_least_1 ();
    parameter_check #(.OK(REL_W >= 2 && REL_W <= 18)) REL_W_must_be_2_to_18 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam LATENCY = 12;
    localparam SUM_W   = (REL_W > 4) ? REL_W + 9 : 14;  // of a scaled address after two subtractions

    // ---- the normalisations ------------------------------------------------------------------------------------------

    reg [10:0] off_u   [0:N-1];  // 2^-8 cells, signed
    reg [11:0] scale_x [0:N-1];  // 2^-12 cells per half pixel
    reg [10:0] off_v   [0:N-1];
    reg [11:0] scale_y [0:N-1];
    reg [7:0]  skew    [0:N-1];  // 2^-7 cells per cell, signed

    always @(posedge clk) begin
        if (fit_field[0]) off_u[fit_slot]   <= fit_value[10:0];
        if (fit_field[1]) scale_x[fit_slot] <= fit_value;
        if (fit_field[2]) off_v[fit_slot]   <= fit_value[10:0];
        if (fit_field[3]) scale_y[fit_slot] <= fit_value;
        if (fit_field[4]) skew[fit_slot]    <= fit_value[7:0];
    end

    reg [REL_W-1:0]   dx_s2, dy_s2;
    reg [11:0]        scale_x_s2, scale_y_s2;
    reg        [10:0] off_u_s2, off_v_s2;
    reg signed [12:0] off_u_s3, off_v_s3, off_u_s4, off_v_s4;
    reg signed [7:0]  skew_s2, skew_s3, skew_s4, skew_s5, skew_s6, skew_s7;

    always @(posedge clk) begin
        dx_s2      <= s_dx;
        dy_s2      <= s_dy;
        scale_x_s2 <= s_young ? scale_start : scale_x[s_slot];
        scale_y_s2 <= s_young ? scale_start : scale_y[s_slot];
        off_u_s2   <= off_u[s_slot];
        off_v_s2   <= off_v[s_slot];
        skew_s2    <= skew[s_slot];
        if (s_young) begin
            off_u_s2 <= 11'd0;
            off_v_s2 <= 11'd0;
            skew_s2  <= 8'd0;
        end
        {off_u_s3, off_v_s3}        <= {from_edge(off_u_s2), from_edge(off_v_s2)};
        {off_u_s4, off_v_s4}        <= {off_u_s3, off_v_s3};
        {skew_s3, skew_s4, skew_s5} <= {skew_s2, skew_s3, skew_s4};
        {skew_s6, skew_s7}          <= {skew_s5, skew_s6};
    end

    // ---- v, and u without its shear ----------------------------------------------------------------------------------

    wire signed [REL_W+12:0] scaled_x, scaled_y;  // s4

    multiplier #(
        .A_W(REL_W),
        .B_W(13)
    ) u_scale_x (
        .clk(clk),
        .a  (dx_s2),
        .b  ({1'b0, scale_x_s2}),
        .p  (scaled_x)
    );

    multiplier #(
        .A_W(REL_W),
        .B_W(13)
    ) u_scale_y (
        .clk(clk),
        .a  (dy_s2),
        .b  ({1'b0, scale_y_s2}),
        .p  (scaled_y)
    );

    // Addresses from the edge of the image: 1536 more than from its middle. An offset less 1536, in 13 bits:
    function [12:0] from_edge;
        input [10:0] off;
        from_edge = {1'b1, !off[10] || off[9], off[10] ^ off[9], !off[9], off[8:0]};
    endfunction

    // More than 3071, where not negative.
    function beyond;
        input [SUM_W-1:0] value;
        beyond = |value[SUM_W-2:12] || value[11:10] == 2'b11;
    endfunction

    reg signed [SUM_W-1:0]  straight_u_s5, straight_u_s6, straight_u_s7, straight_u_s8, straight_u_s9;
    reg signed [SUM_W-1:0]  sum_v_s5, sum_u_s10;
    reg        [11:0]       low_v_s6;
    reg                     below_v_s6, beyond_v_s6;
    reg        [11:0]       v_s7;  // 0 to 3071
    wire       [11:0]       middle_v_s7 = {v_s7[11:8] - 4'd6, v_s7[7:0]};
    wire signed [19:0]      sheared;  // s9
    wire signed [12:0]      shear_s9 = sheared[19:7];
    wire signed [REL_W+8:0] x_s4 = scaled_x[REL_W+12:4];
    wire signed [REL_W+8:0] y_s4 = scaled_y[REL_W+12:4];

    multiplier #(
        .A_W(8),
        .B_W(12)
    ) u_shear (
        .clk(clk),
        .a  (skew_s7),
        .b  (middle_v_s7),
        .p  (sheared)
    );

    always @(posedge clk) begin
        straight_u_s5 <= x_s4 - off_u_s4;
        sum_v_s5      <= y_s4 - off_v_s4;
        straight_u_s6 <= straight_u_s5;
        straight_u_s7 <= straight_u_s6;
        straight_u_s8 <= straight_u_s7;
        straight_u_s9 <= straight_u_s8;
        low_v_s6      <= sum_v_s5[11:0];
        below_v_s6    <= sum_v_s5[SUM_W-1];
        beyond_v_s6   <= beyond(sum_v_s5);
        v_s7          <= low_v_s6 | {12{beyond_v_s6}};
        if (beyond_v_s6) v_s7[10] <= 1'b0;
        if (below_v_s6) v_s7 <= 12'd0;
        sum_u_s10     <= straight_u_s9 - shear_s9;
    end

    // ---- the cell ----------------------------------------------------------------------------------------------------

    reg [3:0] row_s8, row_s9, row_s10, row_s11, row_s12;
    reg [3:0] column_s11, column_s12;
    reg       below_u_s11, beyond_u_s11;
    reg [4:0] word_s13;
    reg [2:0] lane_s13;

    reg [LATENCY-1:0]        valids;
    reg [LATENCY-1:0]        firsts;
    reg [LATENCY*SLOT_W-1:0] slots;

    always @(posedge clk) begin
        {row_s8, row_s9, row_s10, row_s11, row_s12} <= {v_s7[11:8], row_s8, row_s9, row_s10, row_s11};

        column_s11   <= sum_u_s10[11:8];
        below_u_s11  <= sum_u_s10[SUM_W-1];
        beyond_u_s11 <= beyond(sum_u_s10);
        column_s12   <= column_s11 | {4{beyond_u_s11}};
        if (beyond_u_s11) column_s12[2] <= 1'b0;
        if (below_u_s11) column_s12 <= 4'd0;
        word_s13 <= column_s12[3] ? {row_s12[3], {2{!row_s12[3]}}, row_s12[2:1]} : {1'b0, row_s12};
        lane_s13 <= {column_s12[3] ? row_s12[0] : column_s12[2], column_s12[1:0]};

        valids  <= {valids[LATENCY-2:0], s_valid};
        firsts  <= {firsts[LATENCY-2:0], s_first};
        slots   <= {slots[(LATENCY-1)*SLOT_W-1:0], s_slot};
        if (rst) valids <= {LATENCY{1'b0}};
    end

    assign m_valid = valids[LATENCY-1];
    assign m_first = firsts[LATENCY-1];
    assign m_slot  = slots[(LATENCY-1)*SLOT_W +: SLOT_W];
    assign m_word  = word_s13;
    assign m_lane  = lane_s13;

    wire unused = &{1'b0, sum_u_s10[7:0], sheared[6:0], scaled_x[3:0], scaled_y[3:0]};

endmodule

`default_nettype wire
