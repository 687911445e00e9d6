// SPDX-License-Identifier: Apache-2.0
// The record of an array with motion, put together by the program from the accumulators of motion_engine.v.
//
// Latency:    1 clock from the last part to the record.
// Throughput: a record at a time.
// Stall:      a record is held until accepted; `free` is low until then.
// Reset:      no record.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"
`include "motion_codes.vh"

module motion_record #(
    parameter SLOT_W = 3,   // bits of a slot number
    parameter SIDE_W = 25,  // bits of a side
    parameter SUP_W  = 16,  // bits of a support count
    parameter ID_W   = 32,  // bits of a track id
    parameter SEQ_W  = 48,  // bits of an event's sequence number
    parameter TIME_W = 48,  // bits of the tick count
    parameter W      = 48   // bits of an accumulator
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              write,      // the part `target`
    input  wire [4:0]        target,
    input  wire [W-1:0]      acc_x,
    input  wire [W-1:0]      acc_y,
    input  wire [SLOT_W-1:0] slot,
    input  wire [SEQ_W-1:0]  seq,
    input  wire [TIME_W-1:0] now,
    output wire              free,

    output reg               m_cm_valid,
    input  wire              m_cm_ready,
    output reg  [1:0]        m_cm_kind,
    output reg  [SLOT_W-1:0] m_cm_slot,
    output reg  [ID_W-1:0]   m_cm_id,
    output reg  [ID_W-1:0]   m_cm_other,
    output reg  [SIDE_W-1:0] m_cm_x,
    output reg  [SIDE_W-1:0] m_cm_y,
    output reg  [SIDE_W-1:0] m_cm_width,
    output reg  [SIDE_W-1:0] m_cm_height,
    output reg  [15:0]       m_cm_v_x,
    output reg  [15:0]       m_cm_v_y,
    output reg  [9:0]        m_cm_n_ev,
    output reg  [SUP_W-1:0]  m_cm_support,
    output reg  [SEQ_W-1:0]  m_cm_seq,
    output reg  [TIME_W-1:0] m_cm_time
);

    reg [1:0] kind;

    assign free = !m_cm_valid;

    always @(posedge clk) begin
        if (m_cm_ready) m_cm_valid <= 1'b0;
        if (write)
            case (target)
                `EVCOT_MOTION_OUT_KIND: kind <= acc_x[1:0];
                `EVCOT_MOTION_OUT_HEAD: begin
                    m_cm_kind <= kind;
                    m_cm_slot <= slot;
                    m_cm_seq  <= seq;
                    m_cm_time <= now;
                end
                `EVCOT_MOTION_OUT_MIDDLE: {m_cm_x, m_cm_y} <= {acc_x[SIDE_W-1:0], acc_y[SIDE_W-1:0]};
                `EVCOT_MOTION_OUT_SIDES: {m_cm_width, m_cm_height} <= {acc_x[SIDE_W-1:0], acc_y[SIDE_W-1:0]};
                `EVCOT_MOTION_OUT_MOVES: {m_cm_v_x, m_cm_v_y} <= {acc_x[15:0], acc_y[15:0]};
                `EVCOT_MOTION_OUT_ID: m_cm_id <= acc_x[ID_W-1:0];
                `EVCOT_MOTION_OUT_OTHER_ID: m_cm_other <= kind == `EVCOT_KIND_MERGED ? acc_x[ID_W-1:0] : {ID_W{1'b0}};
                `EVCOT_MOTION_OUT_N_EV: m_cm_n_ev <= acc_x[9:0];
                `EVCOT_MOTION_OUT_SUPPORT: m_cm_support <= acc_x[SUP_W-1:0];
                `EVCOT_MOTION_OUT_RECORD: m_cm_valid <= 1'b1;
                default: ;
            endcase
        if (rst) m_cm_valid <= 1'b0;
    end

    wire unused = &{1'b0, acc_x, acc_y};

endmodule

`default_nettype wire
