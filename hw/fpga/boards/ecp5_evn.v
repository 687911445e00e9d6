// SPDX-License-Identifier: Apache-2.0
// ECP5 Evaluation Board (LFE5UM5G-85F, 12 MHz). LED 0: the self-test has passed; 1: it has failed; 2: records go out; 7: power
// (all LEDs are active low). The button at P4 resets. Serial line: the second channel of the FT2232H, 1 Mbaud; on the board as
// it is sold R34 and R35 must be populated for it, R22 and R23 removed.
`default_nettype none

module ecp5_evn (
    input  wire       clk,
    input  wire       btn_n,
    input  wire       rx,
    output wire       tx,
    output wire [7:0] led_n
);

    wire rst, passed, failed, alive;

    power_on_reset u_reset (
        .clk   (clk),
        .button(!btn_n),
        .rst   (rst)
    );

    board_core #(
        .CLOCK_HZ(12000000),
        .N       (8)
    ) u_core (
        .clk   (clk),
        .rst   (rst),
        .rx    (rx),
        .tx    (tx),
        .passed(passed),
        .failed(failed),
        .alive (alive)
    );

    assign led_n = ~{1'b1, 4'd0, alive, failed, passed};

endmodule

`default_nettype wire
