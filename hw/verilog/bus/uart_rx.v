// SPDX-License-Identifier: Apache-2.0
// Bytes from a serial line: 8 data bits, no parity, 1 stop bit, lowest bit first.
//
// The line is synchronised, and each bit is sampled in its middle. A byte whose stop bit is low (a break, or a wrong baud rate) is
// discarded; the next one can begin once the line has been high again.
//
// Latency:    from the middle of the stop bit to m_valid, 3 clocks.
// Stall:      none: m_valid is high for one clock.
// Reset:      waits for a start bit.
// Throughput: a byte per 10 bits.
// Combinational paths: none.
`default_nettype none

module uart_rx #(
    parameter DIVISOR = 12  // clocks per bit, 4 to 65535
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       rx,
    output reg        m_valid,
    output wire [7:0] m_data
);

    parameter_check #(.OK(DIVISOR >= 4 && DIVISOR <= 65535)) DIVISOR_must_be_4_to_65535 ();

    localparam        COUNT_W = $clog2(DIVISOR);
    localparam [31:0] LAST    = DIVISOR - 1;
    localparam [31:0] MIDDLE  = DIVISOR / 2 - 1;

    wire line;
    synchronizer #(
        .STAGES(2),
        .RESET (1)
    ) u_line (
        .clk(clk),
        .rst(rst),
        .d  (rx),
        .q  (line)
    );

    reg               busy;
    reg [COUNT_W-1:0] count;  // clocks to the middle of the next bit
    reg [3:0]         left;   // bits to come, the stop bit as well; 0: a byte was none
    reg [7:0]         bits;

    assign m_data = bits;

    always @(posedge clk) begin
        m_valid <= 1'b0;
        count   <= (count == {COUNT_W{1'b0}}) ? LAST[COUNT_W-1:0] : count - 1'b1;
        if (!busy) begin
            busy  <= !line;
            left  <= 4'd10;
            count <= MIDDLE[COUNT_W-1:0];
        end else if (left == 4'd0) begin
            busy <= !line;
        end else if (count == {COUNT_W{1'b0}}) begin
            left <= left - 4'd1;
            if (left == 4'd10 && line) busy <= 1'b0;  // too short for a start bit
            if (left == 4'd1) begin
                busy    <= !line;
                m_valid <= line;
            end else if (left != 4'd10) begin
                bits <= {line, bits[7:1]};
            end
        end
        if (rst) begin
            busy    <= 1'b0;
            m_valid <= 1'b0;
        end
    end

endmodule

`default_nettype wire
