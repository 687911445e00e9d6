// SPDX-License-Identifier: Apache-2.0
// Windows to verdicts: rules F and V of docs/recognition.md, one window after the other.
//
// A unit is a sum over 18 rows of the weights, each read with a word of the image. Units 0 to 4 are the moments of the fit, whose
// weights are constants, units 5 to 36 the hidden layer. classifier_sum.v forms all sums. One more multiplier corrects the
// normalisation with the moments, and then multiplies hidden units with the second layer's weights: the ninth weights in the last
// ten rows of the next unit. One shifter serves shift_1, shift_2 and the fit. After a moment the field that it corrects is read.
// The fields and the votes are in the rows of the slot, behind the weights.
//
// Cycles within a window count from the one in which the last word of a unit is addressed: weights and cells come in cycle 2, the
// sum in 8, a hidden unit in 11; of a moment its product in 10, the correction in 12, the field in 14.
//
// Latency:    746 clocks a window, 112 the first one of a track. Rule Q3 asks for at most 768.
// Throughput: 1 window at a time.
// Stall:      none.
// Reset:      ends the evaluation.
// Combinational paths: from s_slot to row and keep_row, from s_young to keep_value and m_valid.
`default_nettype none

module classifier_evaluator #(
    parameter N      = 8,   // slots of the tracker
    parameter ROW_W  = 10,  // bits of a row's number
    parameter SLOT_W = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire              clk,
    input  wire              rst,

    // registers
    input  wire [3:0]        window_log2,
    input  wire [11:0]       scale_start,
    input  wire [3:0]        shift_1,
    input  wire [3:0]        shift_2,
    input  wire [3:0]        classes,
    input  wire [7:0]        margin_min,

    // the window
    input  wire              s_valid,
    input  wire [SLOT_W-1:0] s_slot,
    input  wire              s_young,      // in the first window of a track
    output wire              s_done,       // it is not read again

    // its image
    output wire [4:0]        word,
    output wire [8:0]        word_bit,     // bit word / 2
    input  wire [31:0]       cells,
    input  wire [3:0]        filled,       // by pairs of cells: else both are 0

    // weights, and values kept in the rows of a slot
    output wire [ROW_W-1:0]  row,
    input  wire [63:0]       weights,
    input  wire [7:0]        ninth,
    input  wire [14:0]       kept,
    output wire              keep,
    output wire [ROW_W-1:0]  keep_row,
    output wire [14:0]       keep_value,

    // a new value of one field of the normalisation
    output wire [4:0]        fit_field,
    output wire [11:0]       fit_value,

    // verdict, with s_done
    output wire              m_valid,
    output wire [3:0]        m_class,      // 15: none of these
    output wire [14:0]       m_margin,
    output wire [7:0]        m_windows
);

    parameter_check #(.OK(N >= 1 && N <= 64)) N_must_be_1_to_64 ();
    parameter_check #(.OK(ROW_W >= ((N > 16) ? 11 : 10))) ROW_W_must_be_at_least_10_or_11_beyond_16_slots ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam [5:0] HIDDEN_FIRST = 6'd5;   // units: moments before it,
    localparam [5:0] OUTPUT_LAST  = 6'd37;  // and behind the last hidden one the last weights of the second layer
    localparam [4:0] WORD_LAST    = 5'd17;  // of an image
    localparam [4:0] NINTH_FIRST  = 5'd8, NINTH_LAST = 5'd17;  // words with weights of the hidden unit before
    localparam [3:0] KEPT_FIELDS  = 4'd10;  // rows of a slot: votes, fields, and the number of windows in the vote
    localparam [3:0] KEPT_VOTED   = 4'd15;
    localparam [7:0] VOTED_MAX    = 8'd128;

    // Steps of the vote.
    localparam [4:0] STEP_CLASS = 5'd6;   // the first class is read; then the largest score is known
    localparam [4:0] STEP_YOUNG = 5'd8;   // where a window without verdict begins: the last field takes as long
    localparam [4:0] STEP_LAST  = 5'd15;  // the last class
    localparam [4:0] STEP_DONE  = 5'd23;

    // ---- sequence ----------------------------------------------------------------------------------------------------

    reg             in_rows, in_votes;
    reg [5:0]       unit;
    reg [4:0]       word_reg;
    reg [8:0]       word_bit_reg;
    reg [ROW_W-1:0] row_reg;
    reg [4:0]       step;

    wire in_moment = unit < HIDDEN_FIRST;
    wire on_field  = word_reg == WORD_LAST + 5'd1;  // after the words of a moment
    wire rows_end  = (s_young && unit == HIDDEN_FIRST - 6'd1 && on_field) || (unit == OUTPUT_LAST && word_reg == NINTH_LAST);
    wire is_class  = in_votes && !s_young && step >= STEP_CLASS && step <= STEP_LAST;
    wire [3:0] class_0 = step[3:0] - STEP_CLASS[3:0];

    assign word     = word_reg;
    assign word_bit = word_bit_reg;
    assign s_done = in_votes && step == STEP_DONE;

    always @(posedge clk) begin
        if (in_rows) begin
            word_reg <= word_reg + 5'd1;
            if (word_reg[0]) word_bit_reg <= word_bit_reg << 1;
            if (!on_field) row_reg <= row_reg + 1'b1;
            if (on_field) begin
                word_reg     <= 5'd0;
                word_bit_reg <= 9'd1;
                unit     <= unit + 6'd1;
            end
            if (rows_end) begin
                in_rows  <= 1'b0;
                in_votes <= 1'b1;
                step     <= s_young ? STEP_YOUNG : 5'd0;
            end
        end else if (in_votes) begin
            step     <= step + 5'd1;
            in_votes <= !s_done;
        end else begin
            in_rows      <= s_valid;
            unit         <= 6'd0;
            word_reg     <= 5'd0;
            word_bit_reg <= 9'd1;
            row_reg      <= {ROW_W{1'b0}};
        end
        if (rst) {in_rows, in_votes} <= 2'b00;
    end

    // The rows of slots are the last ones.
    function [ROW_W-1:0] slot_row;
        input [SLOT_W-1:0] slot;
        input [3:0]        index;
        slot_row = ((N > 16) ? {1'b1, {(ROW_W - 1) {1'b0}}} : {2'b11, {(ROW_W - 2) {1'b0}}})
            | {{(ROW_W - 4 - SLOT_W) {1'b0}}, slot, index};
    endfunction

    wire [3:0] field_index = KEPT_FIELDS + {1'b0, unit[2:0]};

    // ---- what is under way, by cycle ---------------------------------------------------------------------------------

    reg [2:1]  adds, begins;  // rows of a sum
    reg [8:1]  ends_moment;
    reg [10:1] ends_hidden;
    reg [2:1]  reads_field;
    reg [14:9] fits;
    reg [4:1]  multiplies;    // with weights of the second layer
    reg [2:1]  reads_voted;
    reg [5:1]  is_class_d;
    reg [19:0] class_d;       // class_0 of the last five clocks

    wire is_ninth = in_rows && unit > HIDDEN_FIRST && word_reg >= NINTH_FIRST && word_reg <= NINTH_LAST;
    wire [3:0] ninth_0 = word_reg[3:0] - NINTH_FIRST[3:0];

    always @(posedge clk) begin
        adds        <= {adds[1], in_rows && !on_field};
        begins      <= {begins[1], on_field || !in_rows};
        ends_moment <= {ends_moment[7:1], in_rows && in_moment && word_reg == WORD_LAST};
        ends_hidden <= {ends_hidden[9:1], in_rows && !in_moment && word_reg == WORD_LAST};
        reads_field <= {reads_field[1], in_rows && on_field};
        fits        <= {fits[13:9], ends_moment[8]};
        multiplies  <= {multiplies[3:1], is_ninth};
        reads_voted <= {reads_voted[1], in_votes && step == 5'd0};
        is_class_d  <= {is_class_d[4:1], is_class};
        class_d     <= {class_d[15:0], class_0};
        if (rst) begin
            fits        <= 6'd0;
            ends_moment <= 8'd0;
            is_class_d  <= 5'd0;
        end
    end

    assign row = in_rows ? (on_field ? slot_row(s_slot, field_index) : row_reg)
        : slot_row(s_slot, is_class_d[2] ? class_d[7:4] : KEPT_VOTED);

    // ---- the field that a moment corrects ----------------------------------------------------------------------------

    // From cycle 2 of moment m to 20, `unit` is m + 1.
    wire after_scale = unit == 6'd2 || unit == 6'd4;
    wire after_skew  = unit == 6'd5;
    reg [11:0] field;
    reg [3:0]  fit_shift;

    always @(posedge clk) begin
        if (reads_field[2]) begin
            field <= kept[11:0];
            if (s_young) field <= after_scale ? scale_start : 12'd0;
        end
        fit_shift <= window_log2 - (s_young ? 4'd7 : 4'd5);
    end

    // ---- sums, and the one multiplier for all else -------------------------------------------------------------------

    wire signed [19:0] sum;
    reg         [7:0]  amount;    // a hidden unit, or a loss
    reg         [7:0]  voted;
    wire signed [28:0] product;

    classifier_sum u_sum (
        .clk      (clk),
        .s_valid  ({4{adds[2]}} & filled),
        .s_begin  (begins[2]),
        .s_weights(weights),
        .s_cells  (cells),
        .sum      (sum)
    );

    wire limits = in_votes && step[4];  // the last class is read: the multiplier computes the least margin

    // Offsets and skew are corrected by their moment alone, in units that the shift after a scale's product suits too.
    wire signed [12:0] factor = ends_moment[8] ? (after_scale ? {1'b0, field} : after_skew ? 13'sd256 : 13'sd1024)
        : limits ? {5'd0, margin_min} : {{5{ninth[7]}}, ninth};

    multiplier #(
        .A_W(13),
        .B_W(16)
    ) u_product (
        .clk(clk),
        .a  (factor),
        .b  (ends_moment[8] ? sum[15:0] : {8'd0, limits ? voted : amount}),
        .p  (product)
    );

    // ---- scores ------------------------------------------------------------------------------------------------------

    reg signed [20:0] score [0:15];
    reg signed [20:0] score_now, score_most;
    reg        [11:0] ninth_class;  // ninth_0 of the last three clocks
    reg               is_first;     // of the classes
    reg        [4:1]  adds_first;   // hidden unit
    reg        [4:1]  adds_last;
    reg               is_most;      // score_now counts for the largest

    // One read port: of the class whose product comes, or of the one that is voted for.
    reg         [3:0]  scored;
    wire signed [20:0] score_read = score[scored];
    wire signed [20:0] score_next = (adds_first[4] ? 21'sd0 : score_read) + {{5{product[15]}}, product[15:0]};
    wire signed [21:0] distance = {score_most[20], score_most} - {score_read[20], score_read};

    always @(posedge clk) begin
        ninth_class <= {ninth_class[7:0], ninth_0};
        scored      <= multiplies[3] ? ninth_class[11:8] : class_0;
        adds_first  <= {adds_first[3:1], unit == HIDDEN_FIRST + 6'd1};
        adds_last   <= {adds_last[3:1], unit == OUTPUT_LAST};
        if (multiplies[4]) score[scored] <= score_next;
        score_now <= score_next;
        is_first  <= scored == 4'd0;
        is_most   <= multiplies[4] && adds_last[4] && scored < classes;
        if (is_most && (is_first || score_most < score_now)) score_most <= score_now;
    end

    // ---- the shifter -------------------------------------------------------------------------------------------------

    reg signed [21:0] shifted;
    reg signed [21:0] operand;
    reg        [3:0]  shift;

    always @(posedge clk) begin
        operand <= fits[10] ? {{3{product[28]}}, product[28:10]} : is_class_d[1] ? distance : {{2{sum[19]}}, sum};
        shift   <= fits[10] ? fit_shift : is_class_d[1] ? shift_2 : shift_1;
        shifted <= operand >>> shift;
        if (ends_hidden[10] || is_class_d[3]) begin
            amount <= shifted[21] ? 8'd0 : |shifted[20:8] ? 8'd255 : shifted[7:0];
        end
    end

    // ---- fit ---------------------------------------------------------------------------------------------------------

    classifier_fit u_fit (
        .clk       (clk),
        .is_scale  (after_scale),
        .is_skew   (after_skew),
        .field     (field),
        .correction(shifted[17:0]),
        .value     (fit_value)
    );

    genvar f;
    generate
        for (f = 0; f < 5; f = f + 1) begin : g_field
            assign fit_field[f] = fits[14] && unit == f + 1;
        end
    endgenerate

    // ---- vote --------------------------------------------------------------------------------------------------------

    reg  [7:0]  voted_before;  // 0: none since the first window of the track
    wire        halves = voted_before == VOTED_MAX;
    wire [14:0] vote;
    wire [3:0]  winner;

    always @(posedge clk) begin
        if (reads_voted[2]) voted_before <= kept[7:0];
        voted <= (halves ? VOTED_MAX >> 1 : voted_before) + 8'd1;
    end

    classifier_vote u_vote (
        .clk    (clk),
        .begins (in_rows),
        .blank  (voted_before == 8'd0),
        .halves (halves),
        .s_valid(is_class_d[4] && class_d[15:12] < classes),
        .s_class(class_d[15:12]),
        .s_vote (kept),
        .s_loss (amount),
        .vote   (vote),
        .winner (winner),
        .margin (m_margin)
    );

    assign keep       = fits[14] || is_class_d[5] || s_done;
    assign keep_row   = slot_row(s_slot, fits[14] ? field_index - 4'd1 : is_class_d[5] ? class_d[19:16] : KEPT_VOTED);
    assign keep_value = fits[14] ? {3'd0, fit_value} : is_class_d[5] ? vote : s_young ? 15'd0 : {7'd0, voted};

    assign m_valid   = s_done && !s_young;
    assign m_class   = ({1'b0, m_margin} < product[15:0]) ? 4'd15 : winner;
    assign m_windows = voted;

endmodule

`default_nettype wire
