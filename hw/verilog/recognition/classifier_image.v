// SPDX-License-Identifier: Apache-2.0
// The images of all slots: rules N2 and W4 of docs/recognition.md.
//
// A slot has 18 words of four bytes, a byte has two counters and a bit that says that they count. There are two copies, one read by
// events and one by the evaluation. An event reads its byte, increments a counter, and writes the byte; a byte that one of the two
// events before it is about to write is forwarded. Clearing an image takes no time: a bit per word says whether the word was written
// in this window. The event that writes a word first writes all of its bytes, and the others do not count.
//
// Latency:    an event is in the image 6 clocks after s_; 2 clocks from read_ to cells and `filled`.
// Throughput: 1 event and one word read per clock.
// Stall:      none.
// Reset:      no event is inside. The images are not reset.
// Combinational paths: none.
`default_nettype none

module classifier_image #(
    parameter N      = 8,  // slots of the tracker
    parameter SLOT_W = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire              clk,
    input  wire              rst,

    // events
    input  wire              s_valid,
    input  wire [SLOT_W-1:0] s_slot,
    input  wire              s_first,    // of its window
    input  wire [4:0]        s_word,
    input  wire [2:0]        s_lane,

    // evaluation, of slots without events
    input  wire [SLOT_W-1:0] read_slot,
    input  wire [4:0]        read_word,
    input  wire [7:0]        read_bit,   // bit read_word / 2, but of words 16 and 17
    output wire [31:0]       cells,
    output wire [3:0]        filled      // by pairs of cells. Low: both are 0, whatever `cells` says
);

    parameter_check #(.OK(N >= 1)) N_must_be_at_least_1 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam HALF   = 8;  // words 0 to 15 of an image that are even, and that are odd
    localparam ADDR_W = SLOT_W + 5;
    localparam DEPTH  = 1 << ADDR_W;

    // ---- words written in this window --------------------------------------------------------------------------------

    // By the clocks since s_.
    reg              valid_1, valid_2, valid_3, valid_4, valid_5;
    reg              first_1;
    reg [ADDR_W-1:0] address_1, address_2, address_3, address_4, address_5;
    reg [HALF-1:0]   word_bit_1;
    reg [1:0]        pair_1, pair_2, pair_3, pair_4, pair_5;  // byte of the word
    reg              lane_1, lane_2, lane_3, lane_4, lane_5;  // cell of the pair
    reg              half_2;              // a word of its half was written before
    reg              last_2;              // its own was, of words 16 and 17
    reg [3:0]        bits_2;              // its own was, by two words
    reg              written_3;
    reg              opens_4, opens_5;    // its word was not

    // Of a slot's even or odd words, if one of them was written: bits 0 and 1 of `halves` say. Bits 2 and 3 are of words 16 and 17.
    (* no_rw_check *) reg [HALF-1:0] written [0:(2<<SLOT_W)-1];
    (* no_rw_check *) reg [3:0]      halves  [0:N-1];

    wire [SLOT_W-1:0] slot_1       = address_1[ADDR_W-1:5];
    wire              is_odd_1     = address_1[0];
    wire              is_last_1    = address_1[4];
    wire [3:0]        known_halves = halves[slot_1] & {4{!first_1}};
    wire [3:0]        this_half    = 4'd1 << {is_last_1, is_odd_1};
    wire              known_half   = is_odd_1 ? known_halves[1] : known_halves[0];
    wire [HALF-1:0]   stored_words = written[{slot_1, is_odd_1}];

    function [3:0] by_twos;
        input [HALF-1:0] of;
        by_twos = {|of[7:6], |of[5:4], |of[3:2], |of[1:0]};
    endfunction

    always @(posedge clk) begin
        word_bit_1 <= {{(HALF - 1) {1'b0}}, 1'b1} << s_word[3:1];
        half_2     <= known_half && !is_last_1;
        last_2     <= is_last_1 && (is_odd_1 ? known_halves[3] : known_halves[2]);
        bits_2     <= by_twos(stored_words & word_bit_1);
        written_3  <= last_2 || (half_2 && |bits_2);
        if (valid_1 && !is_last_1) begin
            written[{slot_1, is_odd_1}] <= (stored_words & {HALF{known_half}}) | word_bit_1;
        end
        if (valid_1) halves[slot_1] <= known_halves | this_half;
    end

    // ---- events ------------------------------------------------------------------------------------------------------

    localparam TWOS = (ADDR_W + 1) / 2;

    reg [TWOS-1:0] equal_1, equal_second_1;  // to the words of the two events before, by two bits
    reg            same_2, second_2, same_3, second_3;
    reg            near_4, near_second_4;  // to the bytes
    reg            stored_4;               // its byte is in the memory
    reg [8:0]      byte_4;
    reg [7:0]      byte_5, byte_6;
    wire [7:0]     byte_next;

    function [TWOS-1:0] equal_by_twos;
        input [ADDR_W-1:0] a;
        input [ADDR_W-1:0] b;
        integer k;
        begin
            for (k = 0; k < TWOS; k = k + 1) begin
                equal_by_twos[k] = a[2*k] == b[2*k] && (2 * k + 1 == ADDR_W || a[(2*k+1)%ADDR_W] == b[(2*k+1)%ADDR_W]);
            end
        end
    endfunction

    classifier_count u_low (
        .adds (!lane_5),
        .count(byte_5[3:0]),
        .next (byte_next[3:0])
    );

    classifier_count u_high (
        .adds (lane_5),
        .count(byte_5[7:4]),
        .next (byte_next[7:4])
    );

    always @(posedge clk) begin
        {valid_1, valid_2, valid_3, valid_4, valid_5} <= {s_valid, valid_1, valid_2, valid_3, valid_4};
        {address_1, address_2, address_3, address_4, address_5} <= {s_slot, s_word, address_1, address_2, address_3, address_4};
        {pair_1, pair_2, pair_3, pair_4, pair_5}      <= {s_lane[2:1], pair_1, pair_2, pair_3, pair_4};
        {lane_1, lane_2, lane_3, lane_4, lane_5}      <= {s_lane[0], lane_1, lane_2, lane_3, lane_4};
        first_1            <= s_first;
        {opens_4, opens_5} <= {!written_3, opens_4};
        equal_1            <= equal_by_twos({s_slot, s_word}, address_1);
        equal_second_1     <= equal_by_twos({s_slot, s_word}, address_2);
        same_2             <= valid_2 && &equal_1;
        second_2           <= valid_3 && &equal_second_1;
        same_3             <= same_2;
        second_3           <= second_2;
        near_4             <= written_3 && same_3 && pair_4 == pair_3;
        near_second_4      <= written_3 && second_3 && pair_5 == pair_3 && !(same_3 && opens_4);
        stored_4           <= written_3 && !(same_3 && opens_4) && !(second_3 && opens_5);
        byte_5             <= near_4 ? byte_next : near_second_4 ? byte_6 : byte_4[7:0];
        if (!near_4 && !near_second_4 && !(stored_4 && byte_4[8])) byte_5 <= 8'd0;
        byte_6 <= byte_next;
        if (rst) {valid_1, valid_2, valid_3, valid_4, valid_5} <= 5'd0;
    end

    // ---- the copies --------------------------------------------------------------------------------------------------

    (* no_rw_check *) reg [8:0]  counted [0:4*DEPTH-1];
    (* no_rw_check *) reg [35:0] shown   [0:DEPTH-1];
    reg [35:0] word_1, word_2;
    reg        read_half_1, read_last_1, filled_2;
    reg [3:0]  read_bits_1;  // by two words

    wire [3:0] read_halves = halves[read_slot];

    wire [3:0] this_pair = 4'd1 << pair_5;
    wire [3:0] writes    = valid_5 ? (opens_5 ? 4'b1111 : this_pair) : 4'b0000;

    always @(posedge clk) begin
        if (writes[0]) counted[{address_5, 2'd0}] <= {this_pair[0], byte_next};
        if (writes[1]) counted[{address_5, 2'd1}] <= {this_pair[1], byte_next};
        if (writes[2]) counted[{address_5, 2'd2}] <= {this_pair[2], byte_next};
        if (writes[3]) counted[{address_5, 2'd3}] <= {this_pair[3], byte_next};
        byte_4 <= counted[{address_3, pair_3}];
    end

    always @(posedge clk) begin
        if (writes[0]) shown[address_5][8:0]   <= {this_pair[0], byte_next};
        if (writes[1]) shown[address_5][17:9]  <= {this_pair[1], byte_next};
        if (writes[2]) shown[address_5][26:18] <= {this_pair[2], byte_next};
        if (writes[3]) shown[address_5][35:27] <= {this_pair[3], byte_next};
        word_1   <= shown[{read_slot, read_word}];
        word_2   <= word_1;
        read_half_1 <= (read_word[0] ? read_halves[1] : read_halves[0]) && !read_word[4];
        read_last_1 <= (read_word[0] ? read_halves[3] : read_halves[2]) && read_word[4];
        read_bits_1 <= by_twos(written[{read_slot, read_word[0]}] & read_bit);
        filled_2    <= read_last_1 || (read_half_1 && |read_bits_1);
    end

    assign cells  = {word_2[34:27], word_2[25:18], word_2[16:9], word_2[7:0]};
    assign filled = {word_2[35], word_2[26], word_2[17], word_2[8]} & {4{filled_2}};

endmodule

`default_nettype wire
