// SPDX-License-Identifier: Apache-2.0
// The cell of an event in the image of its slot, and the slots' normalisations: rule N1 of docs/recognition.md.
//
// In the first window of a track the default normalisation takes the place of the stored one. Cell 12 v + u is counter `lane` of
// word `word`, eight to a word.
//
// Latency:    8 clocks from s_ to m_.
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

    localparam LATENCY = 8;
    localparam SUM_W   = REL_W + 11;  // of a scaled address after two subtractions

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
    reg signed [10:0] off_u_s2, off_v_s2, off_u_s3, off_v_s3, off_u_s4, off_v_s4;
    reg signed [7:0]  skew_s2, skew_s3, skew_s4, skew_s5;

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
        {off_u_s3, off_v_s3, skew_s3} <= {off_u_s2, off_v_s2, skew_s2};
        {off_u_s4, off_v_s4, skew_s4} <= {off_u_s3, off_v_s3, skew_s3};
        skew_s5                       <= skew_s4;
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

    // -1536 to 1535 in 12 bits
    function [11:0] clamped;
        input signed [SUM_W-1:0] value;
        begin
            if (value[SUM_W-1]) clamped = (&value[SUM_W-2:11] && value[10:9] != 2'b00) ? value[11:0] : -12'd1536;
            else clamped = (!(|value[SUM_W-2:11]) && value[10:9] != 2'b11) ? value[11:0] : 12'd1535;
        end
    endfunction

    wire signed [SUM_W-1:0] off_x = {{2{scaled_x[REL_W+12]}}, scaled_x[REL_W+12:4]} - {{(SUM_W - 11) {off_u_s4[10]}}, off_u_s4};
    wire signed [SUM_W-1:0] off_y = {{2{scaled_y[REL_W+12]}}, scaled_y[REL_W+12:4]} - {{(SUM_W - 11) {off_v_s4[10]}}, off_v_s4};

    reg signed [SUM_W-1:0] straight_u_s5, straight_u_s6, straight_u_s7;
    reg signed [11:0]      v_s5, v_s6, v_s7, v_s8, u_s8;

    wire signed [19:0]      sheared;  // s7
    wire signed [SUM_W-1:0] off_sheared = straight_u_s7 - {{(SUM_W - 13) {sheared[19]}}, sheared[19:7]};

    multiplier #(
        .A_W(8),
        .B_W(12)
    ) u_shear (
        .clk(clk),
        .a  (skew_s5),
        .b  (v_s5),
        .p  (sheared)
    );

    always @(posedge clk) begin
        straight_u_s5 <= off_x;
        straight_u_s6 <= straight_u_s5;
        straight_u_s7 <= straight_u_s6;
        v_s5          <= clamped(off_y);
        v_s6          <= v_s5;
        v_s7          <= v_s6;
        v_s8          <= v_s7;
        u_s8          <= clamped(off_sheared);
    end

    // ---- the cell ----------------------------------------------------------------------------------------------------

    wire [3:0] row    = v_s8[11:8] + 4'd6;
    wire [3:0] column = u_s8[11:8] + 4'd6;
    wire [7:0] cell_s8 = {1'b0, row, 3'd0} + {2'd0, row, 2'd0} + {4'd0, column};
    reg  [7:0] cell_s9;

    reg [LATENCY-1:0]        valids;
    reg [LATENCY-1:0]        firsts;
    reg [LATENCY*SLOT_W-1:0] slots;

    always @(posedge clk) begin
        cell_s9 <= cell_s8;
        valids  <= {valids[LATENCY-2:0], s_valid};
        firsts  <= {firsts[LATENCY-2:0], s_first};
        slots   <= {slots[(LATENCY-1)*SLOT_W-1:0], s_slot};
        if (rst) valids <= {LATENCY{1'b0}};
    end

    assign m_valid = valids[LATENCY-1];
    assign m_first = firsts[LATENCY-1];
    assign m_slot  = slots[(LATENCY-1)*SLOT_W +: SLOT_W];
    assign {m_word, m_lane} = cell_s9;

    wire unused = &{1'b0, v_s8[7:0], u_s8[7:0], sheared[6:0], scaled_x[3:0], scaled_y[3:0]};

endmodule

`default_nettype wire
