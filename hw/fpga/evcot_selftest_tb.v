// SPDX-License-Identifier: Apache-2.0
// Runs the self-test; prints PASS or FAIL, and ends with an error on FAIL.
`default_nettype none
`timescale 1ns / 1ns

module evcot_selftest_tb;

    reg         clk = 1'b0;
    reg         rst = 1'b1;
    wire        done, passed;
    wire [31:0] n_records, cm_signature, own_signature, pass_signature;

    always #5 clk = !clk;

    evcot_selftest u_selftest (
        .clk           (clk),
        .rst           (rst),
        .done          (done),
        .passed        (passed),
        .n_records     (n_records),
        .cm_signature  (cm_signature),
        .own_signature (own_signature),
        .pass_signature(pass_signature)
    );

    initial begin
        repeat (4) @(posedge clk);
        rst <= 1'b0;
        repeat (5_000_000) if (!done) @(posedge clk);
        $display("%0d records, signatures %h %h %h", n_records, cm_signature, own_signature, pass_signature);
        if (passed) $display("PASS");
        else $fatal(1, "FAIL: done %b, passed %b", done, passed);
        $finish;
    end

endmodule

`default_nettype wire
