// SPDX-License-Identifier: Apache-2.0
// The record of cot_motion.
//
// Latency:    1 clock.
// Throughput: a record in two clocks: `free` does not know of the one that is said in the same clock.
// Stall:      a record is held until accepted; `free` is low while one waits.
// Reset:      no record.
// Combinational paths: m_cm_ready -> free.
`default_nettype none
`include "evcot_defs.vh"

module motion_record #(
    parameter SLOT_W = 3,   // bits of a slot number
    parameter SIDE_W = 25,  // bits of a side
    parameter SUP_W  = 16,  // bits of a support count
    parameter ID_W   = 32,  // bits of a track id
    parameter SEQ_W  = 48,  // bits of an event's sequence number
    parameter TIME_W = 48   // bits of the tick count
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              say,        // a clock after one in which `free` is high and nothing is said
    output wire              free,
    input  wire [1:0]        kind,
    input  wire [SLOT_W-1:0] slot,
    input  wire [ID_W-1:0]   id,
    input  wire [ID_W-1:0]   stays_id,
    input  wire [SIDE_W:0]   sum_x,
    input  wire [SIDE_W:0]   sum_y,
    input  wire [SIDE_W-1:0] side_x,
    input  wire [SIDE_W-1:0] side_y,
    input  wire [15:0]       v_x,
    input  wire [15:0]       v_y,
    input  wire [9:0]        n_ev,
    input  wire [SUP_W-1:0]  support,
    input  wire [SEQ_W-1:0]  seq,
    input  wire [TIME_W-1:0] now,

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

    reg merges;  // the kind is there a clock before `say`

    assign free = !m_cm_valid || m_cm_ready;

    always @(posedge clk) begin
        merges <= kind == `EVCOT_KIND_MERGED;
        if (m_cm_ready) m_cm_valid <= 1'b0;
        if (say) begin
            m_cm_valid   <= 1'b1;
            m_cm_kind    <= kind;
            m_cm_slot    <= slot;
            m_cm_id      <= id;
            m_cm_other   <= merges ? stays_id : {ID_W{1'b0}};
            m_cm_x       <= sum_x[SIDE_W:1];
            m_cm_y       <= sum_y[SIDE_W:1];
            m_cm_width   <= side_x;
            m_cm_height  <= side_y;
            m_cm_v_x     <= v_x;
            m_cm_v_y     <= v_y;
            m_cm_n_ev    <= n_ev;
            m_cm_support <= support;
            m_cm_seq     <= seq;
            m_cm_time    <= now;
        end
        if (rst) m_cm_valid <= 1'b0;
    end

    wire unused = &{1'b0, sum_x[0], sum_y[0]};

endmodule

`default_nettype wire
