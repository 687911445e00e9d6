// SPDX-License-Identifier: Apache-2.0
// Random traffic through async_fifo.v between two clocks with jitter: prints PASS, or what is wrong.
`timescale 1ps / 1ps
`default_nettype none

module async_fifo_tb;
    parameter DEPTH_W = 4, STAGES = 2, S_PS = 10000, M_PS = 7300, SEED = 1, WORDS = 20000, IN_OF_8 = 8, OUT_OF_8 = 8, JITTER_PS = 1000;

    integer s_seed = SEED, m_seed = SEED + 1000, errors = 0, sent = 0, received = 0, most = 0, clocks = 0;
    reg s_clk = 1'b0, m_clk = 1'b0, s_rst = 1'b1, m_rst = 1'b1, s_valid = 1'b0, m_ready = 1'b0;
    reg [31:0] s_data = 32'd0;
    wire s_ready, m_valid;
    wire [31:0] m_data;

    always #((S_PS + $dist_uniform(s_seed, -JITTER_PS, JITTER_PS)) / 2) s_clk = !s_clk;
    always #((M_PS + $dist_uniform(m_seed, -JITTER_PS, JITTER_PS)) / 2) m_clk = !m_clk;

    async_fifo #(.W(32), .DEPTH_W(DEPTH_W), .STAGES(STAGES)) dut (
        .s_clk(s_clk), .s_rst(s_rst), .s_valid(s_valid), .s_ready(s_ready), .s_data(s_data),
        .m_clk(m_clk), .m_rst(m_rst), .m_valid(m_valid), .m_ready(m_ready), .m_data(m_data)
    );

    task fail(input [8*40-1:0] what);
        begin
            if (errors == 0) $display("FAIL %0s: word %0d at %0t", what, received, $time);
            errors = errors + 1;
        end
    endtask

    // Word n is a hash of n.
    function [31:0] word(input integer n);
        word = (n * 32'd2654435761) ^ n;
    endfunction

    always @(posedge s_clk) begin
        if (s_valid && s_ready) sent = sent + 1;
        #1;
        if (!(s_valid && !s_ready && !s_rst)) begin
            s_valid = !s_rst && sent < WORDS && $dist_uniform(s_seed, 0, 7) < IN_OF_8;
            s_data  = s_valid ? word(sent) : $random;
        end
    end

    reg held = 1'b0;
    reg [31:0] held_data = 32'd0;

    always @(posedge m_clk) begin
        if (held && !(m_valid && m_data === held_data)) fail("a waiting word changed");
        if (m_valid && m_ready) begin
            if (m_data !== word(received)) fail("wrong word");
            received = received + 1;
        end
        if (sent - received > most) most = sent - received;
        if (received > sent) fail("a word too many");
        held = m_valid && !m_ready;
        held_data = m_data;
        #1 m_ready = $dist_uniform(m_seed, 0, 7) < OUT_OF_8;
    end

    // One bit of a pointer at a time.
    reg [DEPTH_W:0] change;
    reg [DEPTH_W:0] write_before = 0, read_before = 0;
    always @(dut.write_gray) begin
        change = dut.write_gray ^ write_before;
        if (!s_rst && (change & (change - 1'b1)) != 0) fail("two bits of a pointer");
        write_before = dut.write_gray;
    end
    always @(dut.read_gray) begin
        change = dut.read_gray ^ read_before;
        if (!m_rst && (change & (change - 1'b1)) != 0) fail("two bits of a pointer");
        read_before = dut.read_gray;
    end

    initial begin
        #(20 * (S_PS + M_PS));
        @(posedge s_clk) #2 s_rst = 1'b0;
        @(posedge m_clk) #2 m_rst = 1'b0;
        clocks = 0;
        while (received < WORDS && errors == 0 && clocks < 20 * WORDS) begin
            #(S_PS + M_PS);
            clocks = clocks + 1;
        end
        #(20 * (S_PS + M_PS));
        if (received != WORDS) fail("words are missing");
        if (most > (1 << DEPTH_W) + 1) fail("more words than there is room");
        if (errors == 0) $display("PASS most %0d", most);
        $finish;
    end
endmodule

`default_nettype wire
