// SPDX-License-Identifier: Apache-2.0
// Checks evcot_top against the vectors that `evcot vectors` writes, in any simulator of Verilog-2005. Run it in their folder:
//
//     $ iverilog -g2005 -f rtl.f -s vectors_tb -o tb && vvp tb
//     $ verilator --binary --timing -Wno-fatal -f rtl.f --top-module vectors_tb && obj_dir/Vvectors_tb
//
// +stalls=SEED lets every stream wait at random; without it nothing waits. Prints PASS, or FAIL after the beats that differ.
// Files and the order of what happens: docs/vectors.md.
`default_nettype none
`timescale 1ns / 1ns

module vectors_tb;

    `include "vectors.vh"

    localparam SLOT_W  = (N > 1) ? $clog2(N) : 1;
    localparam BEATS   = N_RECORDS * RECORD_BEATS;
    localparam SHOWN   = 10;         // differences that are printed
    localparam PATIENCE = 2000000;   // clocks without an event, a beat or an access before the bench gives up

    reg clk = 1'b0, rst = 1'b1;
    always #5 clk = !clk;

    // ---- the files ---------------------------------------------------------------------------------------------------

    reg [115:0] accesses [0:N_ACCESSES];  // {after, poll, address, mask, data}
    reg [63:0]  events   [0:N_EVENTS];
    reg [63:0]  owned    [0:N_OWNED];
    reg [63:0]  passed   [0:N_PASSED];
    reg [63:0]  records  [0:BEATS];

    integer seed;
    reg     stalls;

    initial begin
        $readmemh("accesses.hex", accesses, 0, N_ACCESSES - 1);
        $readmemh("events.hex", events, 0, N_EVENTS - 1);
        if (N_OWNED > 0) $readmemh("owned.hex", owned, 0, N_OWNED - 1);
        if (N_PASSED > 0) $readmemh("passed.hex", passed, 0, N_PASSED - 1);
        if (BEATS > 0) $readmemh("records.hex", records, 0, BEATS - 1);
        seed   = 1;
        stalls = $value$plusargs("stalls=%d", seed);
        repeat (4) @(negedge clk);
        rst = 1'b0;
    end

    // ---- the hardware ------------------------------------------------------------------------------------------------

    reg         awvalid = 1'b0, wvalid = 1'b0, bready = 1'b0, arvalid = 1'b0, rready = 1'b0;
    wire        awready, wready, bvalid, arready, rvalid;
    wire [1:0]  bresp, rresp;
    wire [31:0] rdata;

    reg         event_valid = 1'b0;
    wire        event_ready;

    reg         owned_ready = 1'b0, passed_ready = 1'b0, record_ready = 1'b0;
    wire        owned_valid, passed_valid, record_valid, owned_last, passed_last, record_last;
    wire [63:0] owned_data, passed_data, record_data;
    wire [7:0]  owned_keep, passed_keep, record_keep;
    wire [SLOT_W-1:0] owned_user;

    integer at = 0, event_no = 0, owned_no = 0, passed_no = 0, beat_no = 0;  // what comes next

    wire [115:0] access = accesses[at];
    wire [13:0]  address = access[77:64];

    /* verilator lint_off PINCONNECTEMPTY */
    evcot_top #(
        .TRACKER     (TRACKER),
        .HAS         (HAS),
        .WIDTH       (WIDTH),
        .HEIGHT      (HEIGHT),
        .STAMP_W     (STAMP_W),
        .RECENT_DEPTH(RECENT_DEPTH),
        .CELL_PX     (CELL_PX),
        .DATA_W      (DATA_W),
        .N           (N),
        .X_W         (X_W),
        .Y_W         (Y_W),
        .FRAC        (FRAC),
        .TICK_W      (TICK_W),
        .RADIX_W     (RADIX_W),
        .NEV_W       (NEV_W),
        .TC_W        (TC_W),
        .SUP_W       (SUP_W),
        .ID_W        (ID_W),
        .SEQ_W       (SEQ_W),
        .TIME_W      (TIME_W)
    ) u_evcot (
        .clk                  (clk),
        .rst                  (rst),
        .s_axil_awvalid       (awvalid),
        .s_axil_awready       (awready),
        .s_axil_awaddr        (address),
        .s_axil_awprot        (3'd0),
        .s_axil_wvalid        (wvalid),
        .s_axil_wready        (wready),
        .s_axil_wdata         (access[31:0]),
        .s_axil_wstrb         (4'hf),
        .s_axil_bvalid        (bvalid),
        .s_axil_bready        (bready),
        .s_axil_bresp         (bresp),
        .s_axil_arvalid       (arvalid),
        .s_axil_arready       (arready),
        .s_axil_araddr        (address),
        .s_axil_arprot        (3'd0),
        .s_axil_rvalid        (rvalid),
        .s_axil_rready        (rready),
        .s_axil_rdata         (rdata),
        .s_axil_rresp         (rresp),
        .irq                  (),
        .s_axis_tvalid        (event_valid),
        .s_axis_tready        (event_ready),
        .s_axis_tdata         (events[event_no]),
        .s_axis_tkeep         (8'hff),
        .s_axis_tlast         (1'b0),
        .aer_req              (1'b1),
        .aer_ack              (),
        .aer_row              (1'b0),
        .aer_data             ({(X_W + Y_W + 1) {1'b0}}),
        .m_axis_records_tvalid(record_valid),
        .m_axis_records_tready(record_ready),
        .m_axis_records_tdata (record_data),
        .m_axis_records_tkeep (record_keep),
        .m_axis_records_tlast (record_last),
        .m_axis_owned_tvalid  (owned_valid),
        .m_axis_owned_tready  (owned_ready),
        .m_axis_owned_tdata   (owned_data),
        .m_axis_owned_tkeep   (owned_keep),
        .m_axis_owned_tuser   (owned_user),
        .m_axis_owned_tlast   (owned_last),
        .m_axis_passed_tvalid (passed_valid),
        .m_axis_passed_tready (passed_ready),
        .m_axis_passed_tdata  (passed_data),
        .m_axis_passed_tkeep  (passed_keep),
        .m_axis_passed_tlast  (passed_last)
    );
    /* verilator lint_on PINCONNECTEMPTY */

    // ---- what is wrong -----------------------------------------------------------------------------------------------

    integer errors = 0, silent = 0;

    task differs(input [8*8-1:0] stream, input integer index, input [63:0] found, input [63:0] wanted);
        begin
            errors = errors + 1;
            if (errors <= SHOWN) $display("%0s[%0d]: %h, must be %h", stream, index, found, wanted);
        end
    endtask

    task finish;
        begin
            if (owned_no != N_OWNED) differs("n_owned", 0, owned_no, N_OWNED);
            if (passed_no != N_PASSED) differs("n_passed", 0, passed_no, N_PASSED);
            if (beat_no != BEATS) differs("n_beats", 0, beat_no, BEATS);
            if (errors == 0) $display("PASS: %0d events, %0d records", N_EVENTS, N_RECORDS);
            else $display("FAIL: %0d differences", errors);
            $finish;
        end
    endtask

    // ---- a clock -----------------------------------------------------------------------------------------------------
    //
    // An access begins when `after` events are accepted, and the next event waits until it is done.

    reg     under_way = 1'b0, offers, done, due;
    integer next_event, next_at;
    wire    polls = access[80];

    function goes(input unused);
        goes = !stalls || $random(seed) % 4 != 0;
    endfunction

    always @(posedge clk)
        if (!rst) begin
            silent     = silent + 1;
            offers     = event_valid;
            next_event = event_no;
            next_at    = at;
            done       = 1'b0;

            // What this edge has transferred.
            if (event_valid && event_ready) begin
                next_event = event_no + 1;
                offers     = 1'b0;
                silent     = 0;
            end
            if (owned_valid && owned_ready) begin
                if (owned_no >= N_OWNED || {owned_data, owned_keep, owned_last} !== {owned[owned_no], 8'hff, 1'b1}
                    || owned_user !== owned_data[28 +: SLOT_W])
                    differs("owned", owned_no, owned_data, owned[owned_no]);
                owned_no = owned_no + 1;
                silent   = 0;
            end
            if (passed_valid && passed_ready) begin
                if (passed_no >= N_PASSED || {passed_data, passed_keep, passed_last} !== {passed[passed_no], 8'hff, 1'b1})
                    differs("passed", passed_no, passed_data, passed[passed_no]);
                passed_no = passed_no + 1;
                silent    = 0;
            end
            if (record_valid && record_ready) begin
                if (beat_no >= BEATS || {record_data, record_keep} !== {records[beat_no], 8'hff}
                    || record_last !== (beat_no % RECORD_BEATS == RECORD_BEATS - 1))
                    differs("records", beat_no, record_data, records[beat_no]);
                beat_no = beat_no + 1;
                silent  = 0;
            end
            if (awvalid && awready) awvalid <= 1'b0;
            if (wvalid && wready) wvalid <= 1'b0;
            if (arvalid && arready) arvalid <= 1'b0;
            if (bvalid && bready) begin
                if (bresp !== 2'b00) differs("bresp", at, {62'd0, bresp}, 64'd0);
                done   = 1'b1;
                silent = 0;
            end
            if (rvalid && rready) begin
                if (rresp !== 2'b00) differs("rresp", at, {62'd0, rresp}, 64'd0);
                if ((rdata & access[63:32]) === access[31:0]) done = 1'b1;
                else arvalid <= 1'b1;
            end

            // What comes next.
            if (done) next_at = at + 1;
            under_way <= under_way && !done;
            due = next_at < N_ACCESSES && accesses[next_at][115:84] <= next_event;
            if (due && !under_way && !offers) begin
                under_way <= 1'b1;
                {awvalid, wvalid, arvalid} <= {!polls, !polls, polls};
            end
            if (!due && !offers && next_event < N_EVENTS) offers = goes(1'b0);
            event_valid  <= offers;
            event_no     <= next_event;
            at           <= next_at;
            bready       <= goes(1'b0);
            rready       <= goes(1'b0);
            owned_ready  <= goes(1'b0);
            passed_ready <= goes(1'b0);
            record_ready <= goes(1'b0);

            if (next_at == N_ACCESSES && next_event == N_EVENTS) finish;
            if (silent == PATIENCE) begin
                $display("event %0d, access %0d: nothing has happened for %0d clocks", event_no, at, PATIENCE);
                errors = errors + 1;
                finish;
            end
        end

endmodule

`default_nettype wire
