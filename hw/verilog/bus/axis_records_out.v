// SPDX-License-Identifier: Apache-2.0
// Records to AXI4-Stream: EVCOT_RECORD_* in evcot_regs.vh, which is contract.RECORD byte for byte, little-endian; with MOTION
// EVCOT_MOTION_RECORD_*, motion.contract.MOTION_RECORD.
//
// A record takes EVCOT_RECORD_W / DATA_W beats, rounded up; tlast marks the last one, in which tkeep is 0 for the bytes
// beyond the record. Fields are padded with zeros, signed ones with their sign. What a record does not have is not read.
//
// Latency:    2 clocks to the first beat.
// Stall:      up to DEPTH records are queued while the output stalls; then m_cm_ready is de-asserted.
// Reset:      empty; a record that is being sent is truncated.
// Combinational paths: none.
// Throughput: a beat per clock.
`default_nettype none
`include "evcot_regs.vh"

module axis_records_out #(
    parameter DATA_W  = 64,  // bits of a beat: 32, 64, 128 or 256
    parameter DEPTH   = 16,  // records that may wait, at least 1
    parameter MOTION  = 0,   // records of cot_motion
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

    output wire                m_axis_tvalid,
    input  wire                m_axis_tready,
    output wire [DATA_W-1:0]   m_axis_tdata,
    output wire [DATA_W/8-1:0] m_axis_tkeep,
    output wire                m_axis_tlast,

    output wire                idle          // no record inside
);

    parameter_check #(.OK(DATA_W == 32 || DATA_W == 64 || DATA_W == 128 || DATA_W == 256)) DATA_W_must_be_32_64_128_or_256 ();
    parameter_check #(.OK(DEPTH >= 1)) DEPTH_must_be_at_least_1 ();

    localparam RECORD_W = (MOTION != 0) ? `EVCOT_MOTION_RECORD_W : `EVCOT_RECORD_W;
    localparam BOX_W  = (MOTION != 0) ? 2 * SIDE_W + 32 : RADIUS_W;  // bits of a box and its velocity, or of a radius
    localparam W      = 2 + SLOT_W + 2 * ID_W + X_W + Y_W + BOX_W + NEV_W + SUP_W + SEQ_W + TIME_W;
    localparam BEATS  = (RECORD_W + DATA_W - 1) / DATA_W;
    localparam BEAT_W = $clog2(BEATS);
    localparam [31:0] LAST  = BEATS - 1;
    localparam        BYTES = (RECORD_W - (BEATS - 1) * DATA_W) / 8;  // of the record in the last beat
    localparam [DATA_W/8-1:0] ALL  = {(DATA_W / 8) {1'b1}};
    localparam [DATA_W/8-1:0] SOME = ALL >> (DATA_W / 8 - BYTES);

    wire valid, ready, last;
    wire [1:0]          kind;
    wire [SLOT_W-1:0]   slot;
    wire [ID_W-1:0]     id, other;
    wire [X_W-1:0]      x;
    wire [Y_W-1:0]      y;
    wire [BOX_W-1:0]    s_box, box;
    wire [NEV_W-1:0]    n_ev;
    wire [SUP_W-1:0]    support;
    wire [SEQ_W-1:0]    seq;
    wire [TIME_W-1:0]   time_;
    wire [$clog2(DEPTH+1)-1:0] level;

    reg [BEAT_W-1:0] beat;
    assign last = beat == LAST[BEAT_W-1:0];

    fifo #(
        .W    (W),
        .DEPTH(DEPTH)
    ) u_records (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_cm_valid),
        .s_ready(s_cm_ready),
        .s_data ({s_cm_kind, s_cm_slot, s_cm_id, s_cm_other, s_cm_x, s_cm_y, s_box, s_cm_n_ev, s_cm_support, s_cm_seq,
                  s_cm_time}),
        .m_valid(valid),
        .m_ready(ready && last),
        .m_data ({kind, slot, id, other, x, y, box, n_ev, support, seq, time_}),
        .level  (level)
    );

    // ---- the record as bytes, then beat by beat ----------------------------------------------------------------------

    reg [BEATS*DATA_W-1:0] bytes;

    generate
        if (MOTION != 0) begin : g_motion
            assign s_box = {s_cm_width, s_cm_height, s_cm_v_x, s_cm_v_y};

            always @* begin
                bytes = {(BEATS * DATA_W) {1'b0}};
                bytes[`EVCOT_MOTION_RECORD_SEQ_LSB +: SEQ_W]        = seq;
                bytes[`EVCOT_MOTION_RECORD_TIME_LSB +: TIME_W]      = time_;
                bytes[`EVCOT_MOTION_RECORD_TRACK_ID_LSB +: ID_W]    = id;
                bytes[`EVCOT_MOTION_RECORD_OTHER_ID_LSB +: ID_W]    = other;
                bytes[`EVCOT_MOTION_RECORD_CM_X_LSB +: 32]          = {{(32 - X_W) {x[X_W-1]}}, x};
                bytes[`EVCOT_MOTION_RECORD_CM_Y_LSB +: 32]          = {{(32 - Y_W) {y[Y_W-1]}}, y};
                bytes[`EVCOT_MOTION_RECORD_WIDTH_LSB +: SIDE_W]     = box[SIDE_W+32 +: SIDE_W];
                bytes[`EVCOT_MOTION_RECORD_HEIGHT_LSB +: SIDE_W]    = box[32 +: SIDE_W];
                bytes[`EVCOT_MOTION_RECORD_V_X_LSB +: 16]           = box[16 +: 16];
                bytes[`EVCOT_MOTION_RECORD_V_Y_LSB +: 16]           = box[0 +: 16];
                bytes[`EVCOT_MOTION_RECORD_SUPPORT_LSB +: SUP_W]    = support;
                bytes[`EVCOT_MOTION_RECORD_N_EV_LSB +: NEV_W]       = n_ev;
                bytes[`EVCOT_MOTION_RECORD_SLOT_LSB +: SLOT_W]      = slot;
                bytes[`EVCOT_MOTION_RECORD_KIND_LSB +: 2]           = kind;
            end

            wire unused = &{1'b0, s_cm_radius};
        end else begin : g_radius
            assign s_box = s_cm_radius;

            always @* begin
                bytes = {(BEATS * DATA_W) {1'b0}};
                bytes[`EVCOT_RECORD_SEQ_LSB +: SEQ_W]         = seq;
                bytes[`EVCOT_RECORD_TIME_LSB +: TIME_W]       = time_;
                bytes[`EVCOT_RECORD_TRACK_ID_LSB +: ID_W]     = id;
                bytes[`EVCOT_RECORD_OTHER_ID_LSB +: ID_W]     = other;
                bytes[`EVCOT_RECORD_CM_X_LSB +: X_W]          = x;
                bytes[`EVCOT_RECORD_CM_Y_LSB +: Y_W]          = y;
                bytes[`EVCOT_RECORD_SUPPORT_LSB +: SUP_W]     = support;
                bytes[`EVCOT_RECORD_RADIUS_LSB +: RADIUS_W]   = box;
                bytes[`EVCOT_RECORD_N_EV_LSB +: NEV_W]        = n_ev;
                bytes[`EVCOT_RECORD_SLOT_LSB +: SLOT_W]       = slot;
                bytes[`EVCOT_RECORD_KIND_LSB +: 2]            = kind;
            end

            wire unused = &{1'b0, s_cm_width, s_cm_height, s_cm_v_x, s_cm_v_y};
        end
    endgenerate

    always @(posedge clk) begin
        if (valid && ready) beat <= last ? {BEAT_W{1'b0}} : beat + 1'b1;
        if (rst) beat <= {BEAT_W{1'b0}};
    end

    reg              m_valid_reg, last_reg;
    reg [DATA_W-1:0] data_reg;

    // One register and not a skid buffer: nothing leads on from tready but to the queue, and a choice less stands behind its memory.
    assign ready = m_axis_tready || !m_valid_reg;

    always @(posedge clk) begin
        if (ready) begin
            m_valid_reg <= valid;
            last_reg    <= last;
            data_reg    <= bytes[beat*DATA_W +: DATA_W];
        end
        if (rst) m_valid_reg <= 1'b0;
    end

    assign m_axis_tvalid = m_valid_reg;
    assign m_axis_tdata  = data_reg;
    assign m_axis_tlast  = last_reg;
    assign m_axis_tkeep  = last_reg ? SOME : ALL;
    assign idle          = level == 0 && !m_valid_reg;

endmodule

`default_nettype wire
