// SPDX-License-Identifier: Apache-2.0
// ULX3S (ECP5, 25 MHz). LED 0: the self-test has passed; 1: it has failed; 2: records go out; 7: power. Button 0 (PWR) resets.
// Serial line: USB port US1, 1 Mbaud. Names of the line as the board has them, from the FTDI's side.
`default_nettype none

module ulx3s (
    input  wire       clk_25mhz,
    input  wire       btn_n,
    input  wire       ftdi_txd,
    output wire       ftdi_rxd,
    output wire [7:0] led,
    output wire       wifi_gpio0  // high, or the board restarts
);

    wire rst, passed, failed, alive;

    power_on_reset u_reset (
        .clk   (clk_25mhz),
        .button(!btn_n),
        .rst   (rst)
    );

    board_core #(
        .CLOCK_HZ(25000000),
        .N       (8)
    ) u_core (
        .clk   (clk_25mhz),
        .rst   (rst),
        .rx    (ftdi_txd),
        .tx    (ftdi_rxd),
        .passed(passed),
        .failed(failed),
        .alive (alive)
    );

    assign led        = {1'b1, 4'd0, alive, failed, passed};
    assign wifi_gpio0 = 1'b1;

endmodule

`default_nettype wire
