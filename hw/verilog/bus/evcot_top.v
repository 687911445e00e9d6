// SPDX-License-Identifier: Apache-2.0
// The complete tracker with standard buses: events in; records, owned and passed events out; registers on AXI4-Lite; an interrupt.
//
//     source -> input FIFO -> gate -> filters -> trackers -> records, owned events, passed events: AXI4-Stream
//                              |         |           |-> classifier -> verdicts, among the records
//                              |         |           |
//              AXI4-Lite: axi_lite_regs, which closes the gate to change registers between two events
//
// Registers and the words of all streams: docs/registers.md. After reset SOURCE is selected, slots and filters are off and
// the gate is closed: write the registers of a slot, commit them, set control.enable.
//
// Latency: unstalled, from the beat of an event that moves a centre to the first beat of its record, at 1 us a tick: 13 clocks, 11 without
//          the divider, as many as a record has beats,
//          those of the filters that are built, and those of the tracker: those of cot_array or cot_motion, or 6 in the first of
//          cot_chain.
// Throughput: an event per clock, where source, filters and trackers keep up.
// Stall:   back-pressure of an output stalls the trackers, then the gate, then the source; with control.drop events are
//          dropped at the input FIFO and counted, and time goes on. Tie m_axis_owned_tready or m_axis_passed_tready to 1 if
//          the output is not used.
// Reset:   synchronous, active high, at least 2 clocks. Written registers are lost; control.soft_reset keeps them, but
//          slots and filters are off after it until they are committed. It violates no handshake: data that has reached an
//          output is sent completely, and a handshake with an AER chip is completed.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"
`include "evcot_regs.vh"

module evcot_top #(
    parameter SOURCES      = 1,    // sources to build, a bit each: 1 events, 2 LFSR, 4 AER, 8 EVT 2.0, 16 EVT 2.1, 32 EVT 3.0
    parameter SOURCE       = 0,    // number of the one that is selected after reset
    parameter TICKS        = 3,    // what a tick may be, besides 1 us of the events' time, a bit each: 1 tick_us of it, 2 a time of the clock
    parameter TRACKER      = 0,    // 0 cot_array, 1 cot_chain, 2 cot_motion: cot_motion
    parameter HAS          = 0,    // filters to build, one bit each in the order of EVCOT_FILTER_*
    parameter WIDTH        = 346,  // pixels of the sensor across
    parameter HEIGHT       = 260,  // pixels of the sensor down
    parameter STAMP_W      = 20,   // bits of a time stamp in a filter's memory
    parameter RECENT_DEPTH = 32,   // events in the FIFO of recent events
    parameter CELL_PX      = 0,    // side of a cell of the filters' memory in pixels: 1, 2 or 4; 0: a time stamp per pixel
    parameter FIFO_DEPTH   = 256,  // tokens in the input FIFO
    parameter RECORD_DEPTH = 16,   // records that may wait for m_axis_records
    parameter CLASSIFY     = 0,    // 1: the classifier behind cot_motion (TRACKER = 2); its verdicts are records of their own kind
    parameter DATA_W       = 64,   // bits of a beat of m_axis_records: 32, 64, 128 or 256
    parameter N            = 8,    // tracker slots
    parameter X_W          = 9,    // bits of an x address
    parameter Y_W          = 9,    // bits of a y address
    parameter FRAC         = 4,    // fractional bits of a centre and of an average
    parameter TICK_W       = 20,   // bits of the ticks in a token
    parameter RADIX_W      = 8,    // bits of a radius register
    parameter NEV_W        = 10,   // bits of N_ev
    parameter TC_W         = 24,   // bits of a timer
    parameter SUP_W        = 16,   // bits of a support count
    parameter ID_W         = 32,   // bits of a track id
    parameter SEQ_W        = 48,   // bits of an event's number
    parameter TIME_W       = 48,   // bits of the tick count
    parameter SLOT_W       = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire                clk,
    input  wire                rst,

    // registers
    input  wire                s_axil_awvalid,
    output wire                s_axil_awready,
    input  wire [`EVCOT_CSR_ADDR_W-1:0] s_axil_awaddr,
    input  wire [2:0]          s_axil_awprot,
    input  wire                s_axil_wvalid,
    output wire                s_axil_wready,
    input  wire [31:0]         s_axil_wdata,
    input  wire [3:0]          s_axil_wstrb,
    output wire                s_axil_bvalid,
    input  wire                s_axil_bready,
    output wire [1:0]          s_axil_bresp,
    input  wire                s_axil_arvalid,
    output wire                s_axil_arready,
    input  wire [`EVCOT_CSR_ADDR_W-1:0] s_axil_araddr,
    input  wire [2:0]          s_axil_arprot,
    output wire                s_axil_rvalid,
    input  wire                s_axil_rready,
    output wire [31:0]         s_axil_rdata,
    output wire [1:0]          s_axil_rresp,
    output wire                irq,

    // events, or EVT words, lowest first; tie what is not used to 0, tkeep to ones
    input  wire                s_axis_tvalid,
    output wire                s_axis_tready,
    input  wire [63:0]         s_axis_tdata,
    input  wire [7:0]          s_axis_tkeep,
    input  wire                s_axis_tlast,

    // AER: see aer_in.v; asynchronous
    input  wire                aer_req,
    output wire                aer_ack,
    input  wire                aer_row,
    input  wire [X_W+Y_W:0]    aer_data,

    output wire                m_axis_records_tvalid,
    input  wire                m_axis_records_tready,
    output wire [DATA_W-1:0]   m_axis_records_tdata,
    output wire [DATA_W/8-1:0] m_axis_records_tkeep,
    output wire                m_axis_records_tlast,

    output wire                m_axis_owned_tvalid,
    input  wire                m_axis_owned_tready,
    output wire [63:0]         m_axis_owned_tdata,
    output wire [7:0]          m_axis_owned_tkeep,
    output wire [SLOT_W-1:0]   m_axis_owned_tuser,
    output wire                m_axis_owned_tlast,

    output wire                m_axis_passed_tvalid,
    input  wire                m_axis_passed_tready,
    output wire [63:0]         m_axis_passed_tdata,
    output wire [7:0]          m_axis_passed_tkeep,
    output wire                m_axis_passed_tlast
);

    parameter_check #(.OK(HAS >= 0 && HAS <= 255)) HAS_must_be_0_to_255 ();
    parameter_check #(.OK(WIDTH >= 1 && WIDTH <= (1 << X_W))) WIDTH_must_be_1_to_2_to_the_X_W ();
    parameter_check #(.OK(HEIGHT >= 1 && HEIGHT <= (1 << Y_W))) HEIGHT_must_be_1_to_2_to_the_Y_W ();
    parameter_check #(.OK(FIFO_DEPTH >= 1 && FIFO_DEPTH <= 16384)) FIFO_DEPTH_must_be_1_to_16384 ();
    parameter_check #(.OK(CLASSIFY == 0 || (CLASSIFY == 1 && TRACKER == `EVCOT_TRACKER_MOTION))) CLASSIFY_must_be_0_or_1_and_needs_cot_motion ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    // ---- reset: of everything, or of what lies between the buses -----------------------------------------------------

    wire      soft_reset;
    reg [1:0] resetting;
    reg       core_rst;

    always @(posedge clk) begin
        resetting <= (rst || soft_reset) ? 2'd3 : (resetting == 2'd0) ? 2'd0 : resetting - 1'b1;
        core_rst  <= rst || soft_reset || resetting != 2'd0;
    end

    // ---- registers ---------------------------------------------------------------------------------------------------

    wire [2:0]  new_select;
    wire        new_clock_time, new_swap_bytes, new_swap_halves, new_active_low, new_word_serial;
    wire [19:0] new_tick_us;
    wire [15:0] new_prescale_tick, new_prescale_us, new_gap, new_x_min, new_x_span, new_y_min, new_y_span;
    wire [31:0] new_seed;

    wire              enable, drop, busy, apply, cleared, open, dropped, idle;
    wire [47:0]       seq;
    wire              cfg_valid, filter_cfg_valid, classifier_cfg_valid;
    wire [SLOT_W-1:0] cfg_slot;
    wire [`EVCOT_MREG_W-1:0] cfg_addr;
    wire [`EVCOT_FREG_W-1:0] filter_cfg_addr;
    wire [31:0]       cfg_data, filter_cfg_data;
    wire [15:0]       held;
    wire [31:0]       n_in, n_dropped, n_malformed, n_backward;
    wire [15:0]       packet_records, packet_wait;
    wire              weight_address_write, weight_data_write, weight_ready, verdict_lost;
    wire [11:0]       weight_address_new, weight_address, weights_loaded;
    wire [17:0]       weight_data_new, weight_data;
    reg               all_idle;
    reg  [31:0]       n_filtered, n_owned, n_passed, n_records, n_stalls;
    reg  [`EVCOT_IRQ_COMMIT-1:0] happened;

    axi_lite_regs #(
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
        .TIME_W      (TIME_W),
        .HAS         (HAS),
        .SOURCES     (SOURCES),
        .SOURCE      (SOURCE),
        .TICKS       (TICKS),
        .TRACKER     (TRACKER),
        .WIDTH       (WIDTH),
        .HEIGHT      (HEIGHT),
        .STAMP_W     (STAMP_W),
        .RECENT_DEPTH(RECENT_DEPTH),
        .CELL_PX     (CELL_PX),
        .FIFO_DEPTH  (FIFO_DEPTH),
        .CLASSIFY    (CLASSIFY)
    ) u_regs (
        .clk             (clk),
        .rst             (rst),
        .core_rst        (core_rst || soft_reset),
        .s_axil_awvalid  (s_axil_awvalid),
        .s_axil_awready  (s_axil_awready),
        .s_axil_awaddr   (s_axil_awaddr),
        .s_axil_awprot   (s_axil_awprot),
        .s_axil_wvalid   (s_axil_wvalid),
        .s_axil_wready   (s_axil_wready),
        .s_axil_wdata    (s_axil_wdata),
        .s_axil_wstrb    (s_axil_wstrb),
        .s_axil_bvalid   (s_axil_bvalid),
        .s_axil_bready   (s_axil_bready),
        .s_axil_bresp    (s_axil_bresp),
        .s_axil_arvalid  (s_axil_arvalid),
        .s_axil_arready  (s_axil_arready),
        .s_axil_araddr   (s_axil_araddr),
        .s_axil_arprot   (s_axil_arprot),
        .s_axil_rvalid   (s_axil_rvalid),
        .s_axil_rready   (s_axil_rready),
        .s_axil_rdata    (s_axil_rdata),
        .s_axil_rresp    (s_axil_rresp),
        .enable          (enable),
        .drop            (drop),
        .soft_reset      (soft_reset),
        .source_select   (new_select),
        .clock_time      (new_clock_time),
        .swap_bytes      (new_swap_bytes),
        .swap_halves     (new_swap_halves),
        .active_low      (new_active_low),
        .word_serial     (new_word_serial),
        .tick_us         (new_tick_us),
        .prescale_tick   (new_prescale_tick),
        .prescale_us     (new_prescale_us),
        .packet_records  (packet_records),
        .packet_wait     (packet_wait),
        .lfsr_seed       (new_seed),
        .lfsr_gap        (new_gap),
        .lfsr_x_min      (new_x_min),
        .lfsr_x_span     (new_x_span),
        .lfsr_y_min      (new_y_min),
        .lfsr_y_span     (new_y_span),
        .busy            (busy),
        .apply           (apply),
        .cleared         (cleared),
        .seq             (seq),
        .cfg_valid       (cfg_valid),
        .cfg_slot        (cfg_slot),
        .cfg_addr        (cfg_addr),
        .cfg_data        (cfg_data),
        .filter_cfg_valid(filter_cfg_valid),
        .filter_cfg_addr (filter_cfg_addr),
        .filter_cfg_data (filter_cfg_data),
        .classifier_cfg_valid(classifier_cfg_valid),
        .weight_address_write(weight_address_write),
        .weight_address_new  (weight_address_new),
        .weight_address  (weight_address),
        .weight_data_write(weight_data_write),
        .weight_data_new (weight_data_new),
        .weight_data     (weight_data),
        .weight_ready    (weight_ready),
        .weights_loaded  (weights_loaded),
        .verdict_lost    (verdict_lost),
        .idle            (all_idle),
        .open            (open),
        .held            (held),
        .n_events_in     (n_in),
        .n_events_dropped(n_dropped),
        .n_malformed     (n_malformed),
        .n_backward      (n_backward),
        .n_filtered      (n_filtered),
        .n_owned         (n_owned),
        .n_passed        (n_passed),
        .n_records       (n_records),
        .n_stalls        (n_stalls),
        .happened        (happened),
        .irq             (irq)
    );

    // What takes effect with a reset.
    reg [2:0]     select;
    reg           clock_time, swap_bytes, swap_halves, active_low, word_serial;
    reg [19:0]    tick_us;
    reg [15:0]    prescale_tick, prescale_us, lfsr_gap;
    reg [31:0]    lfsr_seed;
    reg [X_W-1:0] lfsr_x_min, lfsr_x_span;
    reg [Y_W-1:0] lfsr_y_min, lfsr_y_span;

    always @(posedge clk)
        if (core_rst) begin
            select        <= new_select;
            clock_time    <= new_clock_time;
            swap_bytes    <= new_swap_bytes;
            swap_halves   <= new_swap_halves;
            active_low    <= new_active_low;
            word_serial   <= new_word_serial;
            tick_us       <= new_tick_us;
            prescale_tick <= new_prescale_tick;
            prescale_us   <= new_prescale_us;
            lfsr_seed     <= new_seed;
            lfsr_gap      <= new_gap;
            lfsr_x_min    <= new_x_min[X_W-1:0];
            lfsr_x_span   <= new_x_span[X_W-1:0];
            lfsr_y_min    <= new_y_min[Y_W-1:0];
            lfsr_y_span   <= new_y_span[Y_W-1:0];
        end

    // ---- source to gate ----------------------------------------------------------------------------------------------

    wire              s_valid, s_ready, s_event, s_skip, s_p, sources_idle;
    wire [TICK_W-1:0] s_tick;
    wire [X_W-1:0]    s_x;
    wire [Y_W-1:0]    s_y;

    event_sources #(
        .SOURCES(SOURCES),
        .TICKS  (TICKS),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .TICK_W (TICK_W),
        .WIDTH  (WIDTH),
        .HEIGHT (HEIGHT),
        .DEPTH  (FIFO_DEPTH)
    ) u_sources (
        .clk          (clk),
        .rst          (core_rst),
        .aer_rst      (rst),
        .select       (select),
        .clock_time   (clock_time),
        .swap_bytes   (swap_bytes),
        .swap_halves  (swap_halves),
        .active_low   (active_low),
        .word_serial  (word_serial),
        .tick_us      (tick_us),
        .prescale_tick(prescale_tick),
        .prescale_us  (prescale_us),
        .lfsr_seed    (lfsr_seed),
        .lfsr_gap     (lfsr_gap),
        .lfsr_x_min   (lfsr_x_min),
        .lfsr_x_span  (lfsr_x_span),
        .lfsr_y_min   (lfsr_y_min),
        .lfsr_y_span  (lfsr_y_span),
        .drop         (drop),
        .s_axis_tvalid(s_axis_tvalid),
        .s_axis_tready(s_axis_tready),
        .s_axis_tdata (s_axis_tdata),
        .s_axis_tkeep (s_axis_tkeep),
        .s_axis_tlast (s_axis_tlast),
        .aer_req      (aer_req),
        .aer_ack      (aer_ack),
        .aer_row      (aer_row),
        .aer_data     (aer_data),
        .m_valid      (s_valid),
        .m_ready      (s_ready),
        .m_tick       (s_tick),
        .m_event      (s_event),
        .m_skip       (s_skip),
        .m_x          (s_x),
        .m_y          (s_y),
        .m_p          (s_p),
        .dropped      (dropped),
        .n_in         (n_in),
        .n_dropped    (n_dropped),
        .n_malformed  (n_malformed),
        .n_backward   (n_backward),
        .held         (held),
        .idle         (sources_idle)
    );

    wire f_valid, f_ready;
    wire quiet;  // the classifier has evaluated all windows

    token_gate #(
        .SEQ_W(48)
    ) u_gate (
        .clk     (clk),
        .rst     (core_rst),
        .enable  (enable),
        .busy    (busy),
        .idle    (idle && quiet),
        .apply   (apply),
        .cleared (cleared),
        .open    (open),
        .seq     (seq),
        .s_valid (s_valid),
        .s_ready (s_ready),
        .s_counts(s_event || s_skip),
        .m_valid (f_valid),
        .m_ready (f_ready)
    );

    // ---- filters and trackers ----------------------------------------------------------------------------------------

    // A record has a centre and a radius, or of cot_motion the middle of a box, its sides and its velocity.
    localparam MOTION = (TRACKER == `EVCOT_TRACKER_MOTION) ? 1 : 0;
    localparam REACH  = (X_W > Y_W) ? (X_W > 9 ? X_W : 9) : (Y_W > 9 ? Y_W : 9);
    localparam SIDE_W = REACH + 16;
    localparam CM_X_W = (MOTION != 0) ? SIDE_W : X_W + FRAC;
    localparam CM_Y_W = (MOTION != 0) ? SIDE_W : Y_W + FRAC;
    localparam N_EV_W = (MOTION != 0) ? 10 : NEV_W;

    wire                cm_valid, cm_ready, own_valid, own_ready, own_p, pass_valid, pass_ready, pass_p, filtered;
    wire [1:0]          cm_kind;
    wire [SLOT_W-1:0]   cm_slot, own_slot;
    wire [ID_W-1:0]     cm_id, cm_other;
    wire [CM_X_W-1:0]   cm_x;
    wire [CM_Y_W-1:0]   cm_y;
    wire [RADIX_W:0]    cm_radius;
    wire [SIDE_W-1:0]   cm_width, cm_height;
    wire [15:0]         cm_v_x, cm_v_y;
    wire [N_EV_W-1:0]   cm_n_ev;
    wire [SUP_W-1:0]    cm_support;
    wire [SEQ_W-1:0]    cm_seq, own_seq, pass_seq;
    wire                own_visible;
    wire [ID_W-1:0]     own_id;
    wire [TIME_W-1:0]   cm_time;
    wire [RADIX_W+1:0]  own_x, own_y;
    wire [X_W-1:0]      pass_x;
    wire [Y_W-1:0]      pass_y;

    cot_filtered #(
        .TRACKER     (TRACKER),
        .HAS         (HAS),
        .WIDTH       (WIDTH),
        .HEIGHT      (HEIGHT),
        .STAMP_W     (STAMP_W),
        .RECENT_DEPTH(RECENT_DEPTH),
        .CELL_PX     (CELL_PX),
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
        .TIME_W      (TIME_W),
        .OWNERS      ((CLASSIFY != 0) ? 1 : 0)
    ) u_filtered (
        .clk             (clk),
        .rst             (core_rst),
        .cfg_valid       (cfg_valid),
        .cfg_slot        (cfg_slot),
        .cfg_addr        (cfg_addr),
        .cfg_data        (cfg_data),
        .filter_cfg_valid(filter_cfg_valid),
        .filter_cfg_addr (filter_cfg_addr),
        .filter_cfg_data (filter_cfg_data),
        .s_valid         (f_valid),
        .s_ready         (f_ready),
        .s_tick          (s_tick),
        .s_event         (s_event),
        .s_skip          (s_skip),
        .s_x             (s_x),
        .s_y             (s_y),
        .s_p             (s_p),
        .m_cm_valid      (cm_valid),
        .m_cm_ready      (cm_ready),
        .m_cm_kind       (cm_kind),
        .m_cm_slot       (cm_slot),
        .m_cm_id         (cm_id),
        .m_cm_other      (cm_other),
        .m_cm_x          (cm_x),
        .m_cm_y          (cm_y),
        .m_cm_radius     (cm_radius),
        .m_cm_width      (cm_width),
        .m_cm_height     (cm_height),
        .m_cm_v_x        (cm_v_x),
        .m_cm_v_y        (cm_v_y),
        .m_cm_n_ev       (cm_n_ev),
        .m_cm_support    (cm_support),
        .m_cm_seq        (cm_seq),
        .m_cm_time       (cm_time),
        .m_own_valid     (own_valid),
        .m_own_ready     (own_ready),
        .m_own_slot      (own_slot),
        .m_own_x         (own_x),
        .m_own_y         (own_y),
        .m_own_p         (own_p),
        .m_own_seq       (own_seq),
        .m_own_visible   (own_visible),
        .m_own_id        (own_id),
        .m_pass_valid    (pass_valid),
        .m_pass_ready    (pass_ready),
        .m_pass_x        (pass_x),
        .m_pass_y        (pass_y),
        .m_pass_p        (pass_p),
        .m_pass_seq      (pass_seq),
        .filtered        (filtered),
        .idle            (idle)
    );

    // ---- classifier --------------------------------------------------------------------------------------------------

    wire              verdict_valid, verdict_ready, classifier_idle;
    wire [SLOT_W-1:0] verdict_slot;
    wire [ID_W-1:0]   verdict_id;
    wire [SEQ_W-1:0]  verdict_seq;
    wire [3:0]        verdict_class;
    wire [14:0]       verdict_margin;
    wire [7:0]        verdict_windows;

    generate
        if (CLASSIFY != 0) begin : g_classifier
            classifier_bus #(
                .N      (N),
                .RADIX_W(RADIX_W),
                .ID_W   (ID_W),
                .SEQ_W  (SEQ_W)
            ) u_classifier (
                .clk                 (clk),
                .rst                 (rst),
                .core_rst            (core_rst),
                .quiet               (quiet),
                .cfg_valid           (classifier_cfg_valid),
                .cfg_addr            (cfg_addr[`EVCOT_CREG_W-1:0]),
                .cfg_data            (cfg_data[11:0]),
                .weight_address_write(weight_address_write),
                .weight_address_new  (weight_address_new),
                .weight_address      (weight_address),
                .weight_ready        (weight_ready),
                .weight_data_write   (weight_data_write),
                .weight_data_new     (weight_data_new),
                .weight_data         (weight_data),
                .loaded              (weights_loaded),
                .s_valid             (own_valid && own_ready),
                .s_slot              (own_slot),
                .s_dx                (own_x),
                .s_dy                (own_y),
                .s_visible           (own_visible),
                .s_id                (own_id),
                .s_seq               (own_seq),
                .m_valid             (verdict_valid),
                .m_ready             (verdict_ready),
                .m_slot              (verdict_slot),
                .m_id                (verdict_id),
                .m_seq               (verdict_seq),
                .m_class             (verdict_class),
                .m_margin            (verdict_margin),
                .m_windows           (verdict_windows),
                .lost                (verdict_lost),
                .idle                (classifier_idle)
            );
        end else begin : g_no_classifier
            assign quiet           = 1'b1;
            assign weight_address  = 12'd0;
            assign weight_ready    = 1'b0;
            assign weight_data     = 18'd0;
            assign weights_loaded  = 12'd0;
            assign verdict_valid   = 1'b0;
            assign verdict_slot    = {SLOT_W{1'b0}};
            assign verdict_id      = {ID_W{1'b0}};
            assign verdict_seq     = {SEQ_W{1'b0}};
            assign verdict_class   = 4'd0;
            assign verdict_margin  = 15'd0;
            assign verdict_windows = 8'd0;
            assign verdict_lost    = 1'b0;
            assign classifier_idle = 1'b1;

            wire unused_classifier = &{1'b0, classifier_cfg_valid, weight_address_write, weight_address_new, weight_data_write,
                                       weight_data_new, own_visible, own_id, verdict_ready};
        end
    endgenerate

    // ---- outputs: what has come here goes out whole, soft reset or not -----------------------------------------------

    wire records_idle;

    axis_records_out #(
        .DATA_W  (DATA_W),
        .DEPTH   (RECORD_DEPTH),
        .MOTION  (MOTION),
        .CLASSIFY(CLASSIFY),
        .SLOT_W  (SLOT_W),
        .ID_W    (ID_W),
        .X_W     (CM_X_W),
        .Y_W     (CM_Y_W),
        .RADIUS_W(RADIX_W + 1),
        .SIDE_W  (SIDE_W),
        .NEV_W   (N_EV_W),
        .SUP_W   (SUP_W),
        .SEQ_W   (SEQ_W),
        .TIME_W  (TIME_W)
    ) u_records (
        .clk          (clk),
        .rst          (rst),
        .s_rst        (core_rst),
        .packet_records(packet_records),
        .packet_wait  (packet_wait),
        .s_cm_valid   (cm_valid),
        .s_cm_ready   (cm_ready),
        .s_cm_kind    (cm_kind),
        .s_cm_slot    (cm_slot),
        .s_cm_id      (cm_id),
        .s_cm_other   (cm_other),
        .s_cm_x       (cm_x),
        .s_cm_y       (cm_y),
        .s_cm_radius  (cm_radius),
        .s_cm_width   (cm_width),
        .s_cm_height  (cm_height),
        .s_cm_v_x     (cm_v_x),
        .s_cm_v_y     (cm_v_y),
        .s_cm_n_ev    (cm_n_ev),
        .s_cm_support (cm_support),
        .s_cm_seq     (cm_seq),
        .s_cm_time    (cm_time),
        .s_verdict_valid  (verdict_valid),
        .s_verdict_ready  (verdict_ready),
        .s_verdict_slot   (verdict_slot),
        .s_verdict_id     (verdict_id),
        .s_verdict_seq    (verdict_seq),
        .s_verdict_class  (verdict_class),
        .s_verdict_margin (verdict_margin),
        .s_verdict_windows(verdict_windows),
        .m_axis_tvalid(m_axis_records_tvalid),
        .m_axis_tready(m_axis_records_tready),
        .m_axis_tdata (m_axis_records_tdata),
        .m_axis_tkeep (m_axis_records_tkeep),
        .m_axis_tlast (m_axis_records_tlast),
        .idle         (records_idle)
    );

    axis_owned_out #(
        .SLOT_W(SLOT_W),
        .REL_W (RADIX_W + 2),
        .SEQ_W (SEQ_W)
    ) u_owned (
        .clk          (clk),
        .rst          (rst),
        .s_own_valid  (own_valid),
        .s_own_ready  (own_ready),
        .s_own_slot   (own_slot),
        .s_own_x      (own_x),
        .s_own_y      (own_y),
        .s_own_p      (own_p),
        .s_own_seq    (own_seq),
        .m_axis_tvalid(m_axis_owned_tvalid),
        .m_axis_tready(m_axis_owned_tready),
        .m_axis_tdata (m_axis_owned_tdata),
        .m_axis_tkeep (m_axis_owned_tkeep),
        .m_axis_tuser (m_axis_owned_tuser),
        .m_axis_tlast (m_axis_owned_tlast)
    );

    axis_passed_out #(
        .X_W  (X_W),
        .Y_W  (Y_W),
        .SEQ_W(SEQ_W)
    ) u_passed (
        .clk          (clk),
        .rst          (rst),
        .s_pass_valid (pass_valid),
        .s_pass_ready (pass_ready),
        .s_pass_x     (pass_x),
        .s_pass_y     (pass_y),
        .s_pass_p     (pass_p),
        .s_pass_seq   (pass_seq),
        .m_axis_tvalid(m_axis_passed_tvalid),
        .m_axis_tready(m_axis_passed_tready),
        .m_axis_tdata (m_axis_passed_tdata),
        .m_axis_tkeep (m_axis_passed_tkeep),
        .m_axis_tlast (m_axis_passed_tlast)
    );

    always @(posedge clk)
        all_idle <= !rst && sources_idle && idle && classifier_idle && records_idle && !m_axis_owned_tvalid && !m_axis_passed_tvalid
                 && !(s_axis_tvalid && s_axis_tready);  // nor does anything come

    // ---- what is counted, and what interrupts ------------------------------------------------------------------------

    wire recorded = cm_valid && cm_ready;

    always @(posedge clk) begin
        if (filtered) n_filtered <= n_filtered + 1'b1;
        if (own_valid && own_ready) n_owned <= n_owned + 1'b1;
        if (pass_valid && pass_ready) n_passed <= n_passed + 1'b1;
        if (recorded || (verdict_valid && verdict_ready)) n_records <= n_records + 1'b1;
        if (s_valid && !s_ready && enable) n_stalls <= n_stalls + 1'b1;

        happened[`EVCOT_IRQ_BIRTH]    <= recorded && cm_kind == `EVCOT_KIND_BORN;
        happened[`EVCOT_IRQ_LOSS]     <= recorded && cm_kind == `EVCOT_KIND_LOST;
        happened[`EVCOT_IRQ_MERGE]    <= recorded && cm_kind == `EVCOT_KIND_MERGED;
        happened[`EVCOT_IRQ_OVERFLOW] <= dropped;

        if (core_rst) begin
            {n_filtered, n_owned, n_passed, n_records, n_stalls} <= {5 * 32{1'b0}};
            happened <= {`EVCOT_IRQ_COMMIT{1'b0}};
        end
    end

    wire unused = &{1'b0, new_x_min, new_x_span, new_y_min, new_y_span};

endmodule

`default_nettype wire
