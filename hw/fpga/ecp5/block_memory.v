// SPDX-License-Identifier: Apache-2.0
// hw/verilog/stream/block_memory.v in block RAMs of an ECP5, read through their output registers: 512 words of 36 bits each, 1,024 of
// 18, 2,048 of 9 or 16,384 of 1. More words of 9 bits or fewer are parts.
//
// As Yosys instantiates them but for the register; words of 36 bits leave through both ports. Below 65 words, and where no such RAM is
// deep enough, it is the plain description.
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

    localparam RAMS = (W + 17) / 18;
    localparam WIDE = (W + 35) / 36;

    genvar i;
    generate
        if (DEPTH > 64 && DEPTH <= 512 && W > 18) begin : g_wide
            wire [8:0]         to   = {{(9 - ADDR_W) {1'b0}}, write_address};
            wire [8:0]         from = {{(9 - ADDR_W) {1'b0}}, read_address};
            wire [36*WIDE-1:0] in   = {{(36 * WIDE - W) {1'b0}}, write_data};
            wire [36*WIDE-1:0] out;
            assign read_data = out[W-1:0];

            for (i = 0; i < WIDE; i = i + 1) begin : g_ram
                wire [35:0] d = in[36*i+:36];
                wire [35:0] q;
                assign out[36*i+:36] = q;

                DP16KD #(
                    .DATA_WIDTH_A(36),
                    .DATA_WIDTH_B(36),
                    .REGMODE_A   ("OUTREG"),
                    .REGMODE_B   ("OUTREG"),
                    .RESETMODE   ("ASYNC"),
                    .ASYNC_RESET_RELEASE("ASYNC"),
                    .CSDECODE_A  ("0b000"),
                    .CSDECODE_B  ("0b000"),
                    .CLKAMUX     ("CLKA"),
                    .CLKBMUX     ("CLKB"),
                    .GSR         ("AUTO")
                ) u_wide (
                    .CLKA(clk), .CEA(1'b1), .WEA(1'b1), .OCEA(out_enable), .RSTA(1'b0), .CSA0(1'b0), .CSA1(1'b0),
                    .CSA2(1'b0), .ADA0(write), .ADA1(write), .ADA2(write), .ADA3(write), .ADA4(1'b0), .ADA5(to[0]),
                    .ADA6(to[1]), .ADA7(to[2]), .ADA8(to[3]), .ADA9(to[4]), .ADA10(to[5]), .ADA11(to[6]), .ADA12(to[7]),
                    .ADA13(to[8]), .DIA0(d[0]), .DIA1(d[1]), .DIA2(d[2]), .DIA3(d[3]), .DIA4(d[4]), .DIA5(d[5]),
                    .DIA6(d[6]), .DIA7(d[7]), .DIA8(d[8]), .DIA9(d[9]), .DIA10(d[10]), .DIA11(d[11]), .DIA12(d[12]),
                    .DIA13(d[13]), .DIA14(d[14]), .DIA15(d[15]), .DIA16(d[16]), .DIA17(d[17]), .DIB0(d[18]), .DIB1(d[19]),
                    .DIB2(d[20]), .DIB3(d[21]), .DIB4(d[22]), .DIB5(d[23]), .DIB6(d[24]), .DIB7(d[25]), .DIB8(d[26]),
                    .DIB9(d[27]), .DIB10(d[28]), .DIB11(d[29]), .DIB12(d[30]), .DIB13(d[31]), .DIB14(d[32]), .DIB15(d[33]),
                    .DIB16(d[34]), .DIB17(d[35]), .CLKB(clk), .CEB(read_enable), .WEB(1'b0), .OCEB(out_enable), .RSTB(1'b0),
                    .CSB0(1'b0), .CSB1(1'b0), .CSB2(1'b0), .ADB0(1'b0), .ADB1(1'b0), .ADB2(1'b0), .ADB3(1'b0), .ADB4(1'b0),
                    .ADB5(from[0]), .ADB6(from[1]), .ADB7(from[2]), .ADB8(from[3]), .ADB9(from[4]), .ADB10(from[5]),
                    .ADB11(from[6]), .ADB12(from[7]), .ADB13(from[8]), .DOA0(q[0]), .DOA1(q[1]), .DOA2(q[2]), .DOA3(q[3]),
                    .DOA4(q[4]), .DOA5(q[5]), .DOA6(q[6]), .DOA7(q[7]), .DOA8(q[8]), .DOA9(q[9]), .DOA10(q[10]),
                    .DOA11(q[11]), .DOA12(q[12]), .DOA13(q[13]), .DOA14(q[14]), .DOA15(q[15]), .DOA16(q[16]), .DOA17(q[17]),
                    .DOB0(q[18]), .DOB1(q[19]), .DOB2(q[20]), .DOB3(q[21]), .DOB4(q[22]), .DOB5(q[23]), .DOB6(q[24]),
                    .DOB7(q[25]), .DOB8(q[26]), .DOB9(q[27]), .DOB10(q[28]), .DOB11(q[29]), .DOB12(q[30]), .DOB13(q[31]),
                    .DOB14(q[32]), .DOB15(q[33]), .DOB16(q[34]), .DOB17(q[35])
                );
            end
        end else if (DEPTH > 64 && DEPTH <= 1024) begin : g_cells
            wire [9:0]         to   = {{(10 - ADDR_W) {1'b0}}, write_address};
            wire [9:0]         from = {{(10 - ADDR_W) {1'b0}}, read_address};
            wire [18*RAMS-1:0] in   = {{(18 * RAMS - W) {1'b0}}, write_data};
            wire [18*RAMS-1:0] out;
            assign read_data = out[W-1:0];

            for (i = 0; i < RAMS; i = i + 1) begin : g_ram
                wire [17:0] d = in[18*i+:18];
                wire [17:0] q;
                assign out[18*i+:18] = q;

                DP16KD #(
                    .DATA_WIDTH_A(18),
                    .DATA_WIDTH_B(18),
                    .REGMODE_A   ("NOREG"),
                    .REGMODE_B   ("OUTREG"),
                    .RESETMODE   ("ASYNC"),
                    .ASYNC_RESET_RELEASE("ASYNC"),
                    .CSDECODE_A  ("0b000"),
                    .CSDECODE_B  ("0b000"),
                    .WRITEMODE_A ("READBEFOREWRITE"),
                    .WRITEMODE_B ("READBEFOREWRITE"),
                    .CLKAMUX     ("CLKA"),
                    .CLKBMUX     ("CLKB"),
                    .GSR         ("AUTO")
                ) u_ram (
                    .CLKA(clk), .CEA(1'b1), .WEA(write), .OCEA(1'b1), .RSTA(1'b0), .CSA0(1'b0), .CSA1(1'b0),
                    .CSA2(1'b0), .ADA0(1'b1), .ADA1(1'b1), .ADA2(1'b0), .ADA3(1'b0), .ADA4(to[0]), .ADA5(to[1]),
                    .ADA6(to[2]), .ADA7(to[3]), .ADA8(to[4]), .ADA9(to[5]), .ADA10(to[6]), .ADA11(to[7]),
                    .ADA12(to[8]), .ADA13(to[9]), .DIA0(d[0]), .DIA1(d[1]), .DIA2(d[2]), .DIA3(d[3]), .DIA4(d[4]),
                    .DIA5(d[5]), .DIA6(d[6]), .DIA7(d[7]), .DIA8(d[8]), .DIA9(d[9]), .DIA10(d[10]), .DIA11(d[11]),
                    .DIA12(d[12]), .DIA13(d[13]), .DIA14(d[14]), .DIA15(d[15]), .DIA16(d[16]), .DIA17(d[17]),
                    .CLKB(clk), .CEB(read_enable), .WEB(1'b0), .OCEB(out_enable), .RSTB(1'b0), .CSB0(1'b0),
                    .CSB1(1'b0), .CSB2(1'b0), .ADB0(1'b0), .ADB1(1'b0), .ADB2(1'b0), .ADB3(1'b0), .ADB4(from[0]),
                    .ADB5(from[1]), .ADB6(from[2]), .ADB7(from[3]), .ADB8(from[4]), .ADB9(from[5]), .ADB10(from[6]),
                    .ADB11(from[7]), .ADB12(from[8]), .ADB13(from[9]), .DIB0(1'b0), .DIB1(1'b0), .DIB2(1'b0),
                    .DIB3(1'b0), .DIB4(1'b0), .DIB5(1'b0), .DIB6(1'b0), .DIB7(1'b0), .DIB8(1'b0), .DIB9(1'b0),
                    .DIB10(1'b0), .DIB11(1'b0), .DIB12(1'b0), .DIB13(1'b0), .DIB14(1'b0), .DIB15(1'b0), .DIB16(1'b0),
                    .DIB17(1'b0), .DOB0(q[0]), .DOB1(q[1]), .DOB2(q[2]), .DOB3(q[3]), .DOB4(q[4]), .DOB5(q[5]),
                    .DOB6(q[6]), .DOB7(q[7]), .DOB8(q[8]), .DOB9(q[9]), .DOB10(q[10]), .DOB11(q[11]), .DOB12(q[12]),
                    .DOB13(q[13]), .DOB14(q[14]), .DOB15(q[15]), .DOB16(q[16]), .DOB17(q[17])
                );
            end
        end else if (W <= 9 && DEPTH > 1024 && DEPTH <= 2048) begin : g_narrow
            wire [8:0] q;
            assign read_data = q[W-1:0];

            narrow_memory u_narrow (
                .clk          (clk),
                .write        (write),
                .write_address(write_address),
                .write_data   ({{(9 - W) {1'b0}}, write_data}),
                .read_enable  (read_enable),
                .read_address (read_address),
                .out_enable   (out_enable),
                .clear        (1'b0),
                .read_data    (q)
            );
        end else if (W == 1 && DEPTH > 2048 && DEPTH <= 16384) begin : g_bit
            wire [13:0] to   = {{(14 - ADDR_W) {1'b0}}, write_address};
            wire [13:0] from = {{(14 - ADDR_W) {1'b0}}, read_address};

            DP16KD #(
                .DATA_WIDTH_A(1),
                .DATA_WIDTH_B(1),
                .REGMODE_A   ("NOREG"),
                .REGMODE_B   ("OUTREG"),
                .RESETMODE   ("ASYNC"),
                .ASYNC_RESET_RELEASE("ASYNC"),
                .CSDECODE_A  ("0b000"),
                .CSDECODE_B  ("0b000"),
                .WRITEMODE_A ("READBEFOREWRITE"),
                .WRITEMODE_B ("READBEFOREWRITE"),
                .CLKAMUX     ("CLKA"),
                .CLKBMUX     ("CLKB"),
                .GSR         ("AUTO")
            ) u_bit (
                .CLKA(clk), .CEA(1'b1), .WEA(write), .OCEA(1'b1), .RSTA(1'b0), .CSA0(1'b0), .CSA1(1'b0), .CSA2(1'b0),
                .ADA0(to[0]), .ADA1(to[1]), .ADA2(to[2]), .ADA3(to[3]), .ADA4(to[4]), .ADA5(to[5]), .ADA6(to[6]),
                .ADA7(to[7]), .ADA8(to[8]), .ADA9(to[9]), .ADA10(to[10]), .ADA11(to[11]), .ADA12(to[12]), .ADA13(to[13]),
                .DIA0(write_data[0]), .DIA1(1'b0), .DIA2(1'b0), .DIA3(1'b0), .DIA4(1'b0), .DIA5(1'b0), .DIA6(1'b0),
                .DIA7(1'b0), .DIA8(1'b0), .DIA9(1'b0), .DIA10(1'b0), .DIA11(1'b0), .DIA12(1'b0), .DIA13(1'b0), .DIA14(1'b0),
                .DIA15(1'b0), .DIA16(1'b0), .DIA17(1'b0), .CLKB(clk), .CEB(read_enable), .WEB(1'b0), .OCEB(out_enable),
                .RSTB(1'b0), .CSB0(1'b0), .CSB1(1'b0), .CSB2(1'b0), .ADB0(from[0]), .ADB1(from[1]), .ADB2(from[2]),
                .ADB3(from[3]), .ADB4(from[4]), .ADB5(from[5]), .ADB6(from[6]), .ADB7(from[7]), .ADB8(from[8]),
                .ADB9(from[9]), .ADB10(from[10]), .ADB11(from[11]), .ADB12(from[12]), .ADB13(from[13]), .DIB0(1'b0),
                .DIB1(1'b0), .DIB2(1'b0), .DIB3(1'b0), .DIB4(1'b0), .DIB5(1'b0), .DIB6(1'b0), .DIB7(1'b0), .DIB8(1'b0),
                .DIB9(1'b0), .DIB10(1'b0), .DIB11(1'b0), .DIB12(1'b0), .DIB13(1'b0), .DIB14(1'b0), .DIB15(1'b0),
                .DIB16(1'b0), .DIB17(1'b0), .DOB0(read_data[0])
            );
        end else if (W > 1 && W <= 9 && DEPTH > 2048) begin : g_parts  // of 2,048 words: the output registers of all but one are 0
            localparam PARTS  = (DEPTH + 2047) / 2048;
            localparam PART_W = ADDR_W - 11;

            wire [PARTS*9-1:0] outs;
            reg  [PART_W-1:0]  ram_part;
            reg  [8:0]         any;
            integer            k;

            always @(posedge clk) if (read_enable) ram_part <= read_address[ADDR_W-1:11];

            always @* begin
                any = 9'd0;
                for (k = 0; k < PARTS; k = k + 1) any = any | outs[9*k+:9];
            end

            assign read_data = any[W-1:0];

            for (i = 0; i < PARTS; i = i + 1) begin : g_part
                narrow_memory u_part (
                    .clk          (clk),
                    .write        (write && write_address[ADDR_W-1:11] == i),
                    .write_address(write_address[10:0]),
                    .write_data   ({{(9 - W) {1'b0}}, write_data}),
                    .read_enable  (read_enable),
                    .read_address (read_address[10:0]),
                    .out_enable   (out_enable),
                    .clear        (out_enable && ram_part != i),
                    .read_data    (outs[9*i+:9])
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

// 2,048 words of 9 bits in one block RAM. `clear`, only with out_enable, makes its output register 0.
module narrow_memory (
    input  wire        clk,

    input  wire        write,
    input  wire [10:0] write_address,
    input  wire [8:0]  write_data,

    input  wire        read_enable,
    input  wire [10:0] read_address,
    input  wire        out_enable,
    input  wire        clear,
    output wire [8:0]  read_data
);

    wire [10:0] to   = write_address;
    wire [10:0] from = read_address;
    wire [8:0]  d    = write_data;
    wire [8:0]  q;
    assign read_data = q;

    DP16KD #(
        .DATA_WIDTH_A(9),
        .DATA_WIDTH_B(9),
        .REGMODE_A   ("NOREG"),
        .REGMODE_B   ("OUTREG"),
        .RESETMODE   ("SYNC"),
        .ASYNC_RESET_RELEASE("ASYNC"),
        .CSDECODE_A  ("0b000"),
        .CSDECODE_B  ("0b000"),
        .WRITEMODE_A ("READBEFOREWRITE"),
        .WRITEMODE_B ("READBEFOREWRITE"),
        .CLKAMUX     ("CLKA"),
        .CLKBMUX     ("CLKB"),
        .GSR         ("AUTO")
    ) u_narrow (
        .CLKA(clk), .CEA(1'b1), .WEA(write), .OCEA(1'b1), .RSTA(1'b0), .CSA0(1'b0), .CSA1(1'b0), .CSA2(1'b0),
        .ADA0(1'b0), .ADA1(1'b0), .ADA2(1'b0), .ADA3(to[0]), .ADA4(to[1]), .ADA5(to[2]), .ADA6(to[3]),
        .ADA7(to[4]), .ADA8(to[5]), .ADA9(to[6]), .ADA10(to[7]), .ADA11(to[8]), .ADA12(to[9]), .ADA13(to[10]),
        .DIA0(d[0]), .DIA1(d[1]), .DIA2(d[2]), .DIA3(d[3]), .DIA4(d[4]), .DIA5(d[5]), .DIA6(d[6]), .DIA7(d[7]),
        .DIA8(d[8]), .DIA9(1'b0), .DIA10(1'b0), .DIA11(1'b0), .DIA12(1'b0), .DIA13(1'b0), .DIA14(1'b0),
        .DIA15(1'b0), .DIA16(1'b0), .DIA17(1'b0), .CLKB(clk), .CEB(read_enable), .WEB(1'b0), .OCEB(out_enable),
        .RSTB(clear), .CSB0(1'b0), .CSB1(1'b0), .CSB2(1'b0), .ADB0(1'b0), .ADB1(1'b0), .ADB2(1'b0),
        .ADB3(from[0]), .ADB4(from[1]), .ADB5(from[2]), .ADB6(from[3]), .ADB7(from[4]), .ADB8(from[5]),
        .ADB9(from[6]), .ADB10(from[7]), .ADB11(from[8]), .ADB12(from[9]), .ADB13(from[10]), .DIB0(1'b0),
        .DIB1(1'b0), .DIB2(1'b0), .DIB3(1'b0), .DIB4(1'b0), .DIB5(1'b0), .DIB6(1'b0), .DIB7(1'b0), .DIB8(1'b0),
        .DIB9(1'b0), .DIB10(1'b0), .DIB11(1'b0), .DIB12(1'b0), .DIB13(1'b0), .DIB14(1'b0), .DIB15(1'b0),
        .DIB16(1'b0), .DIB17(1'b0), .DOB0(q[0]), .DOB1(q[1]), .DOB2(q[2]), .DOB3(q[3]), .DOB4(q[4]),
        .DOB5(q[5]), .DOB6(q[6]), .DOB7(q[7]), .DOB8(q[8])
    );

endmodule

`default_nettype wire
