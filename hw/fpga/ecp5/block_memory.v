// SPDX-License-Identifier: Apache-2.0
// hw/verilog/stream/block_memory.v in block RAMs of an ECP5, 512 words of 36 bits each, read through their output registers.
//
// Below 65 words and above 512 it is the plain description.
`default_nettype none

module block_memory #(
    parameter W      = 8,
    parameter DEPTH  = 256,
    parameter ADDR_W = (DEPTH > 1) ? $clog2(DEPTH) : 1
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

    localparam RAMS = (W + 35) / 36;

    genvar i;
    generate
        if (DEPTH > 64 && DEPTH <= 512) begin : g_cells
            wire [8:0]         to   = {{(9 - ADDR_W) {1'b0}}, write_address};
            wire [8:0]         from = {{(9 - ADDR_W) {1'b0}}, read_address};
            wire [36*RAMS-1:0] in   = {{(36 * RAMS - W) {1'b0}}, write_data};
            wire [36*RAMS-1:0] out;
            assign read_data = out[W-1:0];

            for (i = 0; i < RAMS; i = i + 1) begin : g_ram
                wire [35:0] d = in[36*i+:36];
                wire [35:0] q;
                assign out[36*i+:36] = q;

                DP16KD #(
                    .DATA_WIDTH_A(36),
                    .DATA_WIDTH_B(36),
                    .REGMODE_A   ("NOREG"),
                    .REGMODE_B   ("OUTREG"),
                    .RESETMODE   ("SYNC"),
                    .ASYNC_RESET_RELEASE("SYNC"),
                    .CSDECODE_A  ("0b000"),
                    .CSDECODE_B  ("0b000"),
                    .CLKAMUX     ("CLKA"),
                    .CLKBMUX     ("CLKB"),
                    .GSR         ("AUTO")
                ) u_ram (
                    .CLKA(clk), .CEA(write), .WEA(1'b1), .OCEA(1'b0), .RSTA(1'b0), .CSA0(1'b0), .CSA1(1'b0), .CSA2(1'b0),
                    .ADA0(1'b1), .ADA1(1'b1), .ADA2(1'b1), .ADA3(1'b1), .ADA4(1'b0), .ADA5(to[0]), .ADA6(to[1]),
                    .ADA7(to[2]), .ADA8(to[3]), .ADA9(to[4]), .ADA10(to[5]), .ADA11(to[6]), .ADA12(to[7]), .ADA13(to[8]),
                    .DIA0(d[0]), .DIA1(d[1]), .DIA2(d[2]), .DIA3(d[3]), .DIA4(d[4]), .DIA5(d[5]), .DIA6(d[6]), .DIA7(d[7]),
                    .DIA8(d[8]), .DIA9(d[9]), .DIA10(d[10]), .DIA11(d[11]), .DIA12(d[12]), .DIA13(d[13]), .DIA14(d[14]),
                    .DIA15(d[15]), .DIA16(d[16]), .DIA17(d[17]), .DIB0(d[18]), .DIB1(d[19]), .DIB2(d[20]), .DIB3(d[21]),
                    .DIB4(d[22]), .DIB5(d[23]), .DIB6(d[24]), .DIB7(d[25]), .DIB8(d[26]), .DIB9(d[27]), .DIB10(d[28]),
                    .DIB11(d[29]), .DIB12(d[30]), .DIB13(d[31]), .DIB14(d[32]), .DIB15(d[33]), .DIB16(d[34]),
                    .DIB17(d[35]), .CLKB(clk), .CEB(read_enable), .WEB(1'b0), .OCEB(out_enable), .RSTB(1'b0), .CSB0(1'b0),
                    .CSB1(1'b0), .CSB2(1'b0), .ADB0(1'b0), .ADB1(1'b0), .ADB2(1'b0), .ADB3(1'b0), .ADB4(1'b0),
                    .ADB5(from[0]), .ADB6(from[1]), .ADB7(from[2]), .ADB8(from[3]), .ADB9(from[4]), .ADB10(from[5]),
                    .ADB11(from[6]), .ADB12(from[7]), .ADB13(from[8]), .DOA0(q[0]), .DOA1(q[1]), .DOA2(q[2]), .DOA3(q[3]),
                    .DOA4(q[4]), .DOA5(q[5]), .DOA6(q[6]), .DOA7(q[7]), .DOA8(q[8]), .DOA9(q[9]), .DOA10(q[10]),
                    .DOA11(q[11]), .DOA12(q[12]), .DOA13(q[13]), .DOA14(q[14]), .DOA15(q[15]), .DOA16(q[16]),
                    .DOA17(q[17]), .DOB0(q[18]), .DOB1(q[19]), .DOB2(q[20]), .DOB3(q[21]), .DOB4(q[22]), .DOB5(q[23]),
                    .DOB6(q[24]), .DOB7(q[25]), .DOB8(q[26]), .DOB9(q[27]), .DOB10(q[28]), .DOB11(q[29]), .DOB12(q[30]),
                    .DOB13(q[31]), .DOB14(q[32]), .DOB15(q[33]), .DOB16(q[34]), .DOB17(q[35])
                );
            end
        end else begin : g_plain
            (* no_rw_check *) reg [W-1:0] memory [0:DEPTH-1];
            reg [W-1:0] ram_reg, out_reg;

            assign read_data = out_reg;

            always @(posedge clk) begin
                if (write) memory[write_address] <= write_data;
                if (read_enable) ram_reg <= memory[read_address];
                if (out_enable) out_reg <= ram_reg;
            end
        end
    endgenerate

endmodule

`default_nettype wire
