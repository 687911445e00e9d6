// SPDX-License-Identifier: Apache-2.0
// Bytes to a serial line: 8 data bits, no parity, 1 stop bit, lowest bit first.
//
// Latency:    the start bit begins 1 clock after the byte is accepted.
// Throughput: a byte per 10 bits.
// Reset:      the line is high.
// Stall:      s_ready is low while a byte is being sent.
// Combinational paths: none.
`default_nettype none

module uart_tx #(
    parameter DIVISOR = 12  // clocks per bit, 2 to 65535
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       s_valid,
    output wire       s_ready,
    input  wire [7:0] s_data,
    output wire       tx
);

    parameter_check #(.OK(DIVISOR >= 2 && DIVISOR <= 65535)) DIVISOR_must_be_2_to_65535 ();

    localparam        COUNT_W = $clog2(DIVISOR);
    localparam [31:0] LAST    = DIVISOR - 1;

    reg [9:0]         bits;   // the one on the line is the lowest; behind the stop bit come ones
    reg [3:0]         left;   // bits of the byte that are not through
    reg [COUNT_W-1:0] count;

    assign tx      = bits[0];
    assign s_ready = left == 4'd0;

    always @(posedge clk) begin
        if (left == 4'd0) begin
            count <= LAST[COUNT_W-1:0];
            if (s_valid) begin
                bits <= {1'b1, s_data, 1'b0};
                left <= 4'd10;
            end
        end else if (count == {COUNT_W{1'b0}}) begin
            bits  <= {1'b1, bits[9:1]};
            left  <= left - 4'd1;
            count <= LAST[COUNT_W-1:0];
        end else begin
            count <= count - 1'b1;
        end
        if (rst) begin
            bits <= 10'h3FF;
            left <= 4'd0;
        end
    end

endmodule

`default_nettype wire
