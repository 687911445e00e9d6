// SPDX-License-Identifier: Apache-2.0
// A subset of evcot_top.v that fits on the smallest board: LFSR source, cot_array, records, and some of the registers.
//
// Same addresses as in docs/registers.md. Read: id, version, shape0 to shape2, build, sensor, and the counters `events`, `owned`,
// `passed` and `records`; all other words read 0. Write: control.enable, control.latch, and the registers of a slot, which act at
// once, one by one; all other writes are accepted and ignored. The LFSR's settings are those of the self-test.
`default_nettype none
`include "evcot_defs.vh"
`include "evcot_regs.vh"

module board_small #(
    parameter N = 1  // tracker slots
) (
    input  wire        clk,
    input  wire        rst,

    input  wire        s_axil_awvalid,
    output wire        s_axil_awready,
    input  wire [`EVCOT_CSR_ADDR_W-1:0] s_axil_awaddr,
    input  wire        s_axil_wvalid,
    output wire        s_axil_wready,
    input  wire [31:0] s_axil_wdata,
    output wire        s_axil_bvalid,
    input  wire        s_axil_bready,
    output wire [1:0]  s_axil_bresp,
    input  wire        s_axil_arvalid,
    output wire        s_axil_arready,
    input  wire [`EVCOT_CSR_ADDR_W-1:0] s_axil_araddr,
    output wire        s_axil_rvalid,
    input  wire        s_axil_rready,
    output wire [31:0] s_axil_rdata,
    output wire [1:0]  s_axil_rresp,

    output wire        m_axis_records_tvalid,
    input  wire        m_axis_records_tready,
    output wire [31:0] m_axis_records_tdata,
    output wire [3:0]  m_axis_records_tkeep,
    output wire        m_axis_records_tlast
);

    `include "board_selftest.vh"

    localparam SLOT_W  = (N > 1) ? $clog2(N) : 1;
    localparam WORD_W  = `EVCOT_CSR_ADDR_W - 2;

    // ---- registers ---------------------------------------------------------------------------------------------------

    wire              request, writes;
    wire [WORD_W-1:0] word;
    wire [31:0]       data;
    wire [3:0]        strb;
    reg  [31:0]       value;
    reg               enable;
    reg  [31:0]       n_events, n_owned, n_passed, n_records;
    reg  [31:0]       events, owned, passed, records;  // as they stood at the last latch

    axi_lite_slave #(
        .ADDR_W(`EVCOT_CSR_ADDR_W)
    ) u_bus (
        .clk           (clk),
        .rst           (rst),
        .s_axil_awvalid(s_axil_awvalid),
        .s_axil_awready(s_axil_awready),
        .s_axil_awaddr (s_axil_awaddr),
        .s_axil_awprot (3'd0),
        .s_axil_wvalid (s_axil_wvalid),
        .s_axil_wready (s_axil_wready),
        .s_axil_wdata  (s_axil_wdata),
        .s_axil_wstrb  (4'hF),
        .s_axil_bvalid (s_axil_bvalid),
        .s_axil_bready (s_axil_bready),
        .s_axil_bresp  (s_axil_bresp),
        .s_axil_arvalid(s_axil_arvalid),
        .s_axil_arready(s_axil_arready),
        .s_axil_araddr (s_axil_araddr),
        .s_axil_arprot (3'd0),
        .s_axil_rvalid (s_axil_rvalid),
        .s_axil_rready (s_axil_rready),
        .s_axil_rdata  (s_axil_rdata),
        .s_axil_rresp  (s_axil_rresp),
        .request_valid (request),
        .request_write (writes),
        .request_word  (word),
        .request_data  (data),
        .request_strb  (strb),
        .answer        (request),
        .answer_data   (value),
        .answer_error  (1'b0)
    );

    wire in_slots  = word[WORD_W-1];
    wire cfg_valid = request && writes && in_slots && word[`EVCOT_REG_W-1:0] != `EVCOT_BANK_COMMIT;

    always @*
        case (word)
            WORD_ID:      value = `EVCOT_CSR_ID;
            WORD_VERSION: value = {`EVCOT_CSR_MAJOR, `EVCOT_CSR_MINOR};
            WORD_SHAPE0:  value = SHAPE0 | N;
            WORD_SHAPE1:  value = SHAPE1;
            WORD_SHAPE2:  value = SHAPE2;
            WORD_BUILD:   value = BUILD;  // no filter, the LFSR, an array
            WORD_SENSOR:  value = SENSOR;
            WORD_MEMORY:  value = MEMORY;
            WORD_CONTROL: value = {31'd0, enable};
            WORD_EVENTS:  value = events;
            WORD_OWNED:   value = owned;
            WORD_PASSED:  value = passed;
            WORD_RECORDS: value = records;
            default:      value = 32'd0;
        endcase

    always @(posedge clk) begin
        if (request && writes && word == WORD_CONTROL) begin
            enable <= data[0];
            if (data[8]) begin
                events  <= n_events;
                owned   <= n_owned;
                passed  <= n_passed;
                records <= n_records;
            end
        end
        if (rst) begin
            enable <= 1'b0;
            {events, owned, passed, records} <= {4 * 32{1'b0}};
        end
    end

    // ---- source ------------------------------------------------------------------------------------------------------

    reg  loaded, first;
    wire offered, ready, event_p;
    wire [SHAPE_X_W-1:0] event_x;
    wire [SHAPE_Y_W-1:0] event_y;
    wire take = enable && loaded && ready;

    always @(posedge clk) begin
        loaded <= 1'b1;
        if (offered && take) begin
            first    <= 1'b0;
            n_events <= n_events + 32'd1;
        end
        if (rst) begin
            loaded   <= 1'b0;
            first    <= 1'b1;
            n_events <= 32'd0;
        end
    end

    /* verilator lint_off PINCONNECTEMPTY */
    lfsr_event_source #(
        .X_W   (SHAPE_X_W),
        .Y_W   (SHAPE_Y_W),
        .GAP_W (GAP_W),
        .LFSR_W(32)
    ) u_source (
        .clk       (clk),
        .rst       (rst),
        .enable    (enable && loaded),
        .load      (!loaded),
        .seed      (SEED),
        .seed_error(),
        .done      (),
        .gap       (GAP),
        .x_min     (X_MIN),
        .x_span    (X_SPAN),
        .y_min     (Y_MIN),
        .y_span    (Y_SPAN),
        .m_valid   (offered),
        .m_ready   (take),
        .m_x       (event_x),
        .m_y       (event_y),
        .m_p       (event_p)
    );

    // ---- tracker -----------------------------------------------------------------------------------------------------

    wire                  cm_valid, cm_ready, own_valid, pass_valid;
    wire [1:0]            cm_kind;
    wire [SLOT_W-1:0]     cm_slot;
    wire [SHAPE_ID_W-1:0] cm_id, cm_other;
    wire [SHAPE_X_W+SHAPE_FRAC-1:0] cm_x;
    wire [SHAPE_Y_W+SHAPE_FRAC-1:0] cm_y;
    wire [SHAPE_RADIX_W:0]  cm_radius;
    wire [SHAPE_NEV_W-1:0]  cm_n_ev;
    wire [SHAPE_SUP_W-1:0]  cm_support;
    wire [SHAPE_SEQ_W-1:0]  cm_seq;
    wire [SHAPE_TIME_W-1:0] cm_time;

    cot_array #(
        .N      (N),
        .X_W    (SHAPE_X_W),
        .Y_W    (SHAPE_Y_W),
        .FRAC   (SHAPE_FRAC),
        .TICK_W (SHAPE_TICK_W),
        .RADIX_W(SHAPE_RADIX_W),
        .NEV_W  (SHAPE_NEV_W),
        .TC_W   (SHAPE_TC_W),
        .SUP_W  (SHAPE_SUP_W),
        .ID_W   (SHAPE_ID_W),
        .SEQ_W  (SHAPE_SEQ_W),
        .TIME_W (SHAPE_TIME_W)
    ) u_array (
        .clk         (clk),
        .rst         (rst),
        .cfg_valid   (cfg_valid),
        .cfg_slot    (word[`EVCOT_REG_W+:SLOT_W]),
        .cfg_addr    (word[`EVCOT_REG_W-1:0]),
        .cfg_data    (data),
        .s_valid     (offered && enable && loaded),
        .s_ready     (ready),
        .s_tick      (first ? {SHAPE_TICK_W{1'b0}} : {{SHAPE_TICK_W - GAP_W{1'b0}}, GAP} + 1'b1),
        .s_event     (1'b1),
        .s_skip      (1'b0),
        .s_x         (event_x),
        .s_y         (event_y),
        .s_p         (event_p),
        .m_cm_valid  (cm_valid),
        .m_cm_ready  (cm_ready),
        .m_cm_kind   (cm_kind),
        .m_cm_slot   (cm_slot),
        .m_cm_id     (cm_id),
        .m_cm_other  (cm_other),
        .m_cm_x      (cm_x),
        .m_cm_y      (cm_y),
        .m_cm_radius (cm_radius),
        .m_cm_n_ev   (cm_n_ev),
        .m_cm_support(cm_support),
        .m_cm_seq    (cm_seq),
        .m_cm_time   (cm_time),
        .m_own_valid (own_valid),
        .m_own_ready (1'b1),
        .m_own_slot  (),
        .m_own_x     (),
        .m_own_y     (),
        .m_own_p     (),
        .m_own_seq   (),
        .m_pass_valid(pass_valid),
        .m_pass_ready(1'b1),
        .m_pass_x    (),
        .m_pass_y    (),
        .m_pass_p    (),
        .m_pass_seq  (),
        .idle        ()
    );

    always @(posedge clk) begin
        if (own_valid)            n_owned   <= n_owned + 32'd1;
        if (pass_valid)           n_passed  <= n_passed + 32'd1;
        if (cm_valid && cm_ready) n_records <= n_records + 32'd1;
        if (rst) begin
            n_owned   <= 32'd0;
            n_passed  <= 32'd0;
            n_records <= 32'd0;
        end
    end

    axis_records_out #(
        .DATA_W  (32),
        .DEPTH   (1),
        .SLOT_W  (SLOT_W),
        .ID_W    (SHAPE_ID_W),
        .X_W     (SHAPE_X_W + SHAPE_FRAC),
        .Y_W     (SHAPE_Y_W + SHAPE_FRAC),
        .RADIUS_W(SHAPE_RADIX_W + 1),
        .NEV_W   (SHAPE_NEV_W),
        .SUP_W   (SHAPE_SUP_W),
        .SEQ_W   (SHAPE_SEQ_W),
        .TIME_W  (SHAPE_TIME_W)
    ) u_records (
        .clk          (clk),
        .rst          (rst),
        .s_rst        (rst),
        .packet_records(16'd1),
        .packet_wait  (16'd0),
        .s_cm_valid   (cm_valid),
        .s_cm_ready   (cm_ready),
        .s_cm_kind    (cm_kind),
        .s_cm_slot    (cm_slot),
        .s_cm_id      (cm_id),
        .s_cm_other   (cm_other),
        .s_cm_x       (cm_x),
        .s_cm_y       (cm_y),
        .s_cm_radius  (cm_radius),
        .s_cm_width   (25'd0),
        .s_cm_height  (25'd0),
        .s_cm_v_x     (16'd0),
        .s_cm_v_y     (16'd0),
        .s_cm_n_ev    (cm_n_ev),
        .s_cm_support (cm_support),
        .s_cm_seq     (cm_seq),
        .s_cm_time    (cm_time),
        .s_verdict_valid  (1'b0),
        .s_verdict_ready  (),
        .s_verdict_slot   ({SLOT_W{1'b0}}),
        .s_verdict_id     ({SHAPE_ID_W{1'b0}}),
        .s_verdict_seq    ({SHAPE_SEQ_W{1'b0}}),
        .s_verdict_class  (4'd0),
        .s_verdict_margin (15'd0),
        .s_verdict_windows(8'd0),
        .m_axis_tvalid(m_axis_records_tvalid),
        .m_axis_tready(m_axis_records_tready),
        .m_axis_tdata (m_axis_records_tdata),
        .m_axis_tkeep (m_axis_records_tkeep),
        .m_axis_tlast (m_axis_records_tlast),
        .idle         ()
    );
    /* verilator lint_on PINCONNECTEMPTY */

    wire unused = &{1'b0, strb};

endmodule

`default_nettype wire
