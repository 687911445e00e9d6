// SPDX-License-Identifier: Apache-2.0
// A reset that lasts 256 clocks after the device has been configured, and after a button has been released.
`default_nettype none

module power_on_reset (
    input  wire clk,
    input  wire button,  // asynchronous
    output wire rst
);

    reg [7:0] count;
    reg [1:0] pressed;

    initial begin  // FPGAs give it to registers when they are configured
        count   = 8'd0;
        pressed = 2'd0;
    end

    assign rst = count != 8'd255;

    always @(posedge clk) begin
        pressed <= {pressed[0], button};
        count   <= pressed[1] ? 8'd0 : rst ? count + 8'd1 : count;
    end

endmodule

`default_nettype wire
