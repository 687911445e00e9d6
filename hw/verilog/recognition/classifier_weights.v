// SPDX-License-Identifier: Apache-2.0
// The weights, and what the evaluation keeps of each slot: four block RAMs of 18 bits side by side, read as rows.
//
// A row has eight weights of 8 bits and a ninth: bank b holds those of lanes 2 b and 2 b + 1 and, in its highest bits, bits 2 b
// and 2 b + 1 of the ninth. The evaluation writes bank 0 only. docs/recognition.md says what is in which row.
//
// Latency:    2 clocks from read_row to the outputs.
// Throughput: a row read and a word written per clock; a write of the evaluation comes first.
// Stall:      none.
// Reset:      none.
// Combinational paths: none.
`default_nettype none

module classifier_weights #(
    parameter ROW_W = 10  // bits of a row's number
) (
    input  wire             clk,

    // host
    input  wire             write,
    input  wire [ROW_W+1:0] write_address,  // row, bank
    input  wire [17:0]      write_data,

    // evaluation
    input  wire             keep,
    input  wire [ROW_W-1:0] keep_row,
    input  wire [14:0]      keep_value,

    input  wire [ROW_W-1:0] read_row,
    output wire [63:0]      weights,        // eight lanes
    output wire [7:0]       ninth,
    output wire [14:0]      kept,           // the value that the evaluation wrote in this row
    output wire [71:0]      banks
);

    parameter_check #(.OK(ROW_W >= 1)) ROW_W_must_be_at_least_1 ();

    genvar b;
    generate
        for (b = 0; b < 4; b = b + 1) begin : g_bank
            wire keeps = keep && b == 0;

            block_memory #(
                .W    (18),
                .DEPTH(1 << ROW_W)
            ) u_memory (
                .clk          (clk),
                .write        (keeps || (write && write_address[1:0] == b)),
                .write_address(keeps ? keep_row : write_address[ROW_W+1:2]),
                .write_data   (keeps ? {3'd0, keep_value} : write_data),
                .read_enable  (1'b1),
                .read_address (read_row),
                .out_enable   (1'b1),
                .read_data    (banks[18*b +: 18])
            );

            assign weights[16*b +: 16] = banks[18*b +: 16];
            assign ninth[2*b +: 2]     = banks[18*b + 16 +: 2];
        end
    endgenerate

    assign kept = banks[14:0];

endmodule

`default_nettype wire
