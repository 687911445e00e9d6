// SPDX-License-Identifier: Apache-2.0
// Windows to verdicts: rules F and V of docs/recognition.md, one window after the other.
//
// A unit is a sum over 18 rows of the weights, each read with a word of the image. Units 0 to 4 are the moments of the fit, whose
// weights are constants, units 5 to 36 the hidden layer. classifier_sum.v forms all sums. One more multiplier corrects the
// normalisation with the moments, and then multiplies hidden units with the second layer's weights: the ninth weights in the last
// ten rows of the next unit. Then the scores are read for the largest, once more for the losses and
// votes, two clocks a class, and the votes for the least but one.
// The fields of the normalisation and the votes are in the rows of the slot, behind the weights.
//
// Units 0 to 5 have three clocks more, words 18 to 20: the field that the moment before has corrected is written, first where the
// evaluation reads it, then where events do, and the field that this moment corrects is read.
//
// Cycles count from the clock in which `word_reg` is the last word of a unit: weights and cells come in cycle 3, the sum in 9, a
// hidden unit in 12; of a moment its product in 12, the field in 23. In the votes they count from a class's turn.
//
// Latency:    765 clocks a window, 179 the first one of a track. Rule Q3 asks for at most 768.
// Throughput: 1 window at a time.
// Stall:      none.
// Reset:      ends the evaluation.
// Combinational paths: from scale_start to row_data, from s_young to m_valid.
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
    output wire [7:0]        word_bit,     // bit word / 2, but of words 16 and 17
    input  wire [31:0]       cells,
    input  wire [3:0]        filled,       // by pairs of cells: else both are 0

    // rows of the weights
    output wire [ROW_W-1:0]  row,
    input  wire [63:0]       weights,
    input  wire [7:0]        ninth,
    input  wire [14:0]       kept,         // what a row of a slot has in bank 0
    output wire [3:0]        row_write,    // by banks
    output wire [14:0]       row_data,

    // a new skew
    output wire              skew_valid,
    output wire [7:0]        skew,

    // verdict, with s_done
    output wire              m_valid,
    output wire [3:0]        m_class,      // 15: none of these
    output wire [14:0]       m_margin,
    output wire [7:0]        m_windows
);

    parameter_check #(.OK(N >= 1 && N <= 64)) N_must_be_1_to_64 ();
    parameter_check #(.OK(ROW_W >= ((N > 16) ? 11 : 10))) ROW_W_must_be_at_least_10_or_11_beyond_16_slots ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam [5:0] FIT_LAST    = 6'd5;   // unit: the field of the last moment is written in it
    localparam [5:0] OUTPUT_LAST = 6'd37;  // unit: the weights of the last hidden unit are read in it
    localparam [4:0] WORD_LAST   = 5'd17;  // of an image
    localparam [4:0] FIELD_WRITE = 5'd18, EVENTS_WRITE = 5'd19, FIELD_READ = 5'd20;
    localparam [4:0] CLASS_FIRST = 5'd8;   // word with the ninth weight of the first class, up to WORD_LAST
    localparam [4:0] VOTES_FIRST = 5'd30;  // word in which the votes begin: with entry 15, then 0, by two words
    localparam [4:0] VOTES_LAST  = 5'd28;
    localparam [4:0] COMPARED_LAST = 5'd28;
    localparam [3:0] ROW_FIELDS  = 4'd10;  // rows of a slot: votes, fields, and the number of windows in the vote
    localparam [3:0] ROW_EVENTS  = 4'd11;  // with the fields for events, and the scale of x for the evaluation

    // ---- sequence ----------------------------------------------------------------------------------------------------

    reg             running;
    reg             fitting;  // units 0 to 5
    reg             scoring;  // the largest score is looked for
    reg             voting;
    reg             comparing;  // the votes with the least
    reg [5:0]       unit;
    reg [4:0]       word_reg;
    reg [7:0]       word_bit_reg;
    reg [ROW_W-1:0] row_reg;
    reg [3:0]       field_row;

    wire behind    = fitting && word_reg[4] && |word_reg[2:1];  // the words
    wire fit_ends  = fitting && word_reg == FIELD_READ;
    wire hidden    = running && !fitting && !scoring && !voting && !comparing;
    wire unit_ends = fit_ends || (hidden || scoring) && word_reg == WORD_LAST;
    wire to_vote   = unit_ends && (scoring || (s_young && unit == FIT_LAST));
    wire to_score  = unit_ends && hidden && unit == OUTPUT_LAST;

    wire to_compare = voting && word_reg == VOTES_LAST;

    assign s_done   = comparing && word_reg == COMPARED_LAST;

    always @(posedge clk) begin
        word_reg <= word_reg + 5'd1;
        if (word_reg[0]) word_bit_reg <= word_bit_reg << 1;
        if (!behind) row_reg <= row_reg + 1'b1;
        if (fitting && word_reg == FIELD_WRITE) field_row <= field_row + 4'd1;
        if (unit_ends) begin
            word_reg     <= to_vote ? VOTES_FIRST : to_score ? CLASS_FIRST : 5'd0;
            word_bit_reg <= 8'd1;
            unit         <= unit + 6'd1;
            if (unit == FIT_LAST) fitting <= 1'b0;
            scoring <= to_score;
            voting  <= to_vote;
        end
        if (to_compare) begin
            word_reg  <= CLASS_FIRST;
            voting    <= 1'b0;
            comparing <= 1'b1;
        end
        if (s_done) {running, comparing} <= 2'b00;
        if (!running) begin
            running      <= s_valid;
            fitting      <= s_valid;
            unit         <= 6'd0;
            word_reg     <= 5'd0;
            word_bit_reg <= 8'd1;
            row_reg      <= {ROW_W{1'b0}};
            field_row    <= ROW_FIELDS - 4'd1;
        end
        if (rst) {running, fitting, scoring, voting, comparing} <= 5'b00000;
    end

    // ---- what is under way, by cycle ---------------------------------------------------------------------------------

    reg [3:1]  adds, begins;  // rows of a sum
    reg [12:1] ends;          // of a unit's words
    reg [3:1]  hidden_d;
    reg [4:1]  first_hidden;
    reg [5:1]  multiplies;    // with weights of the second layer
    reg [5:1]  scores;        // is compared with the largest
    reg [3:1]  reads_field;
    reg [9:1]  has_turn;      // in the votes
    reg [8:1]  compares;      // its vote, with the least
    reg        compares_9;    // in the votes, too; the second time not the winner's
    reg [3:0]  class_1, class_2, class_3, class_4, class_5, class_6, class_7, class_8, class_9;
    reg [8:6]  counts;        // the class is one of `classes`

    wire [3:0] winner;
    wire [3:0] class_0  = voting ? word_reg[4:1] : {!word_reg[3], word_reg[2:0]};
    wire       is_ninth = word_reg[4] || word_reg[3];

    always @(posedge clk) begin
        adds         <= {adds[2:1], running && !behind};
        begins       <= {begins[2:1], word_reg == 5'd0};
        ends         <= {ends[11:1], word_reg == WORD_LAST};
        hidden_d     <= {hidden_d[2:1], hidden};
        first_hidden <= {first_hidden[3:1], unit == FIT_LAST + 6'd1};
        multiplies   <= {multiplies[4:1], hidden && is_ninth};
        scores       <= {scores[4:1], scoring};
        reads_field  <= {reads_field[2:1], fit_ends};
        compares     <= {compares[7:1], comparing};
        compares_9   <= counts[8] && (has_turn[8] || (compares[8] && class_8 != winner));
        has_turn     <= {has_turn[8:1], voting && !word_reg[0]};
        {class_1, class_2, class_3, class_4} <= {class_0, class_1, class_2, class_3};
        {class_5, class_6, class_7, class_8} <= {class_4, class_5, class_6, class_7};
        class_9 <= class_8;
        counts  <= {counts[7:6], class_5 < classes};
        if (rst) begin
            multiplies <= 5'd0;
            scores     <= 5'd0;
            has_turn   <= 9'd0;
            compares   <= 8'd0;
        end
    end

    // ---- rows --------------------------------------------------------------------------------------------------------

    // The rows of slots are the last ones. The one before them has the scale of a track's first window, and is written without end
    // while no window is evaluated.
    localparam [ROW_W-1:0] ROW_START = 767;

    reg  [4:0]       word_1;
    reg  [7:0]       word_bit_1;
    reg  [ROW_W-1:0] row_1;
    reg  [3:0]       write_1;
    reg              start_1;
    reg              skew_1;
    reg  [3:0]       vote_index, field_index;  // one of them is 0
    wire [3:0]       index = vote_index | field_index;

    wire [ROW_W-1:0] slot_row = ((N > 16) ? {1'b1, {(ROW_W - 1) {1'b0}}} : {2'b11, {(ROW_W - 2) {1'b0}}})
        | {{(ROW_W - 4 - SLOT_W) {1'b0}}, s_slot, index};

    // From cycle 4 of moment m to 24, `unit` is m + 1.
    wire is_scale     = unit[2:0] == 3'd2 || unit[2:0] == 3'd4;
    wire is_skew      = unit[2:0] == 3'd5;
    wire writes_field = fitting && unit[2:0] != 3'd0 && word_reg == FIELD_WRITE;
    wire for_events   = fitting && word_reg == EVENTS_WRITE;

    wire [11:0] value;
    wire [14:0] vote;

    always @(posedge clk) begin
        vote_index  <= (voting && word_reg[0]) ? class_7 : class_2;
        field_index <= (word_reg == FIELD_WRITE) ? ROW_EVENTS : field_row;
        if (fitting) vote_index <= 4'd0;
        if (!fitting) field_index <= 4'd0;
        word_1     <= word_reg;
        word_bit_1 <= word_bit_reg;
        row_1      <= (behind || voting || comparing) ? slot_row : row_reg;
        if (!running || (fitting && s_young && word_reg == FIELD_READ)) row_1 <= ROW_START;
        write_1    <= {for_events && unit[2:0] == 3'd3, for_events && unit[2:0] == 3'd1, for_events && unit[2:0] == 3'd4,
            writes_field || (voting && !to_compare && has_turn[8])};
        if (!running) write_1 <= 4'b0011;
        start_1    <= !running;
        skew_1     <= for_events && is_skew;
    end

    assign word       = word_1;
    assign word_bit   = word_bit_1;
    assign row        = row_1;
    assign row_write  = write_1;
    assign row_data   = {vote[14:12], (start_1 ? scale_start : 12'd0) | value | vote[11:0]};
    assign skew_valid = skew_1;
    assign skew       = value[7:0];

    // ---- the field that a moment corrects ----------------------------------------------------------------------------

    reg [11:0] field;
    reg [12:0] factor;     // of the moment. Offsets and skew: in units that the shift after a scale's product suits too
    reg [2:0]  fit_shift;

    always @(posedge clk) begin
        if (reads_field[3]) begin
            field <= kept[11:0];
            if (s_young && !is_scale) field <= 12'd0;
        end
        factor <= 13'd0;
        if (is_scale) factor <= {1'b0, field};
        if (is_skew) factor[8] <= 1'b1;
        if (!is_scale && !is_skew) factor[10] <= 1'b1;
        if (!fitting) factor <= 13'd0;
        fit_shift <= window_log2[2:0] + (s_young ? 3'd0 : 3'd2);
    end

    // ---- sums, and the one multiplier for all else -------------------------------------------------------------------

    wire        [19:0] sum;
    reg         [15:0] moment;
    reg         [7:0]  amount;     // a hidden unit, or a loss
    reg         [7:0]  voted;
    reg         [7:0]  least_mean; // margin_min while votes are compared
    wire signed [28:0] product;
    wire        [12:0] ninth_13 = {{5{ninth[7]}}, ninth} & {13{hidden_d[3]}};

    classifier_sum u_sum (
        .clk      (clk),
        .s_valid  ({4{adds[3]}} & filled),
        .s_begin  (begins[3]),
        .s_weights(weights),
        .s_cells  (cells),
        .sum      (sum)
    );

    // What does not count is 0.
    multiplier #(
        .A_W(13),
        .B_W(16)
    ) u_product (
        .clk(clk),
        .a  (ninth_13 | factor | {5'd0, least_mean}),
        .b  ({moment[15:8], moment[7:0] | (comparing ? voted : amount)}),
        .p  (product)
    );

    always @(posedge clk) begin
        moment     <= fitting ? sum[15:0] : 16'd0;
        least_mean <= comparing ? margin_min : 8'd0;
    end

    // ---- scores ------------------------------------------------------------------------------------------------------

    reg  [20:0] score [0:15];
    reg  [20:0] score_5, score_most;
    wire [21:0] score_next;

    classifier_score #(
        .W(22)
    ) u_score (
        .minus  (!multiplies[5]),
        .score  ({score_5[20], score_5}),
        .product({{6{product[15]}}, product[15:0]}),
        .most   ({score_most[20], score_most}),
        .y      (score_next)
    );

    always @(posedge clk) begin
        score_5 <= score[class_4];
        if (first_hidden[4]) score_5 <= 21'd0;
        if (multiplies[5]) score[class_5] <= score_next[20:0];
        if (scores[5] && class_5 < classes && (class_5 == 4'd0 || score_next[21])) score_most <= score_5;
    end

    // ---- hidden units and losses: shifted, and limited to 0 to 255 ---------------------------------------------------

    wire [20:0] operand = voting ? score_next[20:0] : {1'b0, sum[19:0]};
    wire        is_none = fitting || comparing || (voting ? class_5 == 4'd15 : sum[19]);
    wire [3:0]  shift   = voting ? shift_2 : shift_1;
    wire [10:0] coarse_0;
    wire [7:0]  fine_0;
    reg  [10:0] coarse;
    reg  [1:0]  coarse_shift, fine_shift;
    reg  [2:0]  rest;       // operand has bits from 11, 15, 19 on
    reg  [7:0]  fine;
    reg  [1:0]  is_beyond;

    mux4 #(
        .W(11)
    ) u_coarse (
        .select(shift[3:2]),
        .words ({2'b00, operand[20:12], operand[18:8], operand[14:4], operand[10:0]}),
        .y     (coarse_0)
    );

    mux4 #(
        .W(8)
    ) u_fine (
        .select(fine_shift),
        .words ({coarse[10:3], coarse[9:2], coarse[8:1], coarse[7:0]}),
        .y     (fine_0)
    );

    always @(posedge clk) begin
        coarse       <= coarse_0;
        coarse_shift <= shift[3:2];
        fine_shift   <= shift[1:0];
        rest         <= {|operand[20:19], |operand[18:15], |operand[14:11]};
        if (is_none) begin
            coarse <= 11'd0;
            rest   <= 3'd0;
        end
        fine         <= fine_0;
        is_beyond[0] <= (rest[2] && coarse_shift != 2'd3) || (rest[1] && !coarse_shift[1]) || (rest[0] && coarse_shift == 2'd0);
        is_beyond[1] <= (coarse[10] && fine_shift != 2'd3) || (coarse[9] && !fine_shift[1]) || (coarse[8] && fine_shift == 2'd0);
        if (ends[11] || fitting || voting || comparing) amount <= |is_beyond ? 8'd255 : fine;
    end

    // ---- fit ---------------------------------------------------------------------------------------------------------

    classifier_fit u_fit (
        .clk      (clk),
        .clears   (!fitting),
        .is_scale (is_scale),
        .is_skew  (is_skew),
        .field    (field),
        .s_valid  (ends[12]),
        .s_product(product[28:11]),
        .s_shift  (fit_shift),
        .value    (value)
    );

    // ---- vote --------------------------------------------------------------------------------------------------------

    reg         blank, halves;
    reg  [14:0] vote_before;

    always @(posedge clk) begin
        vote_before <= kept;
        if (has_turn[6] && class_6 == 4'd15) begin
            blank  <= s_young || kept[7:0] == 8'd0;
            halves <= kept[7];  // 128
        end
        if (comparing) {blank, halves} <= 2'b00;
        if (has_turn[9] && class_9 == 4'd15) voted <= vote[7:0];
    end

    classifier_vote u_vote (
        .clk     (clk),
        .begins  (fitting),
        .blank   (blank),
        .halves  (halves),
        .s_before(vote_before),
        .s_loss  (amount),
        .s_more  (class_8 == 4'd15 && !s_young),
        .clears  (!(voting || comparing)),
        .is_class(compares_9),
        .turns   (to_compare),
        .again   (comparing),
        .class_id(class_9),
        .vote    (vote),
        .winner  (winner),
        .margin  (m_margin)
    );

    assign m_valid   = s_done && !s_young;
    assign m_class   = ({1'b0, m_margin} < product[15:0]) ? 4'd15 : winner;
    assign m_windows = voted;

    wire unused = &{1'b0, window_log2[3]};

endmodule

`default_nettype wire
