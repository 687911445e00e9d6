// SPDX-License-Identifier: Apache-2.0
// All registers of evcot_top.v on AXI4-Lite: docs/registers.md.
//
// The words outside the banks are axi_lite_words.v. The registers of slots and filters stand in a shadow, one memory; writing
// a bank's `commit` marks it as pending, which asserts `busy`. Once `apply` is high, that is, filters and trackers are idle, the bank
// is copied to its tracker or filter word by word, `mode` last and only if it was written. All banks pending by then are copied
// before busy is de-asserted; between two of them an access that waits is served.
//
// With motion there are two more banks, for the whole array, and of a slot's registers `mode` alone. The registers that must not
// contradict each other are compared when their bank is to be committed, and the commit is refused if they do.
//
// With CLASSIFY there is one more bank, for the classifier. A commit that enables it is refused until its weights are loaded.
//
// Latency:    7 clocks from the handshake that completes a read to its answer, 9 of a write, 17 of a commit of motion, which compares
//             registers. A bank that is being copied adds EVCOT_BANK_LAST + 4 at most: 36, 38 and 46. An access that arrives together
//             with one of the other kind also waits for that one, and for a second bank: 73 clocks at most, 81 with motion
//             (hw/formal/axi_lite_regs.vh). After reset, accesses wait while the shadow is filled, 32 clocks for each bank and 2. A write of
//             `mask` is refused until the filters are cleared after a reset, since it would be lost.
// Reset:      every register at its reset value; the shadow has the default configuration, with all slots off. core_rst clears the
//             interrupt events, and marks every mode as written.
// Throughput: one access at a time, a read or a write.
// Stall:      an access waits as above, never for an event.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"
`include "evcot_regs.vh"

module axi_lite_regs #(
    parameter N            = 8,    // tracker slots
    parameter X_W          = 9,    // bits of an x address
    parameter Y_W          = 9,    // bits of a y address
    parameter FRAC         = 4,    // fractional bits of a centre
    parameter TICK_W       = 20,   // bits of the ticks in a token
    parameter RADIX_W      = 8,    // bits of a radius register
    parameter NEV_W        = 10,   // bits of N_ev
    parameter TC_W         = 24,   // bits of a timer
    parameter SUP_W        = 16,   // bits of a support count
    parameter ID_W         = 32,   // bits of a track id
    parameter SEQ_W        = 48,   // bits of an event's number
    parameter TIME_W       = 48,   // bits of the tick count
    parameter HAS          = 255,  // filters that are built
    parameter SOURCES      = 1,    // sources that are built, a bit each: EVCOT_SOURCE_*
    parameter SOURCE       = 0,    // the one selected after reset
    parameter TICKS        = 3,    // what a tick may be: see event_sources.v
    parameter TRACKER      = 0,    // EVCOT_TRACKER_*
    parameter WIDTH        = 346,  // pixels of the sensor across
    parameter HEIGHT       = 260,  // pixels of the sensor down
    parameter STAMP_W      = 20,   // bits of a time stamp in a filter's memory
    parameter RECENT_DEPTH = 32,   // events in the FIFO of recent events
    parameter CELL_PX      = 0,    // side of a cell of the filters' memory in pixels
    parameter FIFO_DEPTH   = 256,  // tokens in the input FIFO
    parameter CLASSIFY     = 0,    // the classifier is built
    parameter SLOT_W       = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                core_rst,   // everything but the registers is reset; high with rst, too

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

    // control: docs/registers.md
    output wire                enable,
    output wire                drop,
    output wire                soft_reset,     // one clock
    output wire [2:0]          source_select,
    output wire                clock_time,
    output wire                swap_bytes,
    output wire                swap_halves,
    output wire                active_low,
    output wire                word_serial,
    output wire [19:0]         tick_us,
    output wire [15:0]         prescale_tick,
    output wire [15:0]         prescale_us,
    output wire [15:0]         packet_records,
    output wire [15:0]         packet_wait,
    output wire [31:0]         lfsr_seed,
    output wire [15:0]         lfsr_gap,
    output wire [15:0]         lfsr_x_min,
    output wire [15:0]         lfsr_x_span,
    output wire [15:0]         lfsr_y_min,
    output wire [15:0]         lfsr_y_span,

    // registers of the trackers and filters, written while `apply`
    output wire                busy,           // a commit is pending
    input  wire                apply,          // nothing is under way
    input  wire                cleared,        // the filters' memories have become empty since reset
    input  wire [47:0]         seq,            // number of the next event
    output reg                 cfg_valid,
    output reg  [SLOT_W-1:0]   cfg_slot,
    output reg  [`EVCOT_MREG_W-1:0] cfg_addr,  // as on the port of cot_motion.v; without motion the upper bit is 0
    output reg  [31:0]         cfg_data,
    output reg                 filter_cfg_valid,
    output wire [`EVCOT_FREG_W-1:0] filter_cfg_addr,
    output wire [31:0]         filter_cfg_data,
    output reg                 classifier_cfg_valid,  // with cfg_addr and cfg_data

    // weights of the classifier
    output wire                weight_address_write,
    output wire [11:0]         weight_address_new,
    input  wire [11:0]         weight_address,
    output wire                weight_data_write,
    output wire [17:0]         weight_data_new,
    input  wire [17:0]         weight_data,    // at weight_address
    input  wire                weight_ready,   // for a write
    input  wire [11:0]         weights_loaded,
    input  wire                verdict_lost,   // this clock

    // what is to be read
    input  wire                idle,
    input  wire                open,
    input  wire [15:0]         held,
    input  wire [31:0]         n_events_in,
    input  wire [31:0]         n_events_dropped,
    input  wire [31:0]         n_malformed,
    input  wire [31:0]         n_backward,
    input  wire [31:0]         n_filtered,
    input  wire [31:0]         n_owned,
    input  wire [31:0]         n_passed,
    input  wire [31:0]         n_records,
    input  wire [31:0]         n_stalls,
    input  wire [`EVCOT_IRQ_COMMIT-1:0] happened,  // this clock, in the order of EVCOT_IRQ_*
    output reg                 irq
);

    parameter_check #(.OK(N >= `EVCOT_N_SLOTS_MIN && N <= `EVCOT_N_SLOTS_MAX)) N_must_be_1_to_64 ();
    parameter_check #(.OK(FIFO_DEPTH >= 1 && FIFO_DEPTH <= 65535)) FIFO_DEPTH_must_be_1_to_65535 ();
    parameter_check #(.OK(CLASSIFY == 0 || (CLASSIFY == 1 && TRACKER == `EVCOT_TRACKER_MOTION))) CLASSIFY_must_be_0_or_1_and_needs_cot_motion ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam WORD_W = `EVCOT_CSR_ADDR_W - 2;
    localparam REG_W  = `EVCOT_REG_W;              // bits of a word's number in its bank
    localparam FIND_W = $clog2(`EVCOT_N_SLOTS_MAX);  // bits of a slot's number in an address
    localparam MOTION = (TRACKER == `EVCOT_TRACKER_MOTION) ? 1 : 0;
    localparam BANKS  = N + 1 + 2 * MOTION + CLASSIFY;  // a bank for each slot, one for the filters, two for motion, one for the classifier
    localparam BANK_W = $clog2(BANKS);
    localparam [31:0]       N_32    = N;
    localparam [31:0]       BOXES_32 = N + 1;
    localparam [31:0]       LIVES_32 = N + 2;
    localparam [31:0]       CLASSES_32 = N + 3;
    localparam [BANK_W-1:0] FILTERS = N_32[BANK_W-1:0];
    localparam [BANK_W-1:0] BOXES   = BOXES_32[BANK_W-1:0];  // the bank `motion`
    localparam [BANK_W-1:0] LIVES   = LIVES_32[BANK_W-1:0];  // the bank `tracks`
    localparam [BANK_W-1:0] CLASSES = CLASSES_32[BANK_W-1:0];  // the bank `classifier`
    localparam [FIND_W:0]   SLOTS   = N_32[FIND_W:0];
    localparam [31:0] LAST_X   = WIDTH - 1;
    localparam [31:0] LAST_Y   = HEIGHT - 1;
    localparam [31:0] RECENT   = RECENT_DEPTH - 1;
    localparam [31:0] DEPTH    = FIFO_DEPTH;
    localparam [31:0] MASKS    = (HAS >> `EVCOT_FILTER_MASK) & 1;  // the filter of masked pixels is built

`include "evcot_limits.vh"

    // ---- the bus -----------------------------------------------------------------------------------------------------

    localparam [3:0] FILL   = 4'd0;  // after reset: giving the shadow its first values
    localparam [3:0] IDLE   = 4'd1;  // waiting for an access, or for a bank to copy
    localparam [3:0] FETCH  = 4'd2;  // reading the shadow
    localparam [3:0] LOOK   = 4'd3;  // taking what was read out of the shadow
    localparam [3:0] MERGE  = 4'd4;  // putting the bytes together
    localparam [3:0] WEIGH  = 4'd5;  // a write: comparing the value with its limits
    localparam [3:0] CHECK  = 4'd6;  // a write: judging it, writing it
    localparam [3:0] ANSWER = 4'd7;  // answering
    localparam [3:0] COPY   = 4'd8;  // copying a bank to where it takes effect
    localparam [3:0] RULES  = 4'd9;  // a commit of motion: comparing registers with each other

    reg [3:0] state;
    reg       turns;  // a bank has been copied: an access comes before the next

    wire              request_valid, request_write;
    wire              slverr;  // answer a fault with SLVERR
    wire [WORD_W-1:0] word;
    wire [31:0]       data;
    wire [3:0]        strb;
    reg  [31:0]       result;
    reg               error;

    axi_lite_slave #(
        .ADDR_W(`EVCOT_CSR_ADDR_W)
    ) u_slave (
        .clk           (clk),
        .rst           (rst),
        .s_axil_awvalid(s_axil_awvalid),
        .s_axil_awready(s_axil_awready),
        .s_axil_awaddr (s_axil_awaddr),
        .s_axil_awprot (s_axil_awprot),
        .s_axil_wvalid (s_axil_wvalid),
        .s_axil_wready (s_axil_wready),
        .s_axil_wdata  (s_axil_wdata),
        .s_axil_wstrb  (s_axil_wstrb),
        .s_axil_bvalid (s_axil_bvalid),
        .s_axil_bready (s_axil_bready),
        .s_axil_bresp  (s_axil_bresp),
        .s_axil_arvalid(s_axil_arvalid),
        .s_axil_arready(s_axil_arready),
        .s_axil_araddr (s_axil_araddr),
        .s_axil_arprot (s_axil_arprot),
        .s_axil_rvalid (s_axil_rvalid),
        .s_axil_rready (s_axil_rready),
        .s_axil_rdata  (s_axil_rdata),
        .s_axil_rresp  (s_axil_rresp),
        .request_valid (request_valid),
        .request_write (request_write),
        .request_word  (word),
        .request_data  (data),
        .request_strb  (strb),
        .answer        (state == ANSWER),
        .answer_data   (result),
        .answer_error  (error)
    );

    // ---- which bank, if any ------------------------------------------------------------------------------------------

    localparam [WORD_W+1:0] SLOT_BASE     = `EVCOT_BANK_SLOT;
    localparam [WORD_W+1:0] FILTER_BASE   = `EVCOT_BANK_FILTER;
    localparam [WORD_W+1:0] MOTION_BASE   = `EVCOT_BANK_MOTION;
    localparam [WORD_W+1:0] TRACKS_BASE   = `EVCOT_BANK_TRACKS;
    localparam [WORD_W+1:0] CLASSES_BASE  = `EVCOT_BANK_CLASSIFIER;

    wire [FIND_W:0] in_slots = {1'b0, word[REG_W+:FIND_W]};

    // Banks of every kind have the same number of words, the last of which commits.
    wire [REG_W-1:0] place = word[REG_W-1:0];

    // Both banks of motion as one: the place in them is an address on the port of cot_motion.v.
    wire is_tracks = word[WORD_W-1:REG_W] == TRACKS_BASE[WORD_W+1:REG_W+2];
    wire is_motion = word[WORD_W-1:REG_W] == MOTION_BASE[WORD_W+1:REG_W+2] || is_tracks;
    wire [`EVCOT_MREG_W-1:0] motion_place = {is_tracks, place};

    // Of a slot of cot_motion there is no other register.
    wire of_slot = (MOTION != 0) ? (place == `EVCOT_REG_MODE || place == `EVCOT_BANK_COMMIT) : slot_has(place);

    // From the clock after the access begins.
    reg in_slot, in_filter, in_motion, in_tracks, in_classes, at_commit, at_mask;

    always @(posedge clk) begin
        in_slot   <= word[WORD_W-1:REG_W+FIND_W] == SLOT_BASE[WORD_W+1:REG_W+FIND_W+2] && in_slots < SLOTS && of_slot;
        in_motion <= MOTION != 0 && is_motion && motion_has(motion_place);
        in_tracks <= is_tracks;
        in_classes <= CLASSIFY != 0 && word[WORD_W-1:REG_W] == CLASSES_BASE[WORD_W+1:REG_W+2] && classifier_has(place);
        in_filter <= word[WORD_W-1:REG_W] == FILTER_BASE[WORD_W+1:REG_W+2] && HAS != 0 && filter_has(place);
        at_commit <= place == `EVCOT_BANK_COMMIT;
        at_mask   <= place == `EVCOT_FREG_MASK;
    end

    wire in_bank  = in_slot || in_filter || in_motion || in_classes;
    wire commits  = in_bank && at_commit;
    wire marks    = in_filter && at_mask;
    wire shadowed = in_bank && !commits && !marks;

    wire [BANK_W-1:0] bank = in_classes ? CLASSES : in_filter ? FILTERS : !in_motion ? in_slots[BANK_W-1:0] : in_tracks ? LIVES : BOXES;
    reg  [BANKS-1:0] pending; // by bank
    reg  [N-1:0] mode_new;    // mode was written since it was last copied, or all was reset
    wire [BANKS-1:0] chosen;  // the bank of an access, or the one that is copied
    reg  bank_pending;        // free-running: `pending` of the bank of an access
    reg  off_sensor;          // a pixel to mask lies outside the sensor
    wire locked = ((shadowed || commits) && bank_pending) || (marks && !off_sensor && !cleared);

    // ---- an access ---------------------------------------------------------------------------------------------------

    wire [31:0] lanes = {{8{strb[3]}}, {8{strb[2]}}, {8{strb[1]}}, {8{strb[0]}}};
    reg  [31:0] merged;
    wire [31:0] in_shadow;

    wire        words_known, words_writable, words_clamped, words_refused;
    wire        words_keeps;
    wire [31:0] words_value;
    wire [31:0] stored = (shadowed || commits) ? in_shadow : words_value;

    wire known    = words_known || in_bank;
    wire writable = words_writable || in_bank;
    wire acts     = state == CHECK && strb != 4'd0;

    // Of the register that is read in the shadow, from the ROM; in FILL `high` is its first value.
    wire        exists, refuses;
    wire [LOW_W-1:0] low;
    wire [31:0] high;

    // Free-running: each has had its clock by the time it is asked for.
    reg         over, under;
    reg         fixed;        // the start mode that motion does not have
    reg         contradicts;  // a commit: registers of its bank
    wire [31:0] legal = over ? high : under ? {{(32 - LOW_W) {1'b0}}, low} : merged;

    always @(posedge clk) begin
        over    <= high < merged;
        bank_pending <= |(pending & chosen);
        under   <= merged[31:LOW_W] == {(32 - LOW_W) {1'b0}} && merged[LOW_W-1:0] < low;
        fixed   <= MOTION != 0 && in_slot && !at_commit && merged == {30'd0, `EVCOT_MODE_FIXED};

        off_sensor <= marks && (LAST_X[15:0] < merged[15:0] || LAST_Y[15:0] < {1'b0, merged[30:16]});
    end

    wire fault_unmapped = (acts && !writable) || (state == CHECK && !known) || (state == MERGE && !request_write && !known);
    wire fault_pending  = acts && locked;
    wire off_limits     = shadowed && (over || under);
    reg  enables;  // the shadow of `enable` of the classifier
    wire unloaded       = commits && in_classes && enables && weights_loaded != `EVCOT_WEIGHT_WORDS;
    wire fault_refused  = acts && !locked
                       && (words_refused || off_sensor || fixed || (commits && contradicts) || unloaded || (off_limits && refuses));
    wire fault_clamped  = acts && !locked && (words_clamped || (off_limits && !refuses)) && !fault_refused;
    wire faulty         = fault_unmapped || fault_pending || fault_refused || fault_clamped;
    wire stores         = acts && shadowed && !locked && !fault_refused;

    always @(posedge clk) begin
        if (stores && in_classes && place == `EVCOT_CREG_ENABLE) enables <= legal[0];
        if (rst) enables <= 1'b0;
    end

    // ---- the shadow --------------------------------------------------------------------------------------------------

    // Data read in the clock in which the same word is written is not used. The word of a bank's commit holds the number of
    // the first event after it.
    reg [BANK_W+REG_W-1:0] fill;     // the word whose first value is read in FILL
    reg [BANK_W+REG_W-1:0] filled, written;  // the one before it, and the one before that, which is written
    reg                    filling, writing;  // there is one
    reg [BANK_W-1:0] copied;         // the bank in COPY
    reg [REG_W-1:0]  step;           // the word that is read in COPY: 1 to the last register, then 0
    reg              late, later;    // the word before it has been read, and the one before that has come out
    reg [REG_W-1:0]  late_word, later_word;

    localparam [31:0] LAST_FILL = (BANKS << REG_W) - 1;

    wire fills  = state == FILL;
    wire last   = step == `EVCOT_BANK_LAST;
    wire stamps = state == COPY && last;

    // A commit of motion reads the registers that it compares: of each pair first the one that must not be more.
    reg  [3:0]               compares;  // the one that is read
    wire [3:0]               came     = compares - 4'd2;  // the one that has come
    wire [`EVCOT_MREG_W-1:0] compared = motion_compared(in_tracks, compares[2:0]);
    reg  [31:0]              less;

    // With motion, `mode` and the commit are all words of a slot: the shadow has those of all slots, and behind them the other banks.
    localparam BEHIND_W = REG_W + 2;  // of a word behind the slots, in three banks or four
    localparam SHADOW_W = (MOTION != 0) ? BEHIND_W + 1 : BANK_W + REG_W;

    wire [BANK_W-1:0] to_bank   = fills ? written[REG_W +: BANK_W] : stamps ? copied : bank;
    wire [REG_W-1:0]  to_word   = fills ? written[REG_W-1:0] : stamps ? `EVCOT_BANK_COMMIT : place;
    wire [BANK_W-1:0] from_bank = (state == COPY) ? copied : bank;
    assign chosen = {{(BANKS - 1) {1'b0}}, 1'b1} << from_bank;
    wire [REG_W-1:0]  from_word = (state == COPY) ? step : (state == RULES) ? compared[REG_W-1:0] : place;
    wire [SHADOW_W-1:0] write_to, shadow_from;

    generate
        if (MOTION != 0) begin : g_few
            wire [1:0] to_behind   = to_bank[1:0] - FILTERS[1:0];
            wire [1:0] from_behind = from_bank[1:0] - FILTERS[1:0];
            wire [BEHIND_W-1:0] to_slot   = {{(BEHIND_W - SLOT_W) {1'b0}}, to_bank[SLOT_W-1:0]};
            wire [BEHIND_W-1:0] from_slot = {{(BEHIND_W - SLOT_W) {1'b0}}, from_bank[SLOT_W-1:0]};
            assign write_to    = (to_bank < FILTERS) ? {to_slot, to_word == `EVCOT_BANK_COMMIT} : {1'b1, to_behind, to_word};
            assign shadow_from = (from_bank < FILTERS) ? {from_slot, from_word == `EVCOT_BANK_COMMIT} : {1'b1, from_behind, from_word};
        end else begin : g_all
            assign write_to    = {to_bank, to_word};
            assign shadow_from = {from_bank, from_word};
        end
    endgenerate

    reg                 shadow_write;
    reg  [SHADOW_W-1:0] shadow_to;
    reg  [31:0]         shadow_in;

    always @(posedge clk) begin
        shadow_write <= (fills && writing) || stamps || stores;
        shadow_to    <= write_to;
        shadow_in    <= fills ? high : stamps ? seq[31:0] : legal;
    end

    block_memory #(
        .W    (32),
        .DEPTH((MOTION != 0) ? 1 << SHADOW_W : BANKS << REG_W)
    ) u_shadow (
        .clk          (clk),
        .write        (shadow_write),
        .write_address(shadow_to),
        .write_data   (shadow_in),
        .read_enable  (1'b1),
        .read_address (shadow_from),
        .out_enable   (1'b1),
        .read_data    (in_shadow)
    );

    // ---- limits and first values, in a ROM with the timing of the shadow ---------------------------------------------

    // With motion, a slot has no other word than `mode` and its commit. The words between are those of the classifier. Their first values
    // pass through a slot's `mode` in FILL, before that of the last word of the bank.
    localparam [1:0] SLOT_KIND = 2'd3;
    localparam ENTRY_W = 2 + LOW_W + 32;

    function [ENTRY_W-1:0] entry(input is_first, input [1:0] kind, input [REG_W-1:0] register);
        reg [`EVCOT_MREG_W-1:0] of_motion;
        begin
            of_motion = {kind == 2'd2, register};
            case (kind)
                2'd0: begin
                    entry = {filter_has(register), filter_refuses(register), low_bits(filter_low(register)), filter_high(register)};
                    if (is_first) entry[31:0] = filter_start(register);
                end
                SLOT_KIND: begin
                    entry = {slot_has(register), slot_refuses(register), low_bits(slot_low(register)), slot_high(register)};
                    if (is_first) entry[31:0] = slot_low((MOTION != 0) ? `EVCOT_REG_MODE : register);
                    if (CLASSIFY != 0 && register != `EVCOT_REG_MODE && register != `EVCOT_BANK_COMMIT) begin
                        entry = {classifier_has(register), classifier_refuses(register), low_bits(classifier_low(register)),
                                 classifier_high(register)};
                        if (is_first) entry[31:0] = classifier_start(register);
                    end
                end
                default: begin
                    entry = {motion_has(of_motion), motion_refuses(of_motion), low_bits(motion_low(of_motion)), motion_high(of_motion)};
                    if (is_first) entry[31:0] = motion_start(of_motion);
                end
            endcase
        end
    endfunction

    function [LOW_W-1:0] low_bits(input [31:0] value);
        low_bits = value[LOW_W-1:0] | {LOW_W{|(value >> LOW_W)}};
    endfunction

    reg [ENTRY_W-1:0] entries [0:(8<<REG_W)-1];
    reg [ENTRY_W-1:0] rom_reg, entry_reg;

    integer at;
    initial for (at = 0; at < 8 << REG_W; at = at + 1) entries[at] = entry(at[REG_W+2], at[REG_W +: 2], at[REG_W-1:0]);

    wire [BANK_W-1:0] entry_bank = fills ? fill[REG_W +: BANK_W] : from_bank;
    wire [BANK_W:0]   behind     = {1'b0, entry_bank} - {1'b0, FILTERS};  // filters 0, motion 1 and 2, classifier 3
    wire [1:0]        entry_kind = (entry_bank < FILTERS) ? SLOT_KIND : {MOTION != 0 && behind[1], MOTION != 0 && behind[0]};

    always @(posedge clk) begin
        rom_reg   <= entries[{fills, entry_kind, fills ? fill[REG_W-1:0] : from_word}];
        entry_reg <= rom_reg;
    end

    assign {exists, refuses, low, high} = entry_reg;

    // ---- a bank takes effect -----------------------------------------------------------------------------------------

    reg [BANK_W-1:0] next_bank;

    always @* begin : find_pending
        integer i;
        next_bank = {BANK_W{1'b0}};
        for (i = BANKS - 1; i >= 0; i = i - 1) if (pending[i]) next_bank = i[BANK_W-1:0];
    end

    wire copies_filters = copied == FILTERS;
    wire copies_lives   = MOTION != 0 && copied == LIVES;
    wire copies_motion  = copies_lives || (MOTION != 0 && copied == BOXES);
    wire copies_classes = CLASSIFY != 0 && copied == CLASSES;
    wire copies_slot    = !copies_filters && !copies_motion && !copies_classes;
    wire [`EVCOT_MREG_W-1:0] copied_to = {copies_lives, later_word};
    reg  ends;   // mode has come out, the last word of a bank
    wire copied_all = state == COPY && ends;
    wire sets_pending = acts && commits && !locked && !contradicts && !unloaded;
    wire sets_mode    = stores && in_slot && place == `EVCOT_REG_MODE;
    reg  was_busy, committed;  // of banks that are copied one after the other, the last one

    always @(posedge clk) committed <= was_busy && !busy && !core_rst;

    reg  [47:0] commit_seq;
    reg  [31:0] commit_count;

    assign busy            = |pending;
    assign filter_cfg_addr = cfg_addr[`EVCOT_FREG_W-1:0];
    assign filter_cfg_data = cfg_data;

    // ---- control -----------------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        cfg_valid        <= 1'b0;
        filter_cfg_valid <= 1'b0;
        classifier_cfg_valid <= 1'b0;
        pending          <= (pending | (chosen & {BANKS{sets_pending}})) & ~(chosen & {BANKS{copied_all}});
        mode_new         <= (mode_new | (chosen[N-1:0] & {N{sets_mode}})) & ~(chosen[N-1:0] & {N{copied_all}});

        case (state)
            FILL: begin
                fill    <= fill + 1'b1;
                filled  <= fill;
                written <= filled;
                filling <= 1'b1;
                writing <= filling;
                if (writing && written == LAST_FILL[BANK_W+REG_W-1:0]) state <= IDLE;
            end
            IDLE: begin
                copied <= next_bank;
                step   <= {{(REG_W - 1) {1'b0}}, 1'b1};
                late   <= 1'b0;
                later  <= 1'b0;
                ends   <= 1'b0;
                turns  <= 1'b0;
                if (!core_rst) begin
                    if (apply && |pending && !(turns && request_valid)) state <= COPY;
                    else if (request_valid) state <= FETCH;
                end
            end
            FETCH: begin
                result      <= 32'd0;
                compares    <= 4'd0;
                contradicts <= 1'b0;
                state       <= LOOK;
            end
            LOOK:  state <= MERGE;
            MERGE: begin
                if (known) result <= stored;
                merged <= (data & lanes) | (stored & ~lanes & {32{shadowed || words_keeps}});
                error  <= !known && slverr;
                state  <= !request_write ? ANSWER : (commits && in_motion) ? RULES : WEIGH;
            end
            RULES:
            if (MOTION == 0) state <= IDLE;
            else begin
                compares <= compares + 4'd1;
                if (!came[0]) less <= motion_doubled(in_tracks, came[2:0]) ? {in_shadow[30:0], 1'b0} : in_shadow;
                else if (!came[3] && in_shadow < less) contradicts <= 1'b1;
                if (came == {1'b0, in_tracks ? TRACKS_COMPARED : MOTION_COMPARED}) state <= WEIGH;
            end
            WEIGH: state <= CHECK;
            CHECK: begin
                error <= faulty && slverr;
                if (MASKS != 32'd0 && acts && marks && !locked && !off_sensor) begin
                    filter_cfg_valid <= 1'b1;
                    cfg_addr         <= {1'b0, `EVCOT_FREG_MASK};
                    cfg_data         <= merged;
                end
                state <= ANSWER;
            end
            COPY: begin
                step       <= last ? {REG_W{1'b0}} : step + 1'b1;
                late       <= 1'b1;
                late_word  <= step;
                later      <= late;
                ends       <= late && late_word == `EVCOT_REG_MODE;
                later_word <= late_word;
                cfg_slot   <= copied[SLOT_W-1:0];
                cfg_addr   <= copied_to;
                cfg_data   <= in_shadow;
                if (later) begin
                    cfg_valid        <= copies_motion ? exists
                                      : copies_slot && (MOTION == 0 || later_word == `EVCOT_REG_MODE) && exists
                                        && (later_word != `EVCOT_REG_MODE || |(mode_new & chosen[N-1:0]));
                    filter_cfg_valid <= copies_filters && exists && later_word != `EVCOT_FREG_MASK;
                    classifier_cfg_valid <= copies_classes && exists && later_word != `EVCOT_REG_MODE;
                end
                if (copied_all) begin
                    commit_seq <= seq;
                    turns      <= 1'b1;
                    state      <= IDLE;
                end
            end
            default: state <= IDLE;
        endcase

        was_busy <= busy;
        if (committed) commit_count <= commit_count + 1'b1;

        if (core_rst) begin
            was_busy         <= 1'b0;
            pending          <= {BANKS{1'b0}};
            mode_new         <= {N{1'b1}};
            commit_seq       <= 48'd0;
            commit_count     <= 32'd0;
            cfg_valid        <= 1'b0;
            filter_cfg_valid <= 1'b0;
            classifier_cfg_valid <= 1'b0;
            if (state == COPY) state <= IDLE;
        end
        if (rst) begin
            state  <= FILL;
            fill   <= {(BANK_W + REG_W) {1'b0}};
            {filling, writing} <= 2'b00;
            turns  <= 1'b0;
        end
    end

    // ---- what has happened -------------------------------------------------------------------------------------------

    wire       latch;
    wire [3:0] fault_clear;
    wire       lost_clear;
    reg        lost;  // a verdict
    wire [`EVCOT_IRQ_W-1:0] irq_clear, irq_enable;
    reg  [`EVCOT_IRQ_W-1:0] irq_status;
    reg  [3:0]  fault, faults;  // faults: of the clock before, so that what an access is refused for has a clock of its own
    reg  [`EVCOT_CSR_ADDR_W-1:0] fault_address;
    reg  [31:0] events_in, events_dropped, malformed, events, filtered, owned, passed, records, stalls, backward;

    always @(posedge clk) begin
        irq_status <= (irq_status & ~irq_clear) | {committed, happened};
        irq        <= |(irq_status & irq_enable);
        lost       <= (lost && !lost_clear) || verdict_lost;
        faults     <= {fault_unmapped, fault_pending, fault_refused, fault_clamped};
        fault      <= (fault & ~fault_clear) | faults;
        if (faults != 4'd0) fault_address <= {word, 2'b00};
        if (latch) begin
            events_in      <= n_events_in;
            events_dropped <= n_events_dropped;
            malformed      <= n_malformed;
            events         <= seq[31:0];
            filtered       <= n_filtered;
            owned          <= n_owned;
            passed         <= n_passed;
            records        <= n_records;
            stalls         <= n_stalls;
            backward       <= n_backward;
        end
        if (core_rst) begin
            irq_status <= {`EVCOT_IRQ_W{1'b0}};
            irq        <= 1'b0;
            lost       <= 1'b0;
        end
        if (rst) begin
            {fault, faults} <= 8'd0;
            fault_address <= {`EVCOT_CSR_ADDR_W{1'b0}};
            {events_in, events_dropped, malformed, events, filtered, owned, passed, records, stalls, backward} <= {10 * 32{1'b0}};
        end
    end

    // ---- the words outside the banks ---------------------------------------------------------------------------------

    // A parameter that is given from outside has 32 bits.
    localparam [31:0] HAS_32 = HAS, SOURCES_32 = SOURCES, TICKS_32 = TICKS, TRACKER_32 = TRACKER, FRAC_32 = FRAC, RADIX_W_32 = RADIX_W;
    localparam [31:0] X_W_32 = X_W, Y_W_32 = Y_W, NEV_W_32 = NEV_W, TICK_W_32 = TICK_W, TC_W_32 = TC_W, SUP_W_32 = SUP_W;
    localparam [31:0] ID_W_32 = ID_W, SEQ_W_32 = SEQ_W, TIME_W_32 = TIME_W, STAMP_W_32 = STAMP_W, CELL_PX_32 = CELL_PX;

    axi_lite_words #(
        .X_W    (X_W),
        .Y_W    (Y_W),
        .SOURCE (SOURCE),
        .SOURCES(SOURCES),
        .TICKS  (TICKS),
        .CLASSIFY(CLASSIFY)
    ) u_words (
        .clk                 (clk),
        .rst                 (rst),
        .word                (word),
        .write               (acts && words_known),
        .data                (merged),
        .known               (words_known),
        .writable            (words_writable),
        .value               (words_value),
        .keeps               (words_keeps),
        .clamped             (words_clamped),
        .refused             (words_refused),
        .id                  (`EVCOT_CSR_ID),
        .version_minor       ((CLASSIFY != 0) ? `EVCOT_CSR_MINOR : 16'd0),  // the classifier came with minor 1
        .version_major       (`EVCOT_CSR_MAJOR),
        .shape0_n_slots      (SLOTS),
        .shape0_frac         (FRAC_32[3:0]),
        .shape0_x_w          (X_W_32[4:0]),
        .shape0_y_w          (Y_W_32[4:0]),
        .shape1_tick_w       (TICK_W_32[5:0]),
        .shape1_radix_w      (RADIX_W_32[3:0]),
        .shape1_nev_w        (NEV_W_32[4:0]),
        .shape1_tc_w         (TC_W_32[5:0]),
        .shape2_sup_w        (SUP_W_32[5:0]),
        .shape2_id_w         (ID_W_32[5:0]),
        .shape2_seq_w        (SEQ_W_32[5:0]),
        .shape2_time_w       (TIME_W_32[5:0]),
        .build_filters       (HAS_32[7:0]),
        .build_sources       (SOURCES_32[5:0]),
        .build_ticks         (TICKS_32[1:0]),
        .build_tracker       (TRACKER_32[1:0]),
        .build_classifier    ((CLASSIFY != 0) ? `EVCOT_CLASSIFIER_VERSION : 4'd0),
        .build_cell_px       (CELL_PX_32[2:0]),
        .sensor_last_x       (LAST_X[15:0]),
        .sensor_last_y       (LAST_Y[15:0]),
        .memory_stamp_w      (STAMP_W_32[5:0]),
        .memory_recent_last  (RECENT[7:0]),
        .memory_fifo_depth   (DEPTH[15:0]),
        .control_enable      (enable),
        .control_drop        (drop),
        .control_slverr      (slverr),
        .control_latch       (latch),
        .control_soft_reset  (soft_reset),
        .source_select       (source_select),
        .source_clock_time   (clock_time),
        .source_swap_bytes   (swap_bytes),
        .source_swap_halves  (swap_halves),
        .source_active_low   (active_low),
        .source_word_serial  (word_serial),
        .tick_us             (tick_us),
        .prescale_tick       (prescale_tick),
        .prescale_us         (prescale_us),
        .packet_records      (packet_records),
        .packet_wait         (packet_wait),
        .weight_address      (weight_address),
        .weight_address_ready(1'b1),
        .weight_address_write(weight_address_write),
        .weight_address_new  (weight_address_new),
        .weight_data         (weight_data),
        .weight_data_ready   (weight_ready),
        .weight_data_write   (weight_data_write),
        .weight_data_new     (weight_data_new),
        .weights_loaded      (weights_loaded),
        .weights_needed      (`EVCOT_WEIGHT_WORDS),
        .verdicts_lost       (lost),
        .verdicts_lost_clear (lost_clear),
        .lfsr_seed           (lfsr_seed),
        .lfsr_gap            (lfsr_gap),
        .lfsr_x_min          (lfsr_x_min),
        .lfsr_x_span         (lfsr_x_span),
        .lfsr_y_min          (lfsr_y_min),
        .lfsr_y_span         (lfsr_y_span),
        .status_idle         (idle && !busy),
        .status_pending      (busy),
        .status_open         (open),
        .status_cleared      (cleared),
        .status_held         (held),
        .fault_clamped       (fault[0]),
        .fault_clamped_clear (fault_clear[0]),
        .fault_refused       (fault[1]),
        .fault_refused_clear (fault_clear[1]),
        .fault_pending       (fault[2]),
        .fault_pending_clear (fault_clear[2]),
        .fault_unmapped      (fault[3]),
        .fault_unmapped_clear(fault_clear[3]),
        .fault_address       (fault_address),
        .irq_status_birth    (irq_status[`EVCOT_IRQ_BIRTH]),
        .irq_status_loss     (irq_status[`EVCOT_IRQ_LOSS]),
        .irq_status_merge    (irq_status[`EVCOT_IRQ_MERGE]),
        .irq_status_overflow (irq_status[`EVCOT_IRQ_OVERFLOW]),
        .irq_status_commit   (irq_status[`EVCOT_IRQ_COMMIT]),
        .irq_enable          (irq_enable),
        .irq_clear           (irq_clear),
        .commit_seq_low      (commit_seq[31:0]),
        .commit_seq_high     (commit_seq[47:32]),
        .commits             (commit_count),
        .events_in           (events_in),
        .events_dropped      (events_dropped),
        .malformed           (malformed),
        .events              (events),
        .filtered            (filtered),
        .owned               (owned),
        .passed              (passed),
        .records             (records),
        .stalls              (stalls),
        .backward            (backward)
    );

    wire unused = &{1'b0, LAST_X, LAST_Y, RECENT, DEPTH, SLOT_BASE, FILTER_BASE, MOTION_BASE, TRACKS_BASE, CLASSES_BASE, BOXES, LIVES, CLASSES, compared, came,
                     in_slots, behind};

endmodule

`default_nettype wire
