// SPDX-License-Identifier: Apache-2.0
// Microseconds since reset, for sources that stamp their events themselves.
//
// t_us is a register; it counts up every `clocks_per_us` clocks, and stands still while that is 0. See prescaler.v.
//
// Latency:    none, t_us is the time now.
// Throughput: a microsecond per clock at most.
// Stall:      none.
// Reset:      t_us becomes 0.
// Combinational paths: none.
`default_nettype none

module clock_us #(
    parameter T_W        = 48,  // bits of the time, at least 1
    parameter PRESCALE_W = 16   // bits of clocks_per_us, at least 1
) (
    input  wire                  clk,
    input  wire                  rst,
    input  wire [PRESCALE_W-1:0] clocks_per_us,
    output reg  [T_W-1:0]        t_us
);

    parameter_check #(.OK(T_W >= 1)) T_W_must_be_at_least_1 ();

    wire pulse;

    prescaler #(
        .W(PRESCALE_W)
    ) u_prescaler (
        .clk   (clk),
        .rst   (rst),
        .period(clocks_per_us),
        .pulse (pulse)
    );

    always @(posedge clk) begin
        if (pulse) t_us <= t_us + 1'b1;
        if (rst) t_us <= {T_W{1'b0}};
    end

endmodule

`default_nettype wire
