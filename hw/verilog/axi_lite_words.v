// SPDX-License-Identifier: Apache-2.0
// The words of evcot_top.v outside the banks: one port for each field, and what an access to each address does.
// Generated from sw/evcot/registers.toml by `python -m evcot.generate`: edit there.
//
// An access is combinational but for its effect: `word` (an address without its two low bits) gives `known`, `writable`,
// `value`, and `kept`, the bits that a byte-wise write of the others must give back. With `write`, `data` takes effect at the
// next clock, unless `refused`; fields that it clamps say so in `clamped`. A pulse lasts one clock.
// Reset gives every field its reset value.
`default_nettype none

module axi_lite_words #(
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter SOURCE  = 0,   // the source after reset
    parameter SOURCES = 1    // a bit for each source that was built
) (
    input  wire        clk,
    input  wire        rst,

    input  wire [10:0] word,
    input  wire        write,
    input  wire [31:0] data,
    output reg         known,
    output reg         writable,
    output reg  [31:0] value,
    output reg  [31:0] kept,
    output reg         clamped,
    output reg         refused,

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

    // 014: what was built
    input  wire [6:0]  build_filters,
    input  wire [5:0]  build_sources,
    input  wire [1:0]  build_tracker,

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
    output reg         control_latch,
    output reg         control_soft_reset,

    // 024: where events come from; takes effect with `soft_reset`
    output reg  [2:0]  source_select,
    output reg         source_clock_time,
    output reg         source_swap_bytes,
    output reg         source_swap_halves,
    output reg         source_active_low,
    output reg         source_word_serial,

    // 028: length of a tick of the events' own time; takes effect with `soft_reset`
    output reg  [19:0] tick_us,

    // 02c: length of a tick, and of a microsecond, of the clock; takes effect with `soft_reset`
    output reg  [15:0] prescale_tick,
    output reg  [15:0] prescale_us,

    // 030: self-test source: seed; takes effect with `soft_reset`
    output reg  [31:0] lfsr_seed,

    // 034: self-test source: how dense
    output reg  [15:0] lfsr_gap,

    // 038: self-test source: columns
    output reg  [15:0] lfsr_x_min,
    output reg  [15:0] lfsr_x_span,

    // 03c: self-test source: rows
    output reg  [15:0] lfsr_y_min,
    output reg  [15:0] lfsr_y_span,

    // 040: how it stands
    input  wire        status_idle,
    input  wire        status_pending,
    input  wire        status_open,
    input  wire [15:0] status_held,

    // 044: writes that did not do what they said
    input  wire        fault_clamped,
    output reg         fault_clamped_clear,
    input  wire        fault_refused,
    output reg         fault_refused_clear,
    input  wire        fault_pending,
    output reg         fault_pending_clear,
    input  wire        fault_unmapped,
    output reg         fault_unmapped_clear,
    input  wire [12:0] fault_address,

    // 048: what has happened since it was cleared
    input  wire        irq_status_birth,
    input  wire        irq_status_loss,
    input  wire        irq_status_merge,
    input  wire        irq_status_overflow,
    input  wire        irq_status_commit,

    // 04c: which of them raise `irq`
    output reg  [4:0]  irq_enable,

    // 050: clears what is written as 1
    output reg  [4:0]  irq_clear,

    // 054: number of the first event after the last commit
    input  wire [31:0] commit_seq_low,

    // 058: number of the first event after the last commit
    input  wire [15:0] commit_seq_high,

    // 05c: commits applied since reset
    input  wire [31:0] commits,

    // 080: events that came from the source: = events_dropped + events + those in the input FIFO
    input  wire [31:0] events_in,

    // 084: events that found the input FIFO full
    input  wire [31:0] events_dropped,

    // 088: input words that were skipped, and events outside the sensor
    input  wire [31:0] malformed,

    // 08c: events that entered filters and trackers: = filtered + owned + passed, when idle
    input  wire [31:0] events,

    // 090: events that a filter took out
    input  wire [31:0] filtered,

    // 094: events that a slot took
    input  wire [31:0] owned,

    // 098: events that no slot took
    input  wire [31:0] passed,

    // 09c: records
    input  wire [31:0] records,

    // 0a0: clocks in which a token waited for filters, trackers, outputs or a commit
    input  wire [31:0] stalls
);

    parameter_check #(.OK(((SOURCES >> SOURCE) & 1) == 1)) SOURCE_must_be_one_of_SOURCES ();

    // ---- legal values ------------------------------------------------------------------------------------------------

    wire [2:0]  new_source_select = data[2:0];
    localparam [31:0] ALLOWED_SOURCE_SELECT = SOURCES;
    wire bad_source_select = !ALLOWED_SOURCE_SELECT[{2'd0, new_source_select}];
    wire [19:0] new_tick_us = data[19:0];
    localparam [19:0] TOP_TICK_US = 20'd1000000;
    wire over_tick_us = {1'b0, new_tick_us} > {1'b0, TOP_TICK_US};
    wire under_tick_us = new_tick_us < 20'd1;
    wire [15:0] new_prescale_tick = data[15:0];
    wire under_prescale_tick = new_prescale_tick < 16'd1;
    wire [15:0] new_prescale_us = data[31:16];
    wire under_prescale_us = new_prescale_us < 16'd1;
    wire [31:0] new_lfsr_seed = data[31:0];
    localparam [31:0] TOP_LFSR_SEED = 32'd4294967294;
    wire over_lfsr_seed = {1'b0, new_lfsr_seed} > {1'b0, TOP_LFSR_SEED};
    wire [15:0] new_lfsr_x_min = data[15:0];
    localparam [15:0] TOP_LFSR_X_MIN = {16{1'b1}} >> (16 - X_W);
    wire over_lfsr_x_min = {1'b0, new_lfsr_x_min} > {1'b0, TOP_LFSR_X_MIN};
    wire [15:0] new_lfsr_x_span = data[31:16];
    localparam [15:0] TOP_LFSR_X_SPAN = {16{1'b1}} >> (16 - X_W);
    wire over_lfsr_x_span = {1'b0, new_lfsr_x_span} > {1'b0, TOP_LFSR_X_SPAN};
    wire [15:0] new_lfsr_y_min = data[15:0];
    localparam [15:0] TOP_LFSR_Y_MIN = {16{1'b1}} >> (16 - Y_W);
    wire over_lfsr_y_min = {1'b0, new_lfsr_y_min} > {1'b0, TOP_LFSR_Y_MIN};
    wire [15:0] new_lfsr_y_span = data[31:16];
    localparam [15:0] TOP_LFSR_Y_SPAN = {16{1'b1}} >> (16 - Y_W);
    wire over_lfsr_y_span = {1'b0, new_lfsr_y_span} > {1'b0, TOP_LFSR_Y_SPAN};

    // ---- an access ---------------------------------------------------------------------------------------------------

    always @* begin
        known    = 1'b1;
        writable = 1'b0;
        value    = 32'd0;
        kept     = 32'd0;
        clamped  = 1'b0;
        refused  = 1'b0;
        case (word)
            11'h000: begin
                value[31:0] = id;
            end
            11'h001: begin
                value[15:0] = version_minor;
                value[31:16] = version_major;
            end
            11'h002: begin
                value[6:0] = shape0_n_slots;
                value[11:8] = shape0_frac;
                value[20:16] = shape0_x_w;
                value[28:24] = shape0_y_w;
            end
            11'h003: begin
                value[5:0] = shape1_tick_w;
                value[11:8] = shape1_radix_w;
                value[20:16] = shape1_nev_w;
                value[29:24] = shape1_tc_w;
            end
            11'h004: begin
                value[5:0] = shape2_sup_w;
                value[13:8] = shape2_id_w;
                value[21:16] = shape2_seq_w;
                value[29:24] = shape2_time_w;
            end
            11'h005: begin
                value[6:0] = build_filters;
                value[13:8] = build_sources;
                value[17:16] = build_tracker;
            end
            11'h006: begin
                value[15:0] = sensor_last_x;
                value[31:16] = sensor_last_y;
            end
            11'h007: begin
                value[5:0] = memory_stamp_w;
                value[15:8] = memory_recent_last;
                value[31:16] = memory_fifo_depth;
            end
            11'h008: begin
                value[0:0] = control_enable;
                value[1:1] = control_drop;
                writable = 1'b1;
                kept     = 32'h00000003;
            end
            11'h009: begin
                value[2:0] = source_select;
                value[8:8] = source_clock_time;
                value[16:16] = source_swap_bytes;
                value[17:17] = source_swap_halves;
                value[24:24] = source_active_low;
                value[25:25] = source_word_serial;
                writable = 1'b1;
                kept     = 32'h03030107;
                if (bad_source_select) refused = 1'b1;
            end
            11'h00a: begin
                value[19:0] = tick_us;
                writable = 1'b1;
                kept     = 32'h000fffff;
                if (over_tick_us) clamped = 1'b1;
                if (under_tick_us) clamped = 1'b1;
            end
            11'h00b: begin
                value[15:0] = prescale_tick;
                value[31:16] = prescale_us;
                writable = 1'b1;
                kept     = 32'hffffffff;
                if (under_prescale_tick) clamped = 1'b1;
                if (under_prescale_us) clamped = 1'b1;
            end
            11'h00c: begin
                value[31:0] = lfsr_seed;
                writable = 1'b1;
                kept     = 32'hffffffff;
                if (over_lfsr_seed) clamped = 1'b1;
            end
            11'h00d: begin
                value[15:0] = lfsr_gap;
                writable = 1'b1;
                kept     = 32'h0000ffff;
            end
            11'h00e: begin
                value[15:0] = lfsr_x_min;
                value[31:16] = lfsr_x_span;
                writable = 1'b1;
                kept     = 32'hffffffff;
                if (over_lfsr_x_min) clamped = 1'b1;
                if (over_lfsr_x_span) clamped = 1'b1;
            end
            11'h00f: begin
                value[15:0] = lfsr_y_min;
                value[31:16] = lfsr_y_span;
                writable = 1'b1;
                kept     = 32'hffffffff;
                if (over_lfsr_y_min) clamped = 1'b1;
                if (over_lfsr_y_span) clamped = 1'b1;
            end
            11'h010: begin
                value[0:0] = status_idle;
                value[1:1] = status_pending;
                value[2:2] = status_open;
                value[31:16] = status_held;
            end
            11'h011: begin
                value[0:0] = fault_clamped;
                value[1:1] = fault_refused;
                value[2:2] = fault_pending;
                value[3:3] = fault_unmapped;
                value[28:16] = fault_address;
                writable = 1'b1;
            end
            11'h012: begin
                value[0:0] = irq_status_birth;
                value[1:1] = irq_status_loss;
                value[2:2] = irq_status_merge;
                value[3:3] = irq_status_overflow;
                value[4:4] = irq_status_commit;
            end
            11'h013: begin
                value[4:0] = irq_enable;
                writable = 1'b1;
                kept     = 32'h0000001f;
            end
            11'h014: begin
                writable = 1'b1;
            end
            11'h015: begin
                value[31:0] = commit_seq_low;
            end
            11'h016: begin
                value[15:0] = commit_seq_high;
            end
            11'h017: begin
                value[31:0] = commits;
            end
            11'h020: begin
                value[31:0] = events_in;
            end
            11'h021: begin
                value[31:0] = events_dropped;
            end
            11'h022: begin
                value[31:0] = malformed;
            end
            11'h023: begin
                value[31:0] = events;
            end
            11'h024: begin
                value[31:0] = filtered;
            end
            11'h025: begin
                value[31:0] = owned;
            end
            11'h026: begin
                value[31:0] = passed;
            end
            11'h027: begin
                value[31:0] = records;
            end
            11'h028: begin
                value[31:0] = stalls;
            end
            default: known = 1'b0;
        endcase
    end

    always @(posedge clk) begin
        control_latch <= 1'd0;
        control_soft_reset <= 1'd0;
        fault_clamped_clear <= 1'd0;
        fault_refused_clear <= 1'd0;
        fault_pending_clear <= 1'd0;
        fault_unmapped_clear <= 1'd0;
        irq_clear <= 5'd0;
        if (write && !refused)
            case (word)
                11'h008: begin
                    control_enable <= data[0:0];
                    control_drop <= data[1:1];
                    control_latch <= data[8:8];
                    control_soft_reset <= data[9:9];
                end
                11'h009: begin
                    source_select <= data[2:0];
                    source_clock_time <= data[8:8];
                    source_swap_bytes <= data[16:16];
                    source_swap_halves <= data[17:17];
                    source_active_low <= data[24:24];
                    source_word_serial <= data[25:25];
                end
                11'h00a: begin
                    tick_us <= under_tick_us ? 20'd1 : over_tick_us ? TOP_TICK_US : new_tick_us;
                end
                11'h00b: begin
                    prescale_tick <= under_prescale_tick ? 16'd1 : new_prescale_tick;
                    prescale_us <= under_prescale_us ? 16'd1 : new_prescale_us;
                end
                11'h00c: begin
                    lfsr_seed <= over_lfsr_seed ? TOP_LFSR_SEED : new_lfsr_seed;
                end
                11'h00d: begin
                    lfsr_gap <= data[15:0];
                end
                11'h00e: begin
                    lfsr_x_min <= over_lfsr_x_min ? TOP_LFSR_X_MIN : new_lfsr_x_min;
                    lfsr_x_span <= over_lfsr_x_span ? TOP_LFSR_X_SPAN : new_lfsr_x_span;
                end
                11'h00f: begin
                    lfsr_y_min <= over_lfsr_y_min ? TOP_LFSR_Y_MIN : new_lfsr_y_min;
                    lfsr_y_span <= over_lfsr_y_span ? TOP_LFSR_Y_SPAN : new_lfsr_y_span;
                end
                11'h011: begin
                    fault_clamped_clear <= data[0:0];
                    fault_refused_clear <= data[1:1];
                    fault_pending_clear <= data[2:2];
                    fault_unmapped_clear <= data[3:3];
                end
                11'h013: begin
                    irq_enable <= data[4:0];
                end
                11'h014: begin
                    irq_clear <= data[4:0];
                end
                default: ;
            endcase
        if (rst) begin
            control_enable <= 1'd0;
            control_drop <= 1'd0;
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
        end
    end

endmodule

`default_nettype wire
