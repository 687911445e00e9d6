// SPDX-License-Identifier: Apache-2.0
// One lane of motion_engine.v, for one axis: the words of all slots in a memory, an accumulator, a flag, and a register of five bits.
//
// An instruction passes four stages: its operand is read from memory in two clocks, chosen in the third, and used in the fourth.
//
// Latency:    3 clocks from read_address to the operand, a fourth to acc and flag.
// Throughput: an instruction per clock.
// Stall:      none.
// Reset:      none, nothing is used before it was written.
// Combinational paths: predicate and acts -> now.
`default_nettype none

module motion_lane #(
    parameter W      = 48,  // bits of the accumulator and of a word
    parameter TIME_W = 48,  // bits of a time, at most W
    parameter ADDR_W = 8    // bits of a word's address
) (
    input  wire              clk,

    // first stage: a word is read; it comes out in the third, for the other lane as well
    input  wire [ADDR_W-1:0] read_address,
    output wire [W-1:0]      word,

    // third stage: the operand
    input  wire [1:0]        kind,          // 0: word, 1: of motion_events.v, 2: of motion_values.v, 3: immediate; what is not meant is 0
    input  wire              from_other,    // a word of the other lane
    input  wire [W-1:0]      other_word,
    input  wire [W-1:0]      hot,
    input  wire [W-1:0]      value,
    input  wire [7:0]        immediate,
    input  wire              inverts,       // it is subtracted

    // fourth stage: what is done with it
    input  wire              acts,          // in this lane
    input  wire [2:0]        predicate,
    input  wire              sets_acc,
    input  wire              loads,         // acc is: the operand; acc shifted; or a sum
    input  wire              shifts,
    input  wire              to_left,
    input  wire              by_four,
    input  wire              carries,
    input  wire              reverses,      // the complement of the sum
    input  wire              of_time,       // the sum is a time
    input  wire              sets_flag,
    input  wire              from_outside,  // the flag is `condition`, else the sign of the sum
    input  wire              condition,
    input  wire [1:0]        mode,          // 0: the flag becomes it, 1: and, 2: or
    input  wire              negates,
    input  wire              sets_s,
    input  wire              stores,
    input  wire [ADDR_W-1:0] write_address,

    output reg  [W-1:0]      acc,
    output reg               flag,
    output wire              now            // the predicate holds, in this lane
);

    reg  [W-1:0] operand;
    reg  [4:0]   s;
    wire [7:0]   holds = {s, !flag, flag, 1'b1};
    assign now = acts && holds[predicate];

    block_memory #(
        .W    (W),
        .DEPTH(1 << ADDR_W)
    ) u_words (
        .clk          (clk),
        .write        (stores && now),
        .write_address(write_address),
        .write_data   (acc),
        .read_enable  (1'b1),
        .read_address (read_address),
        .out_enable   (1'b1),
        .read_data    (word)
    );

    wire [W:0]   carried = {acc, 1'b1} + {operand, carries};
    wire [W-1:0] sum     = carried[W:1];
    wire         unused  = carried[0];
    wire [W-1:0] outside = ~({W{1'b1}} >> (W - TIME_W));  // the bits above a time
    wire [W-1:0] total   = (sum ^ {W{reverses}}) & ~(outside & {W{of_time}});
    wire [W-1:0] shifted = to_left ? (by_four ? {acc[W-5:0], 4'd0} : {acc[W-2:0], 1'b0})
                                   : (by_four ? {{4{acc[W-1]}}, acc[W-1:4]} : {acc[W-1], acc[W-1:1]});
    wire         sign    = of_time ? sum[TIME_W-1] : sum[W-1];
    wire         found   = (from_outside ? condition : sign) ^ negates;

    always @(posedge clk) begin
        operand <= (((from_other ? other_word : word) & {W{kind == 2'd0}}) | hot | value
                    | {{(W - 8) {1'b0}}, immediate & {8{kind == 2'd3}}}) ^ {W{inverts}};
        if (sets_acc && now) acc <= loads ? operand : shifts ? shifted : total;
        if (sets_flag && now) flag <= mode == 2'd1 ? flag && found : mode == 2'd2 ? flag || found : found;
        if (sets_s && now) s <= acc[4:0];
    end

endmodule

`default_nettype wire
