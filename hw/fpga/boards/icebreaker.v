// SPDX-License-Identifier: Apache-2.0
// iCEBreaker (iCE40 UP5K, 12 MHz, of which the tracker takes every second clock): green LED on when the self-test has passed, red
// LED on when it has failed; the user button resets. Serial line: the second port of the board's USB, 1 Mbaud.
`default_nettype none

module icebreaker (
    input  wire clk,
    input  wire btn_n,
    input  wire rx,
    output wire tx,
    output wire led_red_n,
    output wire led_green_n
);

    wire rst, passed, failed, alive;
    reg  core_clk;

    initial core_clk = 1'b0;
    always @(posedge clk) core_clk <= !core_clk;

    power_on_reset u_reset (
        .clk   (core_clk),
        .button(!btn_n),
        .rst   (rst)
    );

    board_core #(
        .CLOCK_HZ(6000000),
        .FULL    (0),
        .N       (1)
    ) u_core (
        .clk   (core_clk),
        .rst   (rst),
        .rx    (rx),
        .tx    (tx),
        .passed(passed),
        .failed(failed),
        .alive (alive)
    );

    assign led_green_n = !passed;
    assign led_red_n   = !failed;

    wire unused = &{1'b0, alive};

endmodule

`default_nettype wire
