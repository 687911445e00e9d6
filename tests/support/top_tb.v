// SPDX-License-Identifier: Apache-2.0
// Plays a program to evcot_top in a four-state simulator, with random stalls on every channel, and prints what comes out.
//
// A line of the program is {operation, address, data}: see four_state.py. A handshake line that is neither 0 nor 1 after the first
// reset ends the run with "X", a wait without end with "STUCK".
`timescale 1ns / 1ns

module top_tb;

    parameter SOURCES = 1;
    parameter SOURCE = 0;
    parameter TRACKER = 0;
    parameter HAS = 0;
    parameter WIDTH = 32;
    parameter HEIGHT = 24;
    parameter N = 2;
    parameter X_W = 5;
    parameter Y_W = 5;
    parameter STAMP_W = 10;
    parameter CELL_PX = 0;
    parameter SEED = 1;

    reg  [103:0] program [0:65535];
    reg  [4096:0] path;
    integer at, waited, seed, quiet;

    reg         clk = 1'b0;
    reg         rst = 1'b0;
    reg         checks = 1'b0;
    always #5 clk = !clk;

    reg         awvalid = 1'b0, wvalid = 1'b0, bready = 1'b0, arvalid = 1'b0, rready = 1'b0;
    wire        awready, wready, bvalid, arready, rvalid, irq, tready, aer_ack;
    reg  [13:0] address;
    reg  [31:0] data, got;
    wire [1:0]  bresp, rresp;
    wire [31:0] rdata;
    reg         tvalid = 1'b0;
    reg  [63:0] tdata;

    wire        records_tvalid, owned_tvalid, passed_tvalid, records_tlast, owned_tlast, passed_tlast;
    reg         records_tready = 1'b0, owned_tready = 1'b0, passed_tready = 1'b0;
    wire [63:0] records_tdata, owned_tdata, passed_tdata;
    wire [7:0]  records_tkeep, owned_tkeep, passed_tkeep;
    wire [((N > 1) ? $clog2(N) : 1)-1:0] owned_tuser;

    evcot_top #(
        .SOURCES(SOURCES), .SOURCE(SOURCE), .TRACKER(TRACKER), .HAS(HAS), .WIDTH(WIDTH), .HEIGHT(HEIGHT), .N(N), .X_W(X_W),
        .Y_W(Y_W), .STAMP_W(STAMP_W), .CELL_PX(CELL_PX), .RADIX_W(5), .NEV_W(6), .TC_W(12), .SUP_W(8), .ID_W(16),
        .SEQ_W(32), .TIME_W(32), .RECENT_DEPTH(4), .FIFO_DEPTH(8), .RECORD_DEPTH(2)
    ) dut (
        .clk(clk), .rst(rst),
        .s_axil_awvalid(awvalid), .s_axil_awready(awready), .s_axil_awaddr(address), .s_axil_awprot(3'd0),
        .s_axil_wvalid(wvalid), .s_axil_wready(wready), .s_axil_wdata(data), .s_axil_wstrb(4'hF),
        .s_axil_bvalid(bvalid), .s_axil_bready(bready), .s_axil_bresp(bresp),
        .s_axil_arvalid(arvalid), .s_axil_arready(arready), .s_axil_araddr(address), .s_axil_arprot(3'd0),
        .s_axil_rvalid(rvalid), .s_axil_rready(rready), .s_axil_rdata(rdata), .s_axil_rresp(rresp), .irq(irq),
        .s_axis_tvalid(tvalid), .s_axis_tready(tready), .s_axis_tdata(tdata), .s_axis_tkeep(8'hFF), .s_axis_tlast(1'b0),
        .aer_req(1'b1), .aer_ack(aer_ack), .aer_row(1'b0), .aer_data({(X_W+Y_W+1){1'b0}}),
        .m_axis_records_tvalid(records_tvalid), .m_axis_records_tready(records_tready), .m_axis_records_tdata(records_tdata),
        .m_axis_records_tkeep(records_tkeep), .m_axis_records_tlast(records_tlast),
        .m_axis_owned_tvalid(owned_tvalid), .m_axis_owned_tready(owned_tready), .m_axis_owned_tdata(owned_tdata),
        .m_axis_owned_tkeep(owned_tkeep), .m_axis_owned_tuser(owned_tuser), .m_axis_owned_tlast(owned_tlast),
        .m_axis_passed_tvalid(passed_tvalid), .m_axis_passed_tready(passed_tready), .m_axis_passed_tdata(passed_tdata),
        .m_axis_passed_tkeep(passed_tkeep), .m_axis_passed_tlast(passed_tlast)
    );

    always @(posedge clk) begin
        records_tready <= $random(seed) % 4 != 0;
        owned_tready   <= $random(seed) % 4 != 0;
        passed_tready  <= $random(seed) % 4 != 0;
        quiet = quiet + 1;
        if (records_tvalid && records_tready) begin $display("RECORDS %h", records_tdata); quiet = 0; end
        if (owned_tvalid && owned_tready) begin $display("OWNED %h %h", owned_tdata, owned_tuser); quiet = 0; end
        if (passed_tvalid && passed_tready) begin $display("PASSED %h", passed_tdata); quiet = 0; end
        if (tvalid && tready) quiet = 0;
        if (checks && ^{awready, wready, bvalid, arready, rvalid, irq, tready, aer_ack, records_tvalid, owned_tvalid,
                        passed_tvalid} === 1'bx) begin
            $display("X at %0d: %b", at, {awready, wready, bvalid, arready, rvalid, irq, tready, aer_ack, records_tvalid,
                                          owned_tvalid, passed_tvalid});
            $finish;
        end
    end

    task clock;
        begin
            @(posedge clk);
            waited = waited + 1;
            if (waited > 20000) begin
                $display("STUCK at %0d", at);
                $finish;
            end
        end
    endtask

    // A handshake is complete at the clock edge that sees both of its lines.
    reg done, other_done;

    task put(input [31:0] to, input [31:0] value);
        begin
            address <= to[13:0];
            data    <= value;
            awvalid <= 1'b1;
            wvalid  <= 1'b1;
            done = 1'b0;
            other_done = 1'b0;
            while (!(done && other_done)) begin
                clock;
                if (awvalid && awready) begin awvalid <= 1'b0; done = 1'b1; end
                if (wvalid && wready) begin wvalid <= 1'b0; other_done = 1'b1; end
            end
            while ($random(seed) % 4 == 0) clock;
            bready <= 1'b1;
            done = 1'b0;
            while (!done) begin
                clock;
                if (bvalid && bready) begin $display("WRITTEN %b", bresp); bready <= 1'b0; done = 1'b1; end
            end
        end
    endtask

    task get(input [31:0] from);
        begin
            address <= from[13:0];
            arvalid <= 1'b1;
            done = 1'b0;
            while (!done) begin
                clock;
                if (arvalid && arready) begin arvalid <= 1'b0; done = 1'b1; end
            end
            rready <= 1'b1;
            done = 1'b0;
            while (!done) begin
                clock;
                if (rvalid && rready) begin got = rdata; rready <= 1'b0; done = 1'b1; end
            end
        end
    endtask

    task send(input [63:0] word);
        begin
            while ($random(seed) % 4 == 0) clock;
            tdata  <= word;
            tvalid <= 1'b1;
            done = 1'b0;
            while (!done) begin
                clock;
                if (tvalid && tready) begin tvalid <= 1'b0; done = 1'b1; end
            end
        end
    endtask

    initial begin
        if (!$value$plusargs("program=%s", path)) $finish;
        $readmemh(path, program);
        seed   = SEED;
        quiet  = 0;
        at     = 0;
        while (program[at][103:96] != 8'd0) begin
            waited = 0;
            case (program[at][103:96])
                8'd1: put(program[at][95:64], program[at][31:0]);
                8'd2: begin  // until the bits in the upper half are those in the lower
                    get(program[at][95:64]);
                    while ((got & program[at][63:32]) !== program[at][31:0]) get(program[at][95:64]);
                end
                8'd3: send(program[at][63:0]);
                8'd4: begin quiet = 0; while (quiet < program[at][31:0]) clock; end
                8'd5: begin
                    rst <= 1'b1;
                    repeat (4) clock;
                    rst    <= 1'b0;
                    clock;
                    checks = 1'b1;
                end
                default: ;
            endcase
            at = at + 1;
        end
        $display("DONE");
        $finish;
    end

endmodule
