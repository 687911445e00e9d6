// SPDX-License-Identifier: Apache-2.0
// A bench for evcot_top written from its header and docs/registers.md alone, without our Python: run in Icarus.
//
//     iverilog -g2005 -I... -y... -s integrator_tb -o tb integrator_tb.v && vvp tb
//
// One slot follows a cluster that is born, moves and is lost; what leaves is compared word by word, with an output that stalls for
// a while. Prints PASS, or FAIL with what differed.
`default_nettype none
`timescale 1ns / 1ns

module integrator_tb;

    localparam [13:0] ID = 14'h000, CONTROL = 14'h020, STATUS = 14'h040, SLOT_0 = 14'h2000, COMMIT = 14'h07c;
    localparam [1:0] BORN = 2'd0, MOVED = 2'd1, LOST = 2'd3;
    localparam FRAC = 4;

    reg clk = 1'b0, rst = 1'b1;
    always #5 clk = !clk;

    reg         awvalid = 1'b0, wvalid = 1'b0, bready = 1'b0, arvalid = 1'b0, rready = 1'b0;
    reg  [13:0] awaddr = 14'd0, araddr = 14'd0;
    reg  [31:0] wdata = 32'd0;
    wire        awready, wready, bvalid, arready, rvalid;
    wire [1:0]  bresp, rresp;
    wire [31:0] rdata;

    reg         event_valid = 1'b0;
    reg  [63:0] event_data = 64'd0;
    wire        event_ready;

    reg         record_ready = 1'b1;
    wire        record_valid, record_last, owned_valid, passed_valid;
    wire [63:0] record_data, owned_data, passed_data;

    /* verilator lint_off PINCONNECTEMPTY */
    evcot_top #(
        .N     (2),
        .DATA_W(64)
    ) u_evcot (
        .clk                  (clk),
        .rst                  (rst),
        .s_axil_awvalid       (awvalid),
        .s_axil_awready       (awready),
        .s_axil_awaddr        (awaddr),
        .s_axil_awprot        (3'd0),
        .s_axil_wvalid        (wvalid),
        .s_axil_wready        (wready),
        .s_axil_wdata         (wdata),
        .s_axil_wstrb         (4'hf),
        .s_axil_bvalid        (bvalid),
        .s_axil_bready        (bready),
        .s_axil_bresp         (bresp),
        .s_axil_arvalid       (arvalid),
        .s_axil_arready       (arready),
        .s_axil_araddr        (araddr),
        .s_axil_arprot        (3'd0),
        .s_axil_rvalid        (rvalid),
        .s_axil_rready        (rready),
        .s_axil_rdata         (rdata),
        .s_axil_rresp         (rresp),
        .irq                  (),
        .s_axis_tvalid        (event_valid),
        .s_axis_tready        (event_ready),
        .s_axis_tdata         (event_data),
        .s_axis_tkeep         (8'hff),
        .s_axis_tlast         (1'b0),
        .aer_req              (1'b1),
        .aer_ack              (),
        .aer_row              (1'b0),
        .aer_data             (19'd0),
        .m_axis_records_tvalid(record_valid),
        .m_axis_records_tready(record_ready),
        .m_axis_records_tdata (record_data),
        .m_axis_records_tkeep (),
        .m_axis_records_tlast (record_last),
        .m_axis_owned_tvalid  (owned_valid),
        .m_axis_owned_tready  (1'b1),
        .m_axis_owned_tdata   (owned_data),
        .m_axis_owned_tkeep   (),
        .m_axis_owned_tuser   (),
        .m_axis_owned_tlast   (),
        .m_axis_passed_tvalid (passed_valid),
        .m_axis_passed_tready (1'b1),
        .m_axis_passed_tdata  (passed_data),
        .m_axis_passed_tkeep  (),
        .m_axis_passed_tlast  ()
    );
    /* verilator lint_on PINCONNECTEMPTY */

    integer errors = 0;

    task expect_equal(input [8*16-1:0] what, input [63:0] found, input [63:0] wanted);
        if (found !== wanted) begin
            errors = errors + 1;
            $display("FAIL %0s: %0d instead of %0d", what, found, wanted);
        end
    endtask

    // ---- the bus -----------------------------------------------------------------------------------------------------

    task write(input [13:0] address, input [31:0] value);
        begin
            @(negedge clk);
            {awvalid, wvalid, awaddr, wdata} = {2'b11, address, value};
            while (awvalid || wvalid) begin
                @(posedge clk);
                #1;
                if (took_aw) awvalid = 1'b0;
                if (took_w) wvalid = 1'b0;
            end
            bready = 1'b1;
            while (!took_b) @(posedge clk) #1;
            bready = 1'b0;
            expect_equal("bresp", {62'd0, last_bresp}, 64'd0);
        end
    endtask

    reg [31:0] value;

    task read(input [13:0] address);
        begin
            @(negedge clk);
            {arvalid, araddr, rready} = {1'b1, address, 1'b1};
            while (!took_r) begin
                @(posedge clk);
                #1;
                if (took_ar) arvalid = 1'b0;
            end
            rready = 1'b0;
            value = last_rdata;
        end
    endtask

    // What a clock edge has transferred.
    reg        took_aw = 1'b0, took_w = 1'b0, took_b = 1'b0, took_ar = 1'b0, took_r = 1'b0, took_event = 1'b0;
    reg [1:0]  last_bresp = 2'd0;
    reg [31:0] last_rdata = 32'd0;
    always @(posedge clk) begin
        took_aw    <= awvalid && awready;
        took_w     <= wvalid && wready;
        took_b     <= bvalid && bready;
        took_ar    <= arvalid && arready;
        took_r     <= rvalid && rready;
        took_event <= event_valid && event_ready;
        last_bresp <= bresp;
        if (rvalid && rready) last_rdata <= rdata;
    end

    // ---- what leaves -------------------------------------------------------------------------------------------------

    reg [383:0] record;  // 48 bytes, little-endian
    reg [383:0] records [0:7];
    integer     beat = 0, n_records = 0, n_owned = 0, n_passed = 0;
    reg [63:0]  first_owned = 64'd0, first_passed = 64'd0;

    always @(posedge clk) begin
        if (record_valid && record_ready) begin
            record = (record >> 64) | ({320'd0, record_data} << 320);
            beat   = beat + 1;
            if (record_last) begin
                expect_equal("beats", beat, 64'd6);
                records[n_records] = record;
                n_records = n_records + 1;
                beat      = 0;
            end
        end
        if (owned_valid) begin
            if (n_owned == 0) first_owned = owned_data;
            n_owned = n_owned + 1;
        end
        if (passed_valid) begin
            if (n_passed == 0) first_passed = passed_data;
            n_passed = n_passed + 1;
        end
    end

    task expect_record(input integer i, input [1:0] kind, input integer seq, input integer t, input integer x, input integer y,
                       input integer support);
        begin
            record = records[i];
            expect_equal("seq", record[63:0], seq);
            expect_equal("time", record[127:64], t);
            expect_equal("track_id", {32'd0, record[159:128]}, 64'd0);
            expect_equal("cm_x", {32'd0, record[223:192]}, x << FRAC);
            expect_equal("cm_y", {32'd0, record[255:224]}, y << FRAC);
            expect_equal("support", {32'd0, record[287:256]}, support);
            expect_equal("radius", {48'd0, record[303:288]}, 64'd12);
            expect_equal("n_ev", {48'd0, record[319:304]}, 64'd4);
            expect_equal("slot", {56'd0, record[327:320]}, 64'd0);
            expect_equal("kind", {56'd0, record[335:328]}, {62'd0, kind});
        end
    endtask

    task send(input [31:0] t_us, input [14:0] x, input [14:0] y);
        begin
            @(negedge clk);
            {event_valid, event_data} = {1'b1, 1'b0, 1'b1, y, x, t_us};
            @(posedge clk) #1;
            while (!took_event) @(posedge clk) #1;
            event_valid = 1'b0;
        end
    endtask

    // ---- the test ----------------------------------------------------------------------------------------------------

    integer k;

    initial begin
        record = 384'd0;
        repeat (4) @(negedge clk);
        rst = 1'b0;
        read(ID);
        expect_equal("id", {32'd0, value}, 64'h45564354);

        // slot 0: seeded, radius 8 + 4, the average is the last event, 4 events a window
        write(SLOT_0 + 14'h0c, 32'd8);     // init_radix
        write(SLOT_0 + 14'h10, 32'd4);     // radix_th
        write(SLOT_0 + 14'h14, 32'd0);     // radix_step
        write(SLOT_0 + 14'h18, 32'd8);     // radix_min
        write(SLOT_0 + 14'h1c, 32'd8);     // radix_max
        write(SLOT_0 + 14'h20, 32'd0);     // hist_avg
        write(SLOT_0 + 14'h24, 32'd1000);  // max_ticks
        write(SLOT_0 + 14'h28, 32'd4);     // clust_nev
        write(SLOT_0 + 14'h2c, 32'd4);     // nev_min
        write(SLOT_0 + 14'h30, 32'd4);     // nev_max
        write(SLOT_0 + 14'h34, 32'd0);     // nev_th
        write(SLOT_0 + 14'h38, 32'd500);   // detect_ticks
        write(SLOT_0, 32'd2);              // mode
        write(SLOT_0 + COMMIT, 32'd1);
        value = 32'd2;
        while (value[1]) read(STATUS);     // pending
        write(CONTROL, 32'd1);             // enable

        for (k = 0; k < 4; k = k + 1) send(100 + k, 15'd100, 15'd50);
        send(104, 15'd300, 15'd200);
        repeat (200) @(negedge clk);
        expect_equal("records", n_records, 64'd1);

        record_ready = 1'b0;               // events go on while a record waits
        for (k = 0; k < 4; k = k + 1) send(110 + k, 15'd102, 15'd51);
        send(2000, 15'd300, 15'd200);
        repeat (200) @(negedge clk);
        expect_equal("records", n_records, 64'd1);
        record_ready = 1'b1;
        repeat (200) @(negedge clk);

        expect_equal("records", n_records, 64'd3);
        expect_record(0, BORN, 3, 3, 100, 50, 4);
        expect_record(1, MOVED, 8, 13, 102, 51, 8);
        expect_record(2, LOST, 9, 1013, 102, 51, 8);
        expect_equal("owned", n_owned, 64'd9);    // the last event begins a life
        expect_equal("owned.x", {50'd0, first_owned[13:0]}, 64'd12);
        expect_equal("owned.seq", {35'd0, first_owned[63:35]}, 64'd0);
        expect_equal("passed", n_passed, 64'd1);
        expect_equal("passed.x", {48'd0, first_passed[15:0]}, 64'd300);
        expect_equal("passed.seq", {35'd0, first_passed[63:35]}, 64'd4);

        if (errors == 0) $display("PASS");
        $finish;
    end

    initial begin
        #1_000_000;
        $display("FAIL: nothing more happens");
        $finish;
    end

    wire unused = &{1'b0, rresp, owned_data[62], passed_data[62]};

endmodule

`default_nettype wire
