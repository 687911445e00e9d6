// SPDX-License-Identifier: Apache-2.0
// The last event of every column of a sensor (or of every row): its time and its other coordinate, O(WIDTH) bits of memory
// (filter_rowcol.v). Of an event it gives those of its own column and of the two beside it, in four banks by the low bits of x.
//
// Slots and stages are those of stamp_slots.v; outputs belong to the slot in `age`. All events that reach the memory are stored.
//
// Latency:    6 clocks from stage 0 to the outputs, in stage 6.
// Throughput: 1 slot per clock.
// Stall:      while advance is low everything is held.
// Reset:      none of its own: see stamp_slots.v.
// RAM:        4 * ROWS * (STAMP_W + OTHER_W) bits.
// Combinational paths: none.
`default_nettype none

module stamp_line #(
    parameter PLACES    = 346,  // columns of the sensor
    parameter PLACE_W   = 9,    // bits of a column
    parameter OTHER_W   = 9,    // bits of the other coordinate
    parameter ROWS      = 87,   // words of a bank, at least PLACES / 4
    parameter ROW_W     = 7,    // bits of a word's number
    parameter STAMP_W   = 20,   // bits of a stamp
    parameter SEGMENT_W = 18    // log2 of the steps between two visits
) (
    input  wire                     clk,
    input  wire                     advance,

    // by stage: see stamp_slots.v
    input  wire [6:0]               access,
    input  wire [6:0]               visits,
    input  wire [7*ROW_W-1:0]       row,
    input  wire [7*STAMP_W-1:0]     now,
    input  wire [7*PLACE_W-1:0]     place,
    input  wire [7*OTHER_W-1:0]     other,
    input  wire                     clearing,

    // by bank
    output reg  [3:0]               reached, // holds the event's own column or one beside it, on the sensor
    output reg  [4*STAMP_W-1:0]     age,
    output reg  [4*(OTHER_W+1)-1:0] apart,   // other coordinate less the event's, signed
    output reg  [3:0]               own      // holds the event's own column
);

    localparam WORD_W = STAMP_W + OTHER_W;

    localparam [31:0]        END  = PLACES;
    localparam [PLACE_W:0]   ONE  = 1;
    localparam [STAMP_W-1:0] KEEP = {{(STAMP_W - SEGMENT_W - 1) {1'b1}}, {(SEGMENT_W + 1) {1'b0}}};

    // ---- which of the five slots ahead is at a column that the slot in `ask` reads -----------------------------------

    wire [PLACE_W+2:0] asked = {3'd0, place[PLACE_W-1:0]};  // room for the row of a narrow sensor
    reg  [4:0]         meeting;                             // with the slots in `read`, `found`, `held`, `taken`, `then`
    reg  [4:0]         meets_read;
    reg  [3:0]         meets_found;
    reg  [2:0]         meets_held;
    reg  [1:0]         meets_taken;
    reg                meets_then;

    always @* begin : meet
        integer s;
        reg [PLACE_W:0] difference;
        reg [PLACE_W-1:0] ahead;
        for (s = 1; s < 6; s = s + 1) begin
            ahead      = place[s*PLACE_W +: PLACE_W];
            difference = {1'b0, ahead} - {1'b0, place[PLACE_W-1:0]};
            meeting[s-1] = access[s] && (visits[0] ? row[s*ROW_W +: ROW_W] == row[ROW_W-1:0]
                                                   : difference == {(PLACE_W + 1) {1'b0}} || difference == ONE || (&difference));
        end
    end

    always @(posedge clk)
        if (advance) begin
            meets_read  <= meeting;
            meets_found <= meets_read[3:0];
            meets_held  <= meets_found[2:0];
            meets_taken <= meets_held[1:0];
            meets_then  <= meets_taken[0];
        end

    // ---- banks -------------------------------------------------------------------------------------------------------

    wire [PLACE_W-1:0] then_place = place[5*PLACE_W +: PLACE_W];
    wire [OTHER_W-1:0] then_other = other[5*OTHER_W +: OTHER_W];
    wire [STAMP_W-1:0] then_now   = now[5*STAMP_W +: STAMP_W];
    wire [31:0]        then_at    = {{(32 - PLACE_W) {1'b0}}, then_place};
    wire               then_left  = then_at != 32'd0;        // a column beside it is on the sensor
    wire               then_right = then_at + 32'd1 < END;

    wire [STAMP_W-1:0] stamp      = visits[6] ? now[6*STAMP_W +: STAMP_W] - KEEP : now[6*STAMP_W +: STAMP_W];
    wire [WORD_W-1:0]  write_word = {other[6*OTHER_W +: OTHER_W], stamp};
    reg  [WORD_W-1:0]  last_word, second_word;

    always @(posedge clk)
        if (advance) begin
            last_word   <= write_word;
            second_word <= last_word;
        end

    genvar b;
    generate
        for (b = 0; b < 4; b = b + 1) begin : g_bank
            localparam [31:0] BANK = b;
            localparam [1:0]  COL  = BANK[1:0];

            // The word that the neighbour in this bank lies in; where there is none on the sensor, any.
            wire right = !visits[0] && COL == 2'd0 && asked[1:0] == 2'd3;
            wire left  = !visits[0] && COL == 2'd3 && asked[1:0] == 2'd0;
            wire [ROW_W-1:0] aside = right ? {{(ROW_W - 1) {1'b0}}, 1'b1} : {ROW_W{left}};

            reg  [ROW_W-1:0]   read_row;
            wire [WORD_W-1:0]  was, taken;
            wire               unused  = &{1'b0, taken};
            wire               too_old = &age[b*STAMP_W + SEGMENT_W + 1 +: STAMP_W - SEGMENT_W - 1];

            stamp_bank #(
                .ROWS  (ROWS),
                .ROW_W (ROW_W),
                .WORD_W(WORD_W)
            ) u_bank (
                .clk        (clk),
                .advance    (advance),
                .read_row   (read_row),
                .writes     (visits[6] ? too_old || clearing : access[6] && own[b]),
                .write_row  (row[6*ROW_W +: ROW_W]),
                .write_word (write_word),
                .last_word  (last_word),
                .second_word(second_word),
                .meets      ({meets_read[4], meets_found[3], meets_held[2], meets_taken[1], meets_then}),
                .taken      (taken),
                .was        (was)
            );

            always @(posedge clk)
                if (advance) begin
                    read_row                           <= row[ROW_W-1:0] + aside;
                    own[b]                             <= then_at[1:0] == COL;
                    reached[b]                            <= then_at[1:0] == COL
                                                          || (then_at[1:0] == COL - 2'd1 && then_right)
                                                          || (then_at[1:0] == COL + 2'd1 && then_left);
                    age[b*STAMP_W +: STAMP_W]          <= then_now - was[STAMP_W-1:0];
                    apart[b*(OTHER_W+1) +: OTHER_W+1]  <= {1'b0, was[WORD_W-1:STAMP_W]} - {1'b0, then_other};
                end
        end
    endgenerate

    wire unused = &{1'b0, asked, access[0], visits[5:1], row, now, other, meets_found, meets_read};

endmodule

`default_nettype wire
