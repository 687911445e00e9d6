// SPDX-License-Identifier: Apache-2.0
// The weights, and what is kept of each slot: four block RAMs of 18 bits side by side, with two ports.
//
// A row has eight weights of 8 bits and a ninth: bank b holds those of lanes 2 b and 2 b + 1 and, in its highest bits, bits 2 b
// and 2 b + 1 of the ninth. docs/recognition.md says what is in which row. One port is the host's and the events', the other the
// evaluation's.
//
// Latency:    2 clocks from a row's number to its words.
// Throughput: per port, a row read or words written per clock.
// Stall:      none.
// Reset:      none.
// RAM:        both ports write, which the block RAMs of an iCE40 cannot.
// Combinational paths: none.
`default_nettype none

module classifier_weights #(
    parameter ROW_W = 10  // bits of a row's number
) (
    input  wire             clk,

    // host and events
    input  wire [3:0]       a_write,    // by banks
    input  wire [ROW_W-1:0] a_row,
    input  wire [17:0]      a_data,
    input  wire [3:0]       a_clears,   // by banks: a clock later its words are 0
    output wire [71:0]      a_banks,

    // evaluation
    input  wire [3:0]       b_write,
    input  wire [ROW_W-1:0] b_row,
    input  wire [17:0]      b_data,
    output wire [71:0]      b_banks,
    output wire [63:0]      b_weights,  // eight lanes
    output wire [7:0]       b_ninth
);

    parameter_check #(.OK(ROW_W >= 1)) ROW_W_must_be_at_least_1 ();

    genvar b;
    generate
        for (b = 0; b < 4; b = b + 1) begin : g_bank
            (* ram_style = "block", no_rw_check *) reg [17:0] memory [0:(1<<ROW_W)-1];
            reg [17:0] a_ram, a_out, b_ram, b_out;

            always @(posedge clk) begin
                if (a_write[b]) memory[a_row] <= a_data;
                a_ram <= memory[a_row];
                a_out <= a_ram;
                if (a_clears[b]) a_out <= 18'd0;
            end

            always @(posedge clk) begin
                if (b_write[b]) memory[b_row] <= b_data;
                b_ram <= memory[b_row];
                b_out <= b_ram;
            end

            assign a_banks[18*b +: 18]   = a_out;
            assign b_banks[18*b +: 18]   = b_out;
            assign b_weights[16*b +: 16] = b_out[15:0];
            assign b_ninth[2*b +: 2]     = b_out[17:16];
        end
    endgenerate

endmodule

`default_nettype wire
