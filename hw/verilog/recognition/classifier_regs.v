// SPDX-License-Identifier: Apache-2.0
// The registers of the classifier, with the addresses of docs/recognition.md. Synthesised alone: with what is around it, Yosys makes
// more logic of it.
//
// Latency:    1 clock from a write to the outputs.
// Throughput: a write per clock.
// Stall:      none.
// Reset:      the defaults.
// Combinational paths: none.
`default_nettype none

(* keep_hierarchy *)
module classifier_regs (
    input  wire        clk,
    input  wire        rst,
    input  wire        write,
    input  wire [2:0]  address,
    input  wire [11:0] data,
    output reg         enable,
    output reg  [3:0]  window_log2,
    output reg  [11:0] scale_start,
    output reg  [3:0]  shift_1,
    output reg  [3:0]  shift_2,
    output reg  [3:0]  classes,
    output reg  [7:0]  margin_min
);

    always @(posedge clk) begin
        if (write) begin
            case (address)
                3'd0: enable <= data[0];
                3'd1: window_log2 <= data[3:0];
                3'd2: scale_start <= data;
                3'd3: shift_1 <= data[3:0];
                3'd4: shift_2 <= data[3:0];
                3'd5: classes <= data[3:0];
                3'd6: margin_min <= data[7:0];
                default: ;
            endcase
        end
        if (rst) begin
            enable      <= 1'b0;
            window_log2 <= 4'd10;
            scale_start <= 12'd984;
            shift_1     <= 4'd8;
            shift_2     <= 4'd8;
            classes     <= 4'd10;
            margin_min  <= 8'd0;
        end
    end

endmodule

`default_nettype wire
