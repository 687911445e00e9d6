// SPDX-License-Identifier: Apache-2.0
// The images of all slots: rules N2 and W4 of docs/recognition.md.
//
// A slot has 18 words of eight counters, and for each word a bit that says that it was written in this window: clearing an image
// takes no time. There are two copies, one read by events and one by the evaluation. An event reads its word, increments a counter,
// and writes the word; a word that an event is about to write is forwarded.
//
// Latency:    an event is in the image 4 clocks after s_; 2 clocks from read_ to cells and `filled`.
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
    output wire              filled      // low: all cells of the word are 0, whatever `cells` says
);

    parameter_check #(.OK(N >= 1)) N_must_be_at_least_1 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam WORDS  = 18;
    localparam ADDR_W = SLOT_W + 5;
    localparam DEPTH  = 1 << ADDR_W;

    // ---- words written in this window --------------------------------------------------------------------------------

    reg [WORDS-1:0] written [0:N-1];

    wire [WORDS-1:0] known       = s_first ? {WORDS{1'b0}} : written[s_slot];
    wire [WORDS-1:0] this_word   = {{(WORDS - 1) {1'b0}}, 1'b1} << s_word;
    wire [WORDS-1:0] was_written = known >> s_word;
    wire [WORDS-1:0] to_read     = written[read_slot] >> read_word;

    always @(posedge clk) begin
        if (s_valid) written[s_slot] <= known | this_word;
    end

    // ---- events ------------------------------------------------------------------------------------------------------

    reg [4:1]        valid;      // by the clocks since s_
    reg [ADDR_W-1:0] address_1, address_2, address_3, address_4;
    reg [2:0]        lane_1;
    reg [7:0]        adds_2;     // one bit per lane
    reg              keeps_1;
    reg              same_2;     // the word of the event before
    reg              stored_2;   // a word of the memory
    reg [31:0]       older_2;    // a word that one of the two events before that one has written
    reg [31:0]       word_3, word_4;
    wire [31:0]      word_read;

    wire same_as_2 = valid[2] && address_2 == address_1;
    wire same_as_3 = valid[3] && address_3 == address_1;
    wire same_as_4 = valid[4] && address_4 == address_1;

    wire [31:0] word_2 = same_2 ? word_3 : stored_2 ? word_read : older_2;
    reg  [31:0] word_next;

    always @* begin : count
        integer k;
        k = 0;  // on every path, or it would be a latch
        word_next = word_2;
        for (k = 0; k < 8; k = k + 1) begin
            if (adds_2[k] && word_2[4*k +: 4] != 4'd15) word_next[4*k +: 4] = word_2[4*k +: 4] + 4'd1;
        end
    end

    always @(posedge clk) begin
        valid     <= {valid[3:1], s_valid};
        address_1 <= {s_slot, s_word};
        address_2 <= address_1;
        address_3 <= address_2;
        address_4 <= address_3;
        lane_1    <= s_lane;
        adds_2    <= 8'd1 << lane_1;
        keeps_1   <= was_written[0];
        same_2    <= keeps_1 && same_as_2;
        stored_2  <= keeps_1 && !same_as_3 && !same_as_4;
        older_2   <= same_as_3 ? word_3 : word_4;
        if (!keeps_1) older_2 <= 32'd0;
        word_3    <= word_next;
        word_4    <= word_3;
        if (rst) valid <= 4'd0;
    end

    block_memory #(
        .W    (32),
        .DEPTH(DEPTH)
    ) u_events (
        .clk          (clk),
        .write        (valid[3]),
        .write_address(address_3),
        .write_data   (word_3),
        .read_enable  (1'b1),
        .read_address ({s_slot, s_word}),
        .out_enable   (1'b1),
        .read_data    (word_read)
    );

    // ---- evaluation --------------------------------------------------------------------------------------------------

    reg filled_1, filled_2;

    assign filled = filled_2;

    always @(posedge clk) begin
        filled_1 <= to_read[0];
        filled_2 <= filled_1;
    end

    block_memory #(
        .W    (32),
        .DEPTH(DEPTH)
    ) u_evaluation (
        .clk          (clk),
        .write        (valid[3]),
        .write_address(address_3),
        .write_data   (word_3),
        .read_enable  (1'b1),
        .read_address ({read_slot, read_word}),
        .out_enable   (1'b1),
        .read_data    (cells)
    );

    wire unused = &{1'b0, to_read[WORDS-1:1], was_written[WORDS-1:1]};

endmodule

`default_nettype wire
