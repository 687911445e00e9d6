// SPDX-License-Identifier: Apache-2.0
// A memory for block RAM: one port writes, one reads through two registers, of which the second is the RAM's own output register
// where it has one.
//
// Latency:    2 clocks from read_address to read_data: into the RAM while read_enable is high, out of it while out_enable is.
// Throughput: a write and a read per clock. A word must not be read in the clock in which it is written.
// Stall:      none of its own; each enable that is low holds its register.
// Reset:      none. Words that were never written are not defined.
// Combinational paths: none.
//
// Vivado, Quartus and Radiant find the output register in this description. Yosys does not: on an ECP5 read
// hw/fpga/ecp5/block_memory.v after this file, and 5.8 ns to the output become 1.
`default_nettype none

module block_memory #(
    parameter W      = 8,    // bits of a word, at least 1
    parameter DEPTH  = 256,  // words, at least 1
    parameter ADDR_W = (DEPTH > 1) ? $clog2(DEPTH) : 1  // derived: leave it alone
) (
    input  wire              clk,

    input  wire              write,
    input  wire [ADDR_W-1:0] write_address,
    input  wire [W-1:0]      write_data,

    input  wire              read_enable,
    input  wire [ADDR_W-1:0] read_address,
    input  wire              out_enable,
    output wire [W-1:0]      read_data
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();
    parameter_check #(.OK(DEPTH >= 1)) DEPTH_must_be_at_least_1 ();
    parameter_check #(.OK(ADDR_W == ((DEPTH > 1) ? $clog2(DEPTH) : 1))) ADDR_W_must_be_left_at_its_default ();

    (* no_rw_check *) reg [W-1:0] memory [0:DEPTH-1];
    reg [W-1:0] ram_reg, out_reg;

    assign read_data = out_reg;

    always @(posedge clk) begin
        if (write) memory[write_address] <= write_data;
        if (read_enable) ram_reg <= memory[read_address];
        if (out_enable) out_reg <= ram_reg;
    end

endmodule

`default_nettype wire
