// SPDX-License-Identifier: Apache-2.0
// Runs the self-test with the array and with the engine; prints PASS or FAIL, and ends with an error on FAIL.
`default_nettype none
`timescale 1ns / 1ns

module evcot_selftest_tb;

    reg         clk = 1'b0;
    reg         rst = 1'b1;
    wire [1:0]  done, passed;
    wire [63:0] n_records, cm_signature, own_signature, pass_signature;

    always #5 clk = !clk;

    genvar i;
    generate
        for (i = 0; i < 2; i = i + 1) begin : g_tracker
            evcot_selftest #(
                .TRACKER(2 * i)
            ) u_selftest (
                .clk           (clk),
                .rst           (rst),
                .done          (done[i]),
                .passed        (passed[i]),
                .n_records     (n_records[32*i+:32]),
                .cm_signature  (cm_signature[32*i+:32]),
                .own_signature (own_signature[32*i+:32]),
                .pass_signature(pass_signature[32*i+:32])
            );
        end
    endgenerate

    initial begin
        repeat (4) @(posedge clk);
        rst <= 1'b0;
        repeat (5_000_000) if (!(&done)) @(posedge clk);
        $display("array:  %0d records, signatures %h %h %h", n_records[31:0], cm_signature[31:0], own_signature[31:0],
                 pass_signature[31:0]);
        $display("engine: %0d records, signatures %h %h %h", n_records[63:32], cm_signature[63:32], own_signature[63:32],
                 pass_signature[63:32]);
        if (&passed) $display("PASS");
        else $fatal(1, "FAIL: done %b, passed %b", done, passed);
        $finish;
    end

endmodule

`default_nettype wire
