// SPDX-License-Identifier: Apache-2.0
// The images of all slots: rules N2 and W4 of docs/recognition.md.
//
// A slot has 18 words of four bytes, a byte has two counters and a bit that says that they count. There are two copies, one read by
// events and one by the evaluation. An event reads its byte, increments a counter, and writes the byte; a byte that one of the two
// events before it is about to write is forwarded. Clearing an image takes no time: a bit per word says whether the word was written
// in this window. The event that writes a word first writes all of its bytes, and the others do not count.
//
// Latency:    an event is in the image 3 clocks after s_; 2 clocks from read_ to cells and `filled`.
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
    output wire [31:0]       cells,
    output wire [3:0]        filled      // by pairs of cells. Low: both are 0, whatever `cells` says
);

    parameter_check #(.OK(N >= 1)) N_must_be_at_least_1 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam HALF   = 9;  // words of an image that are even, and that are odd
    localparam ADDR_W = SLOT_W + 5;
    localparam DEPTH  = 1 << ADDR_W;

    // ---- words written in this window --------------------------------------------------------------------------------

    // Of a slot's even or odd words, if one of them was: `halves` says.
    reg [HALF-1:0] written [0:2*N-1];
    reg [1:0]      halves  [0:N-1];

    wire [1:0]      known_halves = s_first ? 2'b00 : halves[s_slot];
    wire            known_half   = s_word[0] ? known_halves[1] : known_halves[0];
    wire [HALF-1:0] known        = known_half ? written[{s_slot, s_word[0]}] : {HALF{1'b0}};
    wire [HALF-1:0] this_word    = {{(HALF - 1) {1'b0}}, 1'b1} << s_word[4:1];
    wire [HALF-1:0] was_written  = known >> s_word[4:1];

    wire [1:0]      halves_to_read = halves[read_slot];
    wire [HALF-1:0] to_read        = written[{read_slot, read_word[0]}] >> read_word[4:1];

    always @(posedge clk) begin
        if (s_valid) begin
            written[{s_slot, s_word[0]}] <= known | this_word;
            halves[s_slot]               <= known_halves | {s_word[0], !s_word[0]};
        end
    end

    // ---- events ------------------------------------------------------------------------------------------------------

    // By the clocks since s_.
    reg              valid_1, valid_2;
    reg [ADDR_W-1:0] address_1, address_2;
    reg [1:0]        pair_1, pair_2;  // byte of the word
    reg              lane_1, lane_2;  // cell of the pair
    reg              opens_1, opens_2;  // first of its word
    reg              near_1;    // the byte of the event before
    reg              second_1;  // the byte of the event before that
    reg              stored_1;  // its byte is in the memory
    reg [8:0]        byte_1;
    reg [7:0]        byte_2, byte_3;
    reg [7:0]        byte_next;

    wire [ADDR_W-1:0] address_0 = {s_slot, s_word};
    wire same_word_1 = valid_1 && address_1 == address_0;
    wire same_word_2 = valid_2 && address_2 == address_0;

    always @* begin : count
        integer k;
        k = 0;  // on every path, or it would be a latch
        byte_next = byte_2;
        for (k = 0; k < 2; k = k + 1) begin
            if (lane_2 == k[0] && byte_2[4*k +: 4] != 4'd15) byte_next[4*k +: 4] = byte_2[4*k +: 4] + 4'd1;
        end
    end

    always @(posedge clk) begin
        {valid_1, valid_2}     <= {s_valid, valid_1};
        {address_1, address_2} <= {address_0, address_1};
        {pair_1, pair_2}       <= {s_lane[2:1], pair_1};
        {lane_1, lane_2}       <= {s_lane[0], lane_1};
        {opens_1, opens_2}     <= {!was_written[0], opens_1};
        near_1   <= was_written[0] && same_word_1 && pair_1 == s_lane[2:1];
        second_1 <= was_written[0] && !(same_word_1 && opens_1) && same_word_2 && pair_2 == s_lane[2:1];
        stored_1 <= was_written[0] && !(same_word_1 && opens_1) && !(same_word_2 && opens_2);
        byte_2   <= near_1 ? byte_next : second_1 ? byte_3 : byte_1[7:0];
        if (!near_1 && !second_1 && !(stored_1 && byte_1[8])) byte_2 <= 8'd0;
        byte_3   <= byte_next;
        if (rst) {valid_1, valid_2} <= 2'b00;
    end

    // ---- the copies --------------------------------------------------------------------------------------------------

    (* no_rw_check *) reg [8:0]  counted [0:4*DEPTH-1];
    (* no_rw_check *) reg [35:0] shown   [0:DEPTH-1];
    reg [35:0] word_1, word_2;
    reg        filled_1, filled_2;

    wire [3:0] this_pair = 4'd1 << pair_2;
    wire [3:0] writes    = valid_2 ? (opens_2 ? 4'b1111 : this_pair) : 4'b0000;

    always @(posedge clk) begin
        if (writes[0]) counted[{address_2, 2'd0}] <= {this_pair[0], byte_next};
        if (writes[1]) counted[{address_2, 2'd1}] <= {this_pair[1], byte_next};
        if (writes[2]) counted[{address_2, 2'd2}] <= {this_pair[2], byte_next};
        if (writes[3]) counted[{address_2, 2'd3}] <= {this_pair[3], byte_next};
        byte_1 <= counted[{address_0, s_lane[2:1]}];
    end

    always @(posedge clk) begin
        if (writes[0]) shown[address_2][8:0]   <= {this_pair[0], byte_next};
        if (writes[1]) shown[address_2][17:9]  <= {this_pair[1], byte_next};
        if (writes[2]) shown[address_2][26:18] <= {this_pair[2], byte_next};
        if (writes[3]) shown[address_2][35:27] <= {this_pair[3], byte_next};
        word_1   <= shown[{read_slot, read_word}];
        word_2   <= word_1;
        filled_1 <= (read_word[0] ? halves_to_read[1] : halves_to_read[0]) && to_read[0];
        filled_2 <= filled_1;
    end

    assign cells  = {word_2[34:27], word_2[25:18], word_2[16:9], word_2[7:0]};
    assign filled = {word_2[35], word_2[26], word_2[17], word_2[8]} & {4{filled_2}};

    wire unused = &{1'b0, to_read[HALF-1:1], was_written[HALF-1:1]};

endmodule

`default_nettype wire
