// SPDX-License-Identifier: Apache-2.0
// One bank of a memory of time stamps: block RAM that is read four stages before it is written (stamp_slots.v), and the
// correction of what was read by what the slots ahead write in the meantime.
//
// A slot reads in stage `read`. The slot in stage `age` writes; `meets` says for each stage whether the slot there has read, or is
// reading, the word that is written now. So `was`, in stage `then`, is what a memory without delay would have held.
//
// Latency:    3 clocks from read_row to `was`: RAM, its output, correction.
// Throughput: 1 read and 1 write per clock.
// Stall:      while advance is low everything is held.
// Reset:      none: contents and registers are what they were; the first walk writes every row.
// RAM:        ROWS * WORD_W bits, one read and one write port. A word read in the clock in which it is written is not used.
// Combinational paths: writes, meets[0], write_word -> was.
`default_nettype none

module stamp_bank #(
    parameter ROWS   = 16,  // words
    parameter ROW_W  = 4,   // bits of a word's number
    parameter WORD_W = 20   // bits of a word
) (
    input  wire              clk,
    input  wire              advance,

    input  wire [ROW_W-1:0]  read_row,     // of the slot in `read`

    input  wire              writes,       // the slot in `age`, to this bank
    input  wire [ROW_W-1:0]  write_row,
    input  wire [WORD_W-1:0] write_word,
    input  wire [WORD_W-1:0] last_word,    // write_word of the clock before
    input  wire [WORD_W-1:0] second_word,  // and of the one before that
    input  wire [3:0]        meets,        // if it writes: with the slot in `then`, `held`, `found`, `read`, from bit 0 up

    output reg  [WORD_W-1:0] held,         // of the slot in `held`: not corrected
    output wire [WORD_W-1:0] was           // what the slot in `then` has read
);

    (* ram_style = "block", no_rw_check *)
    reg [WORD_W-1:0] words [0:ROWS-1];
    reg [WORD_W-1:0] found, then;
    reg              passed;          // of the slot in `found`: its word was written in the clock of its read
    reg              newest, passing; // of the slot in `held`: written in the last clock, in the one before

    wire [3:0] hits = meets & {4{writes}};

    always @(posedge clk)
        if (advance) begin
            if (writes) words[write_row] <= write_word;
            found   <= words[read_row];
            passed  <= hits[3];

            held    <= found;  // a RAM gives late in its clock
            newest  <= hits[2];
            passing <= passed;

            then    <= hits[1] ? write_word : newest ? last_word : passing ? second_word : held;
        end

    assign was = hits[0] ? write_word : then;

endmodule

`default_nettype wire
