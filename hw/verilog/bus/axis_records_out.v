// SPDX-License-Identifier: Apache-2.0
// Records to AXI4-Stream: EVCOT_RECORD_* in evcot_regs.vh, which is contract.RECORD byte for byte, little-endian; with MOTION
// EVCOT_MOTION_RECORD_*, motion.contract.MOTION_RECORD.
//
// A record takes EVCOT_RECORD_W / DATA_W beats, rounded up. In the last one, tkeep is 0 for the bytes beyond the record. Fields are
// padded with zeros, signed ones with their sign. What a record does not have is not read. Records enter the queue, which is for
// block RAM, beat by beat while they wait at s_cm_.
//
// With CLASSIFY, verdicts of the classifier are records of their own kind, EVCOT_VERDICT_RECORD_*. A verdict that waits enters before a
// record that waits, but not within one.
//
// Packets: tlast ends every `packet_records`-th record. If `packet_wait` is not 0, tlast also ends the first record that leaves when
// packet_wait x 256 clocks have passed since the packet's first record. For this, the last beat of a record waits until the next
// record, or that time, has come.
//
// Latency:    as many clocks as a record has beats until it is accepted, then 3 clocks to the first beat.
// Stall:      up to DEPTH records are queued while the output stalls, and one waits at s_cm_.
// Reset:      rst: empty; a record that is being sent is truncated. s_rst: the source of records starts again; a record that has not
//             been accepted is left out.
// Combinational paths: none.
// Throughput: a beat per clock.
`default_nettype none
`include "evcot_regs.vh"

module axis_records_out #(
    parameter DATA_W  = 64,  // bits of a beat: 32, 64, 128 or 256
    parameter DEPTH   = 16,  // records that may wait, at least 1
    parameter MOTION  = 0,   // records of cot_motion
    parameter CLASSIFY = 0,  // verdicts, too
    parameter SLOT_W  = 3,   // bits of a slot number
    parameter ID_W    = 32,  // bits of a track id
    parameter X_W     = 13,  // bits of a centre's x, fraction and all
    parameter Y_W     = 13,  // bits of a centre's y
    parameter RADIUS_W = 9,  // bits of a radius
    parameter SIDE_W  = 25,  // bits of a box's side
    parameter NEV_W   = 10,  // bits of N_ev
    parameter SUP_W   = 16,  // bits of a support count
    parameter SEQ_W   = 48,  // bits of an event's number
    parameter TIME_W  = 48   // bits of the tick count
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                s_rst,

    input  wire [15:0]         packet_records,  // records in a packet, at least 1
    input  wire [15:0]         packet_wait,     // 256 clocks after which a packet ends, or 0

    input  wire                s_cm_valid,
    output wire                s_cm_ready,
    input  wire [1:0]          s_cm_kind,
    input  wire [SLOT_W-1:0]   s_cm_slot,
    input  wire [ID_W-1:0]     s_cm_id,
    input  wire [ID_W-1:0]     s_cm_other,
    input  wire [X_W-1:0]      s_cm_x,
    input  wire [Y_W-1:0]      s_cm_y,
    input  wire [RADIUS_W-1:0] s_cm_radius,
    input  wire [SIDE_W-1:0]   s_cm_width,
    input  wire [SIDE_W-1:0]   s_cm_height,
    input  wire [15:0]         s_cm_v_x,
    input  wire [15:0]         s_cm_v_y,
    input  wire [NEV_W-1:0]    s_cm_n_ev,
    input  wire [SUP_W-1:0]    s_cm_support,
    input  wire [SEQ_W-1:0]    s_cm_seq,
    input  wire [TIME_W-1:0]   s_cm_time,

    // verdicts
    input  wire                s_verdict_valid,
    output wire                s_verdict_ready,
    input  wire [SLOT_W-1:0]   s_verdict_slot,
    input  wire [ID_W-1:0]     s_verdict_id,
    input  wire [SEQ_W-1:0]    s_verdict_seq,
    input  wire [3:0]          s_verdict_class,
    input  wire [14:0]         s_verdict_margin,
    input  wire [7:0]          s_verdict_windows,

    output wire                m_axis_tvalid,
    input  wire                m_axis_tready,
    output wire [DATA_W-1:0]   m_axis_tdata,
    output wire [DATA_W/8-1:0] m_axis_tkeep,
    output wire                m_axis_tlast,

    output wire                idle          // no record inside
);

    parameter_check #(.OK(DATA_W == 32 || DATA_W == 64 || DATA_W == 128 || DATA_W == 256)) DATA_W_must_be_32_64_128_or_256 ();
    parameter_check #(.OK(DEPTH >= 1)) DEPTH_must_be_at_least_1 ();
    parameter_check #(.OK(CLASSIFY == 0 || (CLASSIFY == 1 && MOTION != 0))) CLASSIFY_must_be_0_or_1_and_needs_cot_motion ();

    localparam RECORD_W = (MOTION != 0) ? `EVCOT_MOTION_RECORD_W : `EVCOT_RECORD_W;
    localparam BEATS  = (RECORD_W + DATA_W - 1) / DATA_W;
    localparam BEAT_W = $clog2(BEATS);
    localparam [31:0] LAST  = BEATS - 1;
    localparam        BYTES = (RECORD_W - (BEATS - 1) * DATA_W) / 8;  // of the record in the last beat
    localparam [DATA_W/8-1:0] ALL  = {(DATA_W / 8) {1'b1}};
    localparam [DATA_W/8-1:0] SOME = ALL >> (DATA_W / 8 - BYTES);

    // ---- the record as bytes -----------------------------------------------------------------------------------------

    reg [BEATS*DATA_W-1:0] bytes;

    generate
        if (MOTION != 0) begin : g_motion
            always @* begin
                bytes = {(BEATS * DATA_W) {1'b0}};
                bytes[`EVCOT_MOTION_RECORD_SEQ_LSB +: SEQ_W]        = s_cm_seq;
                bytes[`EVCOT_MOTION_RECORD_TIME_LSB +: TIME_W]      = s_cm_time;
                bytes[`EVCOT_MOTION_RECORD_TRACK_ID_LSB +: ID_W]    = s_cm_id;
                bytes[`EVCOT_MOTION_RECORD_OTHER_ID_LSB +: ID_W]    = s_cm_other;
                bytes[`EVCOT_MOTION_RECORD_CM_X_LSB +: 32]          = {{(32 - X_W) {s_cm_x[X_W-1]}}, s_cm_x};
                bytes[`EVCOT_MOTION_RECORD_CM_Y_LSB +: 32]          = {{(32 - Y_W) {s_cm_y[Y_W-1]}}, s_cm_y};
                bytes[`EVCOT_MOTION_RECORD_WIDTH_LSB +: SIDE_W]     = s_cm_width;
                bytes[`EVCOT_MOTION_RECORD_HEIGHT_LSB +: SIDE_W]    = s_cm_height;
                bytes[`EVCOT_MOTION_RECORD_V_X_LSB +: 16]           = s_cm_v_x;
                bytes[`EVCOT_MOTION_RECORD_V_Y_LSB +: 16]           = s_cm_v_y;
                bytes[`EVCOT_MOTION_RECORD_SUPPORT_LSB +: SUP_W]    = s_cm_support;
                bytes[`EVCOT_MOTION_RECORD_N_EV_LSB +: NEV_W]       = s_cm_n_ev;
                bytes[`EVCOT_MOTION_RECORD_SLOT_LSB +: SLOT_W]      = s_cm_slot;
                bytes[`EVCOT_MOTION_RECORD_KIND_LSB +: 2]           = s_cm_kind;
            end

            wire unused = &{1'b0, s_cm_radius};
        end else begin : g_radius
            always @* begin
                bytes = {(BEATS * DATA_W) {1'b0}};
                bytes[`EVCOT_RECORD_SEQ_LSB +: SEQ_W]         = s_cm_seq;
                bytes[`EVCOT_RECORD_TIME_LSB +: TIME_W]       = s_cm_time;
                bytes[`EVCOT_RECORD_TRACK_ID_LSB +: ID_W]     = s_cm_id;
                bytes[`EVCOT_RECORD_OTHER_ID_LSB +: ID_W]     = s_cm_other;
                bytes[`EVCOT_RECORD_CM_X_LSB +: X_W]          = s_cm_x;
                bytes[`EVCOT_RECORD_CM_Y_LSB +: Y_W]          = s_cm_y;
                bytes[`EVCOT_RECORD_SUPPORT_LSB +: SUP_W]     = s_cm_support;
                bytes[`EVCOT_RECORD_RADIUS_LSB +: RADIUS_W]   = s_cm_radius;
                bytes[`EVCOT_RECORD_N_EV_LSB +: NEV_W]        = s_cm_n_ev;
                bytes[`EVCOT_RECORD_SLOT_LSB +: SLOT_W]       = s_cm_slot;
                bytes[`EVCOT_RECORD_KIND_LSB +: 2]            = s_cm_kind;
            end

            wire unused = &{1'b0, s_cm_width, s_cm_height, s_cm_v_x, s_cm_v_y};
        end
    endgenerate

    wire [BEATS*DATA_W-1:0] verdict;

    generate
        if (CLASSIFY != 0) begin : g_verdict
            reg [BEATS*DATA_W-1:0] fields;

            always @* begin
                fields = {(BEATS * DATA_W) {1'b0}};
                fields[`EVCOT_VERDICT_RECORD_SEQ_LSB +: SEQ_W]     = s_verdict_seq;
                fields[`EVCOT_VERDICT_RECORD_TRACK_ID_LSB +: ID_W] = s_verdict_id;
                fields[`EVCOT_VERDICT_RECORD_MARGIN_LSB +: 15]     = s_verdict_margin;
                fields[`EVCOT_VERDICT_RECORD_WINDOWS_LSB +: 8]     = s_verdict_windows;
                fields[`EVCOT_VERDICT_RECORD_CLASS_INDEX_LSB +: 4]       = s_verdict_class;
                fields[`EVCOT_VERDICT_RECORD_SLOT_LSB +: SLOT_W]   = s_verdict_slot;
                fields[`EVCOT_VERDICT_RECORD_KIND_LSB +: 3]        = `EVCOT_VERDICT_KIND;
            end

            assign verdict = fields;
        end else begin : g_no_verdict
            assign verdict = {(BEATS * DATA_W) {1'b0}};

            wire unused_verdict = &{1'b0, s_verdict_slot, s_verdict_id, s_verdict_seq, s_verdict_class, s_verdict_margin, s_verdict_windows};
        end
    endgenerate

    // ---- into the memory, beat by beat -------------------------------------------------------------------------------

    localparam RECORD_NO_W = (DEPTH > 1) ? $clog2(DEPTH) : 1;
    localparam LEVEL_W     = $clog2(DEPTH + 1);
    localparam [31:0] LAST_RECORD = DEPTH - 1, FULL = DEPTH;

    reg  [RECORD_NO_W-1:0] to, from;  // records that are written and read
    reg  [BEAT_W-1:0]      beat_in, beat_out;
    reg  [LEVEL_W-1:0]     level;     // records that are whole in the memory, until their last beat is read
    wire                   full     = level == FULL[LEVEL_W-1:0];
    wire                   last_in  = beat_in == LAST[BEAT_W-1:0];
    wire                   last_out = beat_out == LAST[BEAT_W-1:0];
    reg                    in_verdict;  // the record whose first beat has been written is a verdict
    wire                   takes_verdict = CLASSIFY != 0 && (beat_in == {BEAT_W{1'b0}} ? s_verdict_valid : in_verdict);
    wire                   offered  = takes_verdict || s_cm_valid;
    wire                   put      = offered && !full;
    wire                   came     = put && last_in;
    wire                   get, left;

    reg                          write;
    reg [RECORD_NO_W+BEAT_W-1:0] write_to;
    reg [DATA_W-1:0]             write_data;

    assign s_cm_ready      = last_in && !full && !takes_verdict;
    assign s_verdict_ready = last_in && !full && takes_verdict;

    always @(posedge clk) begin
        write      <= put;
        write_to   <= {to, beat_in};
        write_data <= takes_verdict ? verdict[beat_in*DATA_W +: DATA_W] : bytes[beat_in*DATA_W +: DATA_W];
        in_verdict <= takes_verdict;
        if (put) beat_in <= last_in ? {BEAT_W{1'b0}} : beat_in + 1'b1;
        if (came) to <= (to == LAST_RECORD[RECORD_NO_W-1:0]) ? {RECORD_NO_W{1'b0}} : to + 1'b1;
        if (get) beat_out <= last_out ? {BEAT_W{1'b0}} : beat_out + 1'b1;
        if (left) from <= (from == LAST_RECORD[RECORD_NO_W-1:0]) ? {RECORD_NO_W{1'b0}} : from + 1'b1;
        if (came != left) level <= level + (left ? {LEVEL_W{1'b1}} : {{(LEVEL_W - 1) {1'b0}}, 1'b1});
        if (s_rst) beat_in <= {BEAT_W{1'b0}};
        if (rst) begin
            write    <= 1'b0;
            to       <= {RECORD_NO_W{1'b0}};
            from     <= {RECORD_NO_W{1'b0}};
            beat_in  <= {BEAT_W{1'b0}};
            beat_out <= {BEAT_W{1'b0}};
            level    <= {LEVEL_W{1'b0}};
        end
    end

    // ---- and out of it -----------------------------------------------------------------------------------------------

    reg  ram_valid, ram_last;  // of the beat in the memory's first register
    reg  out_valid, out_last;  // in its second
    reg  holds;                // the last beat of a record waits: does it end its packet?
    reg  tlast;
    wire moves = (m_axis_tready && !holds) || !out_valid;
    wire reads = moves || !ram_valid;

    assign get  = level != {LEVEL_W{1'b0}} && reads;
    assign left = get && last_out;

    block_memory #(
        .W    (DATA_W),
        .DEPTH(((DEPTH > 1) ? DEPTH : 2) << BEAT_W)
    ) u_memory (
        .clk          (clk),
        .write        (write),
        .write_address(write_to),
        .write_data   (write_data),
        .read_enable  (reads),
        .read_address ({from, beat_out}),
        .out_enable   (moves),
        .read_data    (m_axis_tdata)
    );

    // ---- packets -----------------------------------------------------------------------------------------------------

    reg  [15:0] records;  // that the packet has
    reg  [23:0] clocks;   // until it ends
    reg         expired;
    wire        ends   = !(records + 16'd1 < packet_records) || expired;
    wire        leaves = moves && ram_valid && ram_last;

    always @(posedge clk) begin
        if (reads) begin
            ram_valid <= get;
            ram_last  <= last_out;
        end
        if (moves) begin
            out_valid <= ram_valid;
            out_last  <= ram_last;
            tlast     <= ram_last && ends;
            holds     <= leaves && !ends && packet_wait != 16'd0 && !get;
        end
        if (holds) begin
            if (ram_valid || expired || packet_wait == 16'd0) holds <= 1'b0;
            if (!ram_valid && expired) tlast <= 1'b1;
        end

        // A packet begins with the record that leaves.
        if (leaves) records <= ends ? 16'd0 : records + 16'd1;
        if (records == 16'd0) clocks <= {packet_wait, 8'd0};
        else clocks <= clocks - 1'b1;
        expired <= records != 16'd0 && packet_wait != 16'd0 && (expired || clocks == 24'd0);
        if (holds && !ram_valid && expired) records <= 16'd0;

        if (rst) begin
            {ram_valid, out_valid, holds, expired} <= 4'b0000;
            records <= 16'd0;
        end
    end

    assign m_axis_tvalid = out_valid && !holds;
    assign m_axis_tlast  = tlast;
    assign m_axis_tkeep  = out_last ? SOME : ALL;
    assign idle          = level == {LEVEL_W{1'b0}} && !ram_valid && !out_valid;

endmodule

`default_nettype wire
