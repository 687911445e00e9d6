// SPDX-License-Identifier: Apache-2.0
// A pulse of one clock every `period` clocks; none while period is 0.
//
// Latency:    the first pulse is in the clock `period` - 1 clocks after reset has ended.
// A new period takes effect in the next clock, counted from the last pulse: if more clocks have passed already, the pulse comes then.
// Reset:      the period starts over.
// Combinational paths: rst -> pulse.
// Throughput: a pulse per clock at most.
// Stall:      none.
`default_nettype none

module prescaler #(
    parameter W = 16  // bits of a period, at least 1
) (
    input  wire         clk,
    input  wire         rst,
    input  wire [W-1:0] period,
    output wire         pulse
);

    parameter_check #(.OK(W >= 1)) W_must_be_at_least_1 ();

    localparam [W:0] ONE = {{W{1'b0}}, 1'b1};
    localparam [W:0] TWO = ONE << 1;

    reg [W:0] passed;  // clocks since the last pulse, the next one included
    reg       due;     // they were as many as a period

    assign pulse = due && !rst;

    wire none = period == {W{1'b0}};
    wire each = {1'b0, period} == ONE;

    always @(posedge clk) begin
        passed <= (pulse || none) ? TWO : passed + 1'b1;
        due    <= pulse ? each : !none && passed >= {1'b0, period};
        if (rst) begin
            passed <= TWO;
            due    <= each;
        end
    end

endmodule

`default_nettype wire
