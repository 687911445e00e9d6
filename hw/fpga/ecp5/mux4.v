// SPDX-License-Identifier: Apache-2.0
// hw/verilog/math/mux4.v in an ECP5: two look-up tables a bit, and the multiplexer of their slice.
`default_nettype none

(* keep_hierarchy *)
module mux4 #(
    parameter W = 8
) (
    input  wire [1:0]     select,
    input  wire [4*W-1:0] words,
    output wire [W-1:0]   y
);

    localparam [15:0] CHOOSE = 16'hCACA;  // C ? B : A

    genvar i;
    generate
        for (i = 0; i < W; i = i + 1) begin : g_bit
            wire low, high;

            LUT4 #(.INIT(CHOOSE)) u_low (.A(words[i]), .B(words[W+i]), .C(select[0]), .D(1'b0), .Z(low));
            LUT4 #(.INIT(CHOOSE)) u_high (.A(words[2*W+i]), .B(words[3*W+i]), .C(select[0]), .D(1'b0), .Z(high));
            PFUMX u_select (.ALUT(high), .BLUT(low), .C0(select[1]), .Z(y[i]));
        end
    endgenerate

endmodule

`default_nettype wire
