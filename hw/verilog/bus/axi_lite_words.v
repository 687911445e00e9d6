// SPDX-License-Identifier: Apache-2.0
// The words of evcot_top.v outside the banks: one port for each field, and what an access to each address does.
// Generated from sw/evcot/hardware/registers.toml by `python -m evcot.hardware.generate`: edit there.
//
// Two clocks after `word` (an address without its two low bits) `known`, `writable`, `value` and `keeps` are valid. With `keeps`, a
// write of single bytes must preserve the others of the value, else they are 0. A clock after `data`, `refused` is valid, and
// `clamped`, which is high if a field was out of range. `write` may be asserted from then on, with word and data unchanged: data takes
// effect at the next clock, unless refused. A pulse lasts one clock.
// A value that other hardware holds leaves as <name>_new with <name>_write, unless <name>_ready is low: then the write is refused.
//
// Latency:    2 clocks from word to value, 1 from data to refused and clamped, 1 from write to its field.
// Throughput: an access at a time.
// Stall:      none.
// Reset:      every field gets its reset value.
// Combinational paths: none.
`default_nettype none

module axi_lite_words #(
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter SOURCE  = 0,   // the source after reset
    parameter SOURCES = 1,   // a bit for each source that was built
    parameter TICKS   = 3,   // what a tick may be: see event_sources.v
    parameter CLASSIFY = 0   // the classifier is built
) (
    input  wire        clk,
    input  wire        rst,

    input  wire [11:0] word,
    input  wire        write,
    input  wire [31:0] data,
    output reg         known,
    output reg         writable,
    output reg  [31:0] value,
    output reg         keeps,
    output wire        clamped,
    output wire        refused,

    // 000: the letters EVCT
    input  wire [31:0] id,

    // 004: version of this map
    input  wire [15:0] version_minor,
    input  wire [15:0] version_major,

    // 008: shape of the trackers
    input  wire [6:0]  shape0_n_slots,
    input  wire [3:0]  shape0_frac,
    input  wire [4:0]  shape0_x_w,
    input  wire [4:0]  shape0_y_w,

    // 00c: shape of the trackers
    input  wire [5:0]  shape1_tick_w,
    input  wire [3:0]  shape1_radix_w,
    input  wire [4:0]  shape1_nev_w,
    input  wire [5:0]  shape1_tc_w,

    // 010: shape of the trackers
    input  wire [5:0]  shape2_sup_w,
    input  wire [5:0]  shape2_id_w,
    input  wire [5:0]  shape2_seq_w,
    input  wire [5:0]  shape2_time_w,

    // 014: build options of the hardware
    input  wire [7:0]  build_filters,
    input  wire [5:0]  build_sources,
    input  wire [1:0]  build_ticks,
    input  wire [1:0]  build_tracker,
    input  wire [3:0]  build_classifier,
    input  wire [2:0]  build_cell_px,

    // 018: size of the sensor
    input  wire [15:0] sensor_last_x,
    input  wire [15:0] sensor_last_y,

    // 01c: memories
    input  wire [5:0]  memory_stamp_w,
    input  wire [7:0]  memory_recent_last,
    input  wire [15:0] memory_fifo_depth,

    // 020: control
    output reg         control_enable,
    output reg         control_drop,
    output reg         control_slverr,
    output reg         control_latch,
    output reg         control_soft_reset,

    // 024: source of events; takes effect with `soft_reset`
    output reg  [2:0]  source_select,
    output reg         source_clock_time,
    output reg         source_swap_bytes,
    output reg         source_swap_halves,
    output reg         source_active_low,
    output reg         source_word_serial,

    // 028: length of a tick of the events' own time; takes effect with `soft_reset`
    output reg  [19:0] tick_us,

    // 02c: length of a tick and of a microsecond in clocks; takes effect with `soft_reset`
    output reg  [15:0] prescale_tick,
    output reg  [15:0] prescale_us,

    // 030: self-test source: seed; takes effect with `soft_reset`
    output reg  [31:0] lfsr_seed,

    // 034: self-test source: distance of events
    output reg  [15:0] lfsr_gap,

    // 038: self-test source: columns
    output reg  [15:0] lfsr_x_min,
    output reg  [15:0] lfsr_x_span,

    // 03c: self-test source: rows
    output reg  [15:0] lfsr_y_min,
    output reg  [15:0] lfsr_y_span,

    // 040: state of the hardware
    input  wire        status_idle,
    input  wire        status_pending,
    input  wire        status_open,
    input  wire        status_cleared,
    input  wire [15:0] status_held,

    // 044: accesses that were clamped or refused
    input  wire        fault_clamped,
    output reg         fault_clamped_clear,
    input  wire        fault_refused,
    output reg         fault_refused_clear,
    input  wire        fault_pending,
    output reg         fault_pending_clear,
    input  wire        fault_unmapped,
    output reg         fault_unmapped_clear,
    input  wire [13:0] fault_address,

    // 048: interrupt events since they were last cleared
    input  wire        irq_status_birth,
    input  wire        irq_status_loss,
    input  wire        irq_status_merge,
    input  wire        irq_status_overflow,
    input  wire        irq_status_commit,

    // 04c: interrupt events that assert `irq`
    output reg  [4:0]  irq_enable,

    // 050: writing 1 clears a bit of `irq_status`
    output reg  [4:0]  irq_clear,

    // 054: number of the first event after the last commit
    input  wire [31:0] commit_seq_low,

    // 058: number of the first event after the last commit
    input  wire [15:0] commit_seq_high,

    // 05c: commits applied since reset
    input  wire [31:0] commits,

    // 060: packets of `m_axis_records`: where tlast is 1
    output reg  [15:0] packet_records,
    output reg  [15:0] packet_wait,

    // 064: the word of the classifier's weights that `weight_data` reads and writes
    input  wire [11:0] weight_address,
    input  wire        weight_address_ready,
    output reg         weight_address_write,
    output reg  [11:0] weight_address_new,

    // 068: a word of the classifier's weights
    input  wire [17:0] weight_data,
    input  wire        weight_data_ready,
    output reg         weight_data_write,
    output reg  [17:0] weight_data_new,

    // 06c: words of the classifier's weights
    input  wire [11:0] weights_loaded,
    input  wire [11:0] weights_needed,

    // 070: verdicts of the classifier
    input  wire        verdicts_lost,
    output reg         verdicts_lost_clear,

    // 080: events received from the source: = events_dropped + events + those in the input FIFO
    input  wire [31:0] events_in,

    // 084: events dropped because the input FIFO was full
    input  wire [31:0] events_dropped,

    // 088: input words that were skipped, and events outside the sensor
    input  wire [31:0] malformed,

    // 08c: events that entered filters and trackers: = filtered + owned + passed, when idle
    input  wire [31:0] events,

    // 090: events dropped by a filter
    input  wire [31:0] filtered,

    // 094: events owned by a slot
    input  wire [31:0] owned,

    // 098: events without an owner
    input  wire [31:0] passed,

    // 09c: records
    input  wire [31:0] records,

    // 0a0: clocks in which a token waited for filters, trackers, outputs or a commit, while enabled
    input  wire [31:0] stalls,

    // 0a4: events with an earlier time than a previous one, which get the latest time instead; many indicate a damaged time mark
    input  wire [31:0] backward
);

    parameter_check #(.OK(((SOURCES >> SOURCE) & 1) == 1)) SOURCE_must_be_one_of_SOURCES ();

    localparam [31:0] SOURCES_32 = SOURCES, TICKS_32 = TICKS;

    // ---- address decoding --------------------------------------------------------------------------------------------

    reg at_control;
    reg at_source;
    reg at_tick_us;
    reg at_prescale;
    reg at_lfsr_seed;
    reg at_lfsr_gap;
    reg at_lfsr_x;
    reg at_lfsr_y;
    reg at_status;
    reg at_fault;
    reg at_irq_status;
    reg at_irq_enable;
    reg at_irq_clear;
    reg at_commit_seq_low;
    reg at_commit_seq_high;
    reg at_commits;
    reg at_packet;
    reg at_weight_address;
    reg at_weight_data;
    reg at_weights;
    reg at_verdicts;
    reg at_events_in;
    reg at_events_dropped;
    reg at_malformed;
    reg at_events;
    reg at_filtered;
    reg at_owned;
    reg at_passed;
    reg at_records;
    reg at_stalls;
    reg at_backward;

    always @(posedge clk) begin
        at_control <= word == 12'h008;
        at_source <= word == 12'h009;
        at_tick_us <= (TICKS_32[0]) && word == 12'h00a;
        at_prescale <= (TICKS_32[1] || SOURCES_32[2]) && word == 12'h00b;
        at_lfsr_seed <= (SOURCES_32[1]) && word == 12'h00c;
        at_lfsr_gap <= (SOURCES_32[1]) && word == 12'h00d;
        at_lfsr_x <= (SOURCES_32[1]) && word == 12'h00e;
        at_lfsr_y <= (SOURCES_32[1]) && word == 12'h00f;
        at_status <= word == 12'h010;
        at_fault <= word == 12'h011;
        at_irq_status <= word == 12'h012;
        at_irq_enable <= word == 12'h013;
        at_irq_clear <= word == 12'h014;
        at_commit_seq_low <= word == 12'h015;
        at_commit_seq_high <= word == 12'h016;
        at_commits <= word == 12'h017;
        at_packet <= word == 12'h018;
        at_weight_address <= (CLASSIFY != 0) && word == 12'h019;
        at_weight_data <= (CLASSIFY != 0) && word == 12'h01a;
        at_weights <= (CLASSIFY != 0) && word == 12'h01b;
        at_verdicts <= (CLASSIFY != 0) && word == 12'h01c;
        at_events_in <= word == 12'h020;
        at_events_dropped <= word == 12'h021;
        at_malformed <= word == 12'h022;
        at_events <= word == 12'h023;
        at_filtered <= word == 12'h024;
        at_owned <= word == 12'h025;
        at_passed <= word == 12'h026;
        at_records <= word == 12'h027;
        at_stalls <= word == 12'h028;
        at_backward <= word == 12'h029;
    end

    // ---- legal values ------------------------------------------------------------------------------------------------

    wire [2:0]  new_source_select = data[2:0];
    localparam [31:0] ALLOWED_SOURCE_SELECT = SOURCES;
    reg bad_source_select;
    wire        new_source_clock_time = data[8:8];
    localparam [31:0] ALLOWED_SOURCE_CLOCK_TIME = TICKS_32[1] ? 3 : 1;
    reg bad_source_clock_time;
    wire [19:0] new_tick_us = data[19:0];
    localparam [19:0] TOP_TICK_US = 20'd1000000;
    wire        more_tick_us = data > {12'd0, TOP_TICK_US};
    reg over_tick_us;
    reg under_tick_us;
    wire [15:0] new_prescale_tick = data[15:0];
    reg under_prescale_tick;
    wire [15:0] new_prescale_us = data[31:16];
    reg under_prescale_us;
    wire [31:0] new_lfsr_seed = data[31:0];
    localparam [31:0] TOP_LFSR_SEED = 32'd4294967294;
    wire        more_lfsr_seed = {1'b0, new_lfsr_seed} > {1'b0, TOP_LFSR_SEED};
    reg over_lfsr_seed;
    wire [15:0] new_lfsr_gap = data[15:0];
    wire        wide_lfsr_gap = |data[31:16];
    localparam [15:0] TOP_LFSR_GAP = 16'd65535;
    reg over_lfsr_gap;
    wire [15:0] new_lfsr_x_min = data[15:0];
    localparam [15:0] TOP_LFSR_X_MIN = {16{1'b1}} >> (16 - X_W);
    wire        more_lfsr_x_min = {1'b0, new_lfsr_x_min} > {1'b0, TOP_LFSR_X_MIN};
    reg over_lfsr_x_min;
    wire [15:0] new_lfsr_x_span = data[31:16];
    localparam [15:0] TOP_LFSR_X_SPAN = {16{1'b1}} >> (16 - X_W);
    wire        more_lfsr_x_span = {1'b0, new_lfsr_x_span} > {1'b0, TOP_LFSR_X_SPAN};
    reg over_lfsr_x_span;
    wire [15:0] new_lfsr_y_min = data[15:0];
    localparam [15:0] TOP_LFSR_Y_MIN = {16{1'b1}} >> (16 - Y_W);
    wire        more_lfsr_y_min = {1'b0, new_lfsr_y_min} > {1'b0, TOP_LFSR_Y_MIN};
    reg over_lfsr_y_min;
    wire [15:0] new_lfsr_y_span = data[31:16];
    localparam [15:0] TOP_LFSR_Y_SPAN = {16{1'b1}} >> (16 - Y_W);
    wire        more_lfsr_y_span = {1'b0, new_lfsr_y_span} > {1'b0, TOP_LFSR_Y_SPAN};
    reg over_lfsr_y_span;
    wire [15:0] new_packet_records = data[15:0];
    reg under_packet_records;
    wire [11:0] new_weight_address = data[11:0];
    localparam [11:0] TOP_WEIGHT_ADDRESS = 12'd2735;
    wire        more_weight_address = data > {20'd0, TOP_WEIGHT_ADDRESS};
    reg bad_weight_address;
    reg over_weight_address;
    wire [17:0] new_weight_data = data[17:0];
    wire        wide_weight_data = |data[31:18];
    localparam [17:0] TOP_WEIGHT_DATA = 18'd262143;
    reg bad_weight_data;
    reg over_weight_data;

    always @(posedge clk) begin
        bad_source_select <= at_source && !ALLOWED_SOURCE_SELECT[{2'd0, new_source_select}];
        bad_source_clock_time <= at_source && !ALLOWED_SOURCE_CLOCK_TIME[{4'd0, new_source_clock_time}];
        over_tick_us <= at_tick_us && more_tick_us;
        under_tick_us <= at_tick_us && data == 32'd0;
        under_prescale_tick <= at_prescale && new_prescale_tick == 16'd0;
        under_prescale_us <= at_prescale && new_prescale_us == 16'd0;
        over_lfsr_seed <= at_lfsr_seed && more_lfsr_seed;
        over_lfsr_gap <= at_lfsr_gap && wide_lfsr_gap;
        over_lfsr_x_min <= at_lfsr_x && more_lfsr_x_min;
        over_lfsr_x_span <= at_lfsr_x && more_lfsr_x_span;
        over_lfsr_y_min <= at_lfsr_y && more_lfsr_y_min;
        over_lfsr_y_span <= at_lfsr_y && more_lfsr_y_span;
        under_packet_records <= at_packet && new_packet_records == 16'd0;
        bad_weight_address <= at_weight_address && !weight_address_ready;
        over_weight_address <= at_weight_address && more_weight_address;
        bad_weight_data <= at_weight_data && !weight_data_ready;
        over_weight_data <= at_weight_data && wide_weight_data;
    end

    assign refused = bad_source_select || bad_source_clock_time || bad_weight_address || bad_weight_data;
    assign clamped = over_tick_us ||
                     under_tick_us ||
                     under_prescale_tick ||
                     under_prescale_us ||
                     over_lfsr_seed ||
                     over_lfsr_gap ||
                     over_lfsr_x_min ||
                     over_lfsr_x_span ||
                     over_lfsr_y_min ||
                     over_lfsr_y_span ||
                     under_packet_records ||
                     over_weight_address ||
                     over_weight_data;

    // ---- read data ---------------------------------------------------------------------------------------------------

    // Words of parameters alone are a table; the others have a wire each for their address.
    reg [31:0] table_reg, held;
    reg        at_table;

    always @(posedge clk) begin
        at_table  <= word < 12'd8;
        table_reg <= 32'd0;
        if (word < 12'd8) case (word[2:0])
            3'd0: begin
                table_reg[31:0] <= id;
            end
            3'd1: begin
                table_reg[15:0] <= version_minor;
                table_reg[31:16] <= version_major;
            end
            3'd2: begin
                table_reg[6:0] <= shape0_n_slots;
                table_reg[11:8] <= shape0_frac;
                table_reg[20:16] <= shape0_x_w;
                table_reg[28:24] <= shape0_y_w;
            end
            3'd3: begin
                table_reg[5:0] <= shape1_tick_w;
                table_reg[11:8] <= shape1_radix_w;
                table_reg[20:16] <= shape1_nev_w;
                table_reg[29:24] <= shape1_tc_w;
            end
            3'd4: begin
                table_reg[5:0] <= shape2_sup_w;
                table_reg[13:8] <= shape2_id_w;
                table_reg[21:16] <= shape2_seq_w;
                table_reg[29:24] <= shape2_time_w;
            end
            3'd5: begin
                table_reg[7:0] <= build_filters;
                table_reg[13:8] <= build_sources;
                table_reg[15:14] <= build_ticks;
                table_reg[17:16] <= build_tracker;
                if (CLASSIFY != 0) table_reg[23:20] <= build_classifier;
                table_reg[26:24] <= build_cell_px;
            end
            3'd6: begin
                table_reg[15:0] <= sensor_last_x;
                table_reg[31:16] <= sensor_last_y;
            end
            3'd7: begin
                table_reg[5:0] <= memory_stamp_w;
                table_reg[15:8] <= memory_recent_last;
                table_reg[31:16] <= memory_fifo_depth;
            end
        endcase
    end

    always @* begin
        held = table_reg;  // 0 elsewhere
        held[0:0] = held[0:0] | ({1{at_control}} & control_enable);
        held[1:1] = held[1:1] | ({1{at_control}} & control_drop);
        held[2:2] = held[2:2] | ({1{at_control}} & control_slverr);
        held[2:0] = held[2:0] | ({3{at_source}} & source_select);
        held[8:8] = held[8:8] | ({1{at_source}} & source_clock_time);
        held[16:16] = held[16:16] | ({1{at_source}} & source_swap_bytes);
        held[17:17] = held[17:17] | ({1{at_source}} & source_swap_halves);
        held[24:24] = held[24:24] | ({1{at_source}} & source_active_low);
        held[25:25] = held[25:25] | ({1{at_source}} & source_word_serial);
        held[19:0] = held[19:0] | ({20{at_tick_us}} & tick_us);
        held[15:0] = held[15:0] | ({16{at_prescale}} & prescale_tick);
        held[31:16] = held[31:16] | ({16{at_prescale}} & prescale_us);
        held[31:0] = held[31:0] | ({32{at_lfsr_seed}} & lfsr_seed);
        held[15:0] = held[15:0] | ({16{at_lfsr_gap}} & lfsr_gap);
        held[15:0] = held[15:0] | ({16{at_lfsr_x}} & lfsr_x_min);
        held[31:16] = held[31:16] | ({16{at_lfsr_x}} & lfsr_x_span);
        held[15:0] = held[15:0] | ({16{at_lfsr_y}} & lfsr_y_min);
        held[31:16] = held[31:16] | ({16{at_lfsr_y}} & lfsr_y_span);
        held[0:0] = held[0:0] | ({1{at_status}} & status_idle);
        held[1:1] = held[1:1] | ({1{at_status}} & status_pending);
        held[2:2] = held[2:2] | ({1{at_status}} & status_open);
        held[3:3] = held[3:3] | ({1{at_status}} & status_cleared);
        held[31:16] = held[31:16] | ({16{at_status}} & status_held);
        held[0:0] = held[0:0] | ({1{at_fault}} & fault_clamped);
        held[1:1] = held[1:1] | ({1{at_fault}} & fault_refused);
        held[2:2] = held[2:2] | ({1{at_fault}} & fault_pending);
        held[3:3] = held[3:3] | ({1{at_fault}} & fault_unmapped);
        held[29:16] = held[29:16] | ({14{at_fault}} & fault_address);
        held[0:0] = held[0:0] | ({1{at_irq_status}} & irq_status_birth);
        held[1:1] = held[1:1] | ({1{at_irq_status}} & irq_status_loss);
        held[2:2] = held[2:2] | ({1{at_irq_status}} & irq_status_merge);
        held[3:3] = held[3:3] | ({1{at_irq_status}} & irq_status_overflow);
        held[4:4] = held[4:4] | ({1{at_irq_status}} & irq_status_commit);
        held[4:0] = held[4:0] | ({5{at_irq_enable}} & irq_enable);
        held[31:0] = held[31:0] | ({32{at_commit_seq_low}} & commit_seq_low);
        held[15:0] = held[15:0] | ({16{at_commit_seq_high}} & commit_seq_high);
        held[31:0] = held[31:0] | ({32{at_commits}} & commits);
        held[15:0] = held[15:0] | ({16{at_packet}} & packet_records);
        held[31:16] = held[31:16] | ({16{at_packet}} & packet_wait);
        held[11:0] = held[11:0] | ({12{at_weight_address}} & weight_address);
        held[17:0] = held[17:0] | ({18{at_weight_data}} & weight_data);
        held[11:0] = held[11:0] | ({12{at_weights}} & weights_loaded);
        held[27:16] = held[27:16] | ({12{at_weights}} & weights_needed);
        held[0:0] = held[0:0] | ({1{at_verdicts}} & verdicts_lost);
        held[31:0] = held[31:0] | ({32{at_events_in}} & events_in);
        held[31:0] = held[31:0] | ({32{at_events_dropped}} & events_dropped);
        held[31:0] = held[31:0] | ({32{at_malformed}} & malformed);
        held[31:0] = held[31:0] | ({32{at_events}} & events);
        held[31:0] = held[31:0] | ({32{at_filtered}} & filtered);
        held[31:0] = held[31:0] | ({32{at_owned}} & owned);
        held[31:0] = held[31:0] | ({32{at_passed}} & passed);
        held[31:0] = held[31:0] | ({32{at_records}} & records);
        held[31:0] = held[31:0] | ({32{at_stalls}} & stalls);
        held[31:0] = held[31:0] | ({32{at_backward}} & backward);
    end

    always @(posedge clk) begin
        value    <= held;
        keeps    <= !(at_fault || at_irq_clear || at_verdicts);
        known    <= at_table ||
                    at_control ||
                    at_source ||
                    at_tick_us ||
                    at_prescale ||
                    at_lfsr_seed ||
                    at_lfsr_gap ||
                    at_lfsr_x ||
                    at_lfsr_y ||
                    at_status ||
                    at_fault ||
                    at_irq_status ||
                    at_irq_enable ||
                    at_irq_clear ||
                    at_commit_seq_low ||
                    at_commit_seq_high ||
                    at_commits ||
                    at_packet ||
                    at_weight_address ||
                    at_weight_data ||
                    at_weights ||
                    at_verdicts ||
                    at_events_in ||
                    at_events_dropped ||
                    at_malformed ||
                    at_events ||
                    at_filtered ||
                    at_owned ||
                    at_passed ||
                    at_records ||
                    at_stalls ||
                    at_backward;
        writable <= at_control ||
                    at_source ||
                    at_tick_us ||
                    at_prescale ||
                    at_lfsr_seed ||
                    at_lfsr_gap ||
                    at_lfsr_x ||
                    at_lfsr_y ||
                    at_fault ||
                    at_irq_enable ||
                    at_irq_clear ||
                    at_packet ||
                    at_weight_address ||
                    at_weight_data ||
                    at_verdicts;
    end

    // ---- writes ------------------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        control_latch <= 1'd0;
        control_soft_reset <= 1'd0;
        fault_clamped_clear <= 1'd0;
        fault_refused_clear <= 1'd0;
        fault_pending_clear <= 1'd0;
        fault_unmapped_clear <= 1'd0;
        irq_clear <= 5'd0;
        weight_address_write <= 1'b0;
        weight_data_write <= 1'b0;
        verdicts_lost_clear <= 1'd0;
        if (write && !refused) begin
            if (at_control) begin
                control_enable <= data[0:0];
                control_drop <= data[1:1];
                control_slverr <= data[2:2];
                control_latch <= data[8:8];
                control_soft_reset <= data[9:9];
            end
            if (at_source) begin
                source_select <= data[2:0];
                source_clock_time <= data[8:8];
                source_swap_bytes <= data[16:16];
                source_swap_halves <= data[17:17];
                source_active_low <= data[24:24];
                source_word_serial <= data[25:25];
            end
            if (at_tick_us) begin
                tick_us <= under_tick_us ? 20'd1 : over_tick_us ? TOP_TICK_US : new_tick_us;
            end
            if (at_prescale) begin
                prescale_tick <= under_prescale_tick ? 16'd1 : new_prescale_tick;
                prescale_us <= under_prescale_us ? 16'd1 : new_prescale_us;
            end
            if (at_lfsr_seed) begin
                lfsr_seed <= over_lfsr_seed ? TOP_LFSR_SEED : new_lfsr_seed;
            end
            if (at_lfsr_gap) begin
                lfsr_gap <= over_lfsr_gap ? TOP_LFSR_GAP : new_lfsr_gap;
            end
            if (at_lfsr_x) begin
                lfsr_x_min <= over_lfsr_x_min ? TOP_LFSR_X_MIN : new_lfsr_x_min;
                lfsr_x_span <= over_lfsr_x_span ? TOP_LFSR_X_SPAN : new_lfsr_x_span;
            end
            if (at_lfsr_y) begin
                lfsr_y_min <= over_lfsr_y_min ? TOP_LFSR_Y_MIN : new_lfsr_y_min;
                lfsr_y_span <= over_lfsr_y_span ? TOP_LFSR_Y_SPAN : new_lfsr_y_span;
            end
            if (at_fault) begin
                fault_clamped_clear <= data[0:0];
                fault_refused_clear <= data[1:1];
                fault_pending_clear <= data[2:2];
                fault_unmapped_clear <= data[3:3];
            end
            if (at_irq_enable) begin
                irq_enable <= data[4:0];
            end
            if (at_irq_clear) begin
                irq_clear <= data[4:0];
            end
            if (at_packet) begin
                packet_records <= under_packet_records ? 16'd1 : new_packet_records;
                packet_wait <= data[31:16];
            end
            if (at_weight_address) begin
                weight_address_write <= 1'b1;
                weight_address_new <= over_weight_address ? TOP_WEIGHT_ADDRESS : new_weight_address;
            end
            if (at_weight_data) begin
                weight_data_write <= 1'b1;
                weight_data_new <= over_weight_data ? TOP_WEIGHT_DATA : new_weight_data;
            end
            if (at_verdicts) begin
                verdicts_lost_clear <= data[0:0];
            end
        end
        if (rst) begin
            control_enable <= 1'd0;
            control_drop <= 1'd0;
            control_slverr <= 1'd0;
            control_latch <= 1'd0;
            control_soft_reset <= 1'd0;
            source_select <= SOURCE[2:0];
            source_clock_time <= 1'd0;
            source_swap_bytes <= 1'd0;
            source_swap_halves <= 1'd0;
            source_active_low <= 1'd1;
            source_word_serial <= 1'd0;
            tick_us <= 20'd1;
            prescale_tick <= 16'd100;
            prescale_us <= 16'd100;
            lfsr_seed <= 32'd0;
            lfsr_gap <= 16'd0;
            lfsr_x_min <= 16'd0;
            lfsr_x_span <= 16'd0;
            lfsr_y_min <= 16'd0;
            lfsr_y_span <= 16'd0;
            fault_clamped_clear <= 1'd0;
            fault_refused_clear <= 1'd0;
            fault_pending_clear <= 1'd0;
            fault_unmapped_clear <= 1'd0;
            irq_enable <= 5'd0;
            irq_clear <= 5'd0;
            packet_records <= 16'd1;
            packet_wait <= 16'd0;
            verdicts_lost_clear <= 1'd0;
        end
    end

endmodule

`default_nettype wire
