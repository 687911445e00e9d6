// SPDX-License-Identifier: Apache-2.0
// One bank of a memory of time stamps: block RAM that is read five stages before it is written (stamp_slots.v), and the
// correction of what was read by what the slots ahead write in the meantime.
//
// A slot reads in stage `read`. The slot in stage `age` writes; `meets` says for each stage whether the slot there has read, or is
// reading, the word that is written now. So `was`, in stage `then`, is what a memory without delay would have held.
// The RAM is made of parts of 2,048 words, each with a register behind its output (block_memory.v), as a RAM gives late in its
// clock: the part is selected behind the register.
//
// Latency:    4 clocks from read_row to `was`: RAM, its output, which part, correction.
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
    input  wire [4:0]        meets,        // if it writes: with the slot in `then`, `taken`, `held`, `found`, `read`, from bit 0 up

    output reg  [WORD_W-1:0] taken,        // of the slot in `taken`
    output wire [WORD_W-1:0] was           // what the slot in `then` has read
);

    localparam PART_W = 11;
    localparam PARTS  = (ROWS + (1 << PART_W) - 1) >> PART_W;

    wire [WORD_W-1:0] held;
    reg  [WORD_W-1:0] then;
    reg               passed;           // of the slot in `found`: its word was written in the clock of its read
    reg               newest, passing;  // of the slot in `held`: written in the last clock, in the one before

    always @(posedge clk)
        if (advance) begin
            passed  <= writes && meets[4];
            newest  <= writes && meets[3];
            passing <= passed;
            taken   <= writes && meets[2] ? write_word : newest ? last_word : passing ? second_word : held;
            then    <= writes && meets[1] ? write_word : taken;
        end

    assign was = writes && meets[0] ? write_word : then;

    // ---- the parts ---------------------------------------------------------------------------------------------------

    wire [PARTS*WORD_W-1:0] helds;
    wire [PARTS-1:0]        written;

    genvar p;
    generate
        if (PARTS == 1) begin : g_one
            assign written = 1'b1;
            assign held    = helds;
        end else begin : g_choice
            localparam HIGH_W = ROW_W - PART_W;
            reg [HIGH_W-1:0] found_part, held_part;

            always @(posedge clk)
                if (advance) begin
                    found_part <= read_row[ROW_W-1:PART_W];
                    held_part  <= found_part;
                end

            assign held = helds[held_part*WORD_W +: WORD_W];
            for (p = 0; p < PARTS; p = p + 1) begin : g_written
                localparam [31:0] PART = p;
                assign written[p] = write_row[ROW_W-1:PART_W] == PART[HIGH_W-1:0];
            end
        end
        for (p = 0; p < PARTS; p = p + 1) begin : g_part
            localparam WORDS = (p == PARTS - 1) ? ROWS - (p << PART_W) : 1 << PART_W;
            localparam AT_W  = (WORDS > 1) ? $clog2(WORDS) : 1;

            if (WORD_W <= 18) begin : g_register  // the RAM's own
                block_memory #(
                    .W    (WORD_W),
                    .DEPTH(WORDS)
                ) u_memory (
                    .clk          (clk),
                    .write        (advance && writes && written[p]),
                    .write_address(write_row[AT_W-1:0]),
                    .write_data   (write_word),
                    .read_enable  (advance),
                    .read_address (read_row[AT_W-1:0]),
                    .out_enable   (advance),
                    .read_data    (helds[p*WORD_W +: WORD_W])
                );
            end else begin : g_wide  // of fewer RAMs, as long as they are chosen by the tool
                (* no_rw_check *)
                reg [WORD_W-1:0] words [0:WORDS-1];
                reg [WORD_W-1:0] found, kept;

                always @(posedge clk)
                    if (advance) begin
                        if (writes && written[p]) words[write_row[AT_W-1:0]] <= write_word;
                        found <= words[read_row[AT_W-1:0]];
                        kept  <= found;
                    end

                assign helds[p*WORD_W +: WORD_W] = kept;
            end
        end
    endgenerate

endmodule

`default_nettype wire
