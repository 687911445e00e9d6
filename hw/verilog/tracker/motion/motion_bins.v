// SPDX-License-Identifier: Apache-2.0
// Counters in a memory, one of which an event makes one more.
//
// What is being written is forwarded to events of the same place behind it. A place is not looked at in the clock in which it is
// written: the fourth from its event on, that one included.
//
// Latency:    4 clocks from count to the memory; 2 clocks from look to looked.
// Throughput: an event per clock, and a look beside it. A counter wraps.
// Stall:      none.
// Reset:      what is under way is dropped. Counters are not reset.
// Combinational paths: none.
`default_nettype none

module motion_bins #(
    parameter BIN_W   = 18,  // bits of a counter
    parameter PLACE_W = 7    // bits of its place
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               count,   // one more
    input  wire               clear,   // or 0
    input  wire [PLACE_W-1:0] place,

    input  wire [PLACE_W-1:0] look,
    output wire [BIN_W-1:0]   looked
);

    reg               writes_1, writes_2, writes_3, clear_1, clear_2;
    reg [PLACE_W-1:0] place_1, place_2, place_3;
    wire [BIN_W-1:0]  read_2;
    reg [BIN_W-1:0]   more_3, more_4, more_5;
    reg [2:0]         is_1, is_2;  // the place is that of the event 1, 2 or 3 before

    wire [BIN_W-1:0] next_more;

    // One more than what is known of the place.
    array_sum #(
        .W    (BIN_W),
        .ROUND(0)
    ) u_more (
        .a     ({{(BIN_W - 1) {1'b0}}, 1'b1}),
        .choice(is_2[0]),
        .one   ({more_3, 1'b0}),
        .other ({is_2[1] ? more_4 : is_2[2] ? more_5 : read_2, 1'b0}),
        .y     (next_more)
    );

    // One to count in, one to look at.
    block_memory #(
        .W    (BIN_W),
        .DEPTH(1 << PLACE_W)
    ) u_counted (
        .clk          (clk),
        .write        (writes_3),
        .write_address(place_3),
        .write_data   (more_3),
        .read_enable  (1'b1),
        .read_address (place),
        .out_enable   (1'b1),
        .read_data    (read_2)
    );

    block_memory #(
        .W    (BIN_W),
        .DEPTH(1 << PLACE_W)
    ) u_looked (
        .clk          (clk),
        .write        (writes_3),
        .write_address(place_3),
        .write_data   (more_3),
        .read_enable  (1'b1),
        .read_address (look),
        .out_enable   (1'b1),
        .read_data    (looked)
    );

    always @(posedge clk) begin
        writes_1 <= count || clear;
        clear_1  <= clear;
        place_1  <= place;
        is_1     <= {writes_3 && place_3 == place, writes_2 && place_2 == place, writes_1 && place_1 == place};

        writes_2 <= writes_1;
        clear_2  <= clear_1;
        place_2  <= place_1;
        is_2     <= is_1;

        more_3   <= clear_2 ? {BIN_W{1'b0}} : next_more;
        writes_3 <= writes_2;
        place_3  <= place_2;
        more_4   <= more_3;
        more_5   <= more_4;

        if (rst) begin
            writes_1 <= 1'b0;
            writes_2 <= 1'b0;
            writes_3 <= 1'b0;
        end
    end

endmodule

`default_nettype wire
