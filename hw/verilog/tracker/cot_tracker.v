// SPDX-License-Identifier: Apache-2.0
// Instantiates the array, the chain or cot_motion, with one set of ports for all. Latency and behaviour: see those modules.
//
// Latency:    that of the module that is built, as all below.
// Throughput: likewise.
// Stall:      likewise.
// Reset:      likewise.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"
`include "evcot_regs.vh"

module cot_tracker #(
    parameter TRACKER = 0,   // EVCOT_TRACKER_*: cot_array, cot_chain or cot_motion
    parameter N       = 8,   // tracker slots
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter FRAC    = 4,   // fractional bits of a centre and of an average
    parameter TICK_W  = 20,  // bits of the tick input
    parameter RADIX_W = 8,   // bits of a radius register
    parameter NEV_W   = 10,  // bits of N_ev
    parameter TC_W    = 24,  // bits of a timer
    parameter SUP_W   = 16,  // bits of a support count
    parameter ID_W    = 32,  // bits of a track id
    parameter SEQ_W   = 48,  // bits of an event's sequence number
    parameter TIME_W  = 48,  // bits of the tick count
    parameter OWNERS  = 0,   // 1: owned events of cot_motion leave with m_own_visible and m_own_id
    parameter SLOT_W  = (N > 1) ? $clog2(N) : 1,  // derived: leave it alone
    parameter REACH   = (X_W > Y_W) ? (X_W > 9 ? X_W : 9) : (Y_W > 9 ? Y_W : 9),  // derived: leave it alone
    parameter SIDE_W  = REACH + 16,                            // derived: leave it alone
    parameter CM_X_W  = (TRACKER == 2) ? SIDE_W : X_W + FRAC,  // derived: leave it alone
    parameter CM_Y_W  = (TRACKER == 2) ? SIDE_W : Y_W + FRAC,  // derived: leave it alone
    parameter N_EV_W  = (TRACKER == 2) ? 10 : NEV_W            // derived: leave it alone
) (
    input  wire                clk,
    input  wire                rst,

    // registers: see cot_regs.v, motion_regs.v
    input  wire                cfg_valid,
    input  wire [SLOT_W-1:0]   cfg_slot,
    input  wire [`EVCOT_MREG_W-1:0] cfg_addr,  // without motion the upper bit is not read
    input  wire [31:0]         cfg_data,

    // tokens: s_tick ticks have passed, then an event if s_event; s_skip: one that a filter took out, only counted
    input  wire                s_valid,
    output wire                s_ready,
    input  wire [TICK_W-1:0]   s_tick,
    input  wire                s_event,
    input  wire                s_skip,
    input  wire [X_W-1:0]      s_x,
    input  wire [Y_W-1:0]      s_y,
    input  wire                s_p,

    // centre of mass: one record per birth, move, merge and loss
    output wire                m_cm_valid,
    input  wire                m_cm_ready,
    output wire [1:0]          m_cm_kind,
    output wire [SLOT_W-1:0]   m_cm_slot,
    output wire [ID_W-1:0]     m_cm_id,
    output wire [ID_W-1:0]     m_cm_other,   // MERGED: the track that stays; else 0
    output wire [CM_X_W-1:0]   m_cm_x,       // of cot_motion the middle of the box: 2^-12 px, signed
    output wire [CM_Y_W-1:0]   m_cm_y,
    output wire [RADIX_W:0]    m_cm_radius,  // 0 for cot_motion
    output wire [SIDE_W-1:0]   m_cm_width,   // 2^-12 px; this and the next three are 0 without motion
    output wire [SIDE_W-1:0]   m_cm_height,
    output wire [15:0]         m_cm_v_x,     // 2^-12 px per motion step, signed
    output wire [15:0]         m_cm_v_y,
    output wire [N_EV_W-1:0]   m_cm_n_ev,
    output wire [SUP_W-1:0]    m_cm_support,
    output wire [SEQ_W-1:0]    m_cm_seq,
    output wire [TIME_W-1:0]   m_cm_time,

    // owned events, addressed within the owner's window
    output wire                m_own_valid,
    input  wire                m_own_ready,
    output wire [SLOT_W-1:0]   m_own_slot,
    output wire [RADIX_W+1:0]  m_own_x,
    output wire [RADIX_W+1:0]  m_own_y,
    output wire                m_own_p,
    output wire [SEQ_W-1:0]    m_own_seq,
    output wire                m_own_visible,  // with OWNERS: the owner is a track, not a candidate; else 0
    output wire [ID_W-1:0]     m_own_id,       // with OWNERS: that track, if visible; else 0

    // events that no slot took
    output wire                m_pass_valid,
    input  wire                m_pass_ready,
    output wire [X_W-1:0]      m_pass_x,
    output wire [Y_W-1:0]      m_pass_y,
    output wire                m_pass_p,
    output wire [SEQ_W-1:0]    m_pass_seq,

    output wire                idle          // nothing inside, no register write under way
);

    parameter_check #(.OK(TRACKER == `EVCOT_TRACKER_ARRAY || TRACKER == `EVCOT_TRACKER_CHAIN
                          || TRACKER == `EVCOT_TRACKER_MOTION)) TRACKER_must_be_0_to_2 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();
    parameter_check #(.OK(SIDE_W == REACH + 16)) SIDE_W_must_be_left_at_its_default ();
    parameter_check #(.OK(CM_X_W == ((TRACKER == `EVCOT_TRACKER_MOTION) ? SIDE_W : X_W + FRAC))) CM_X_W_must_be_left_at_its_default ();
    parameter_check #(.OK(CM_Y_W == ((TRACKER == `EVCOT_TRACKER_MOTION) ? SIDE_W : Y_W + FRAC))) CM_Y_W_must_be_left_at_its_default ();
    parameter_check #(.OK(N_EV_W == ((TRACKER == `EVCOT_TRACKER_MOTION) ? 10 : NEV_W))) N_EV_W_must_be_left_at_its_default ();

    generate
        if (TRACKER == `EVCOT_TRACKER_CHAIN) begin : g_chain
            cot_chain #(
                .N      (N),
                .X_W    (X_W),
                .Y_W    (Y_W),
                .FRAC   (FRAC),
                .TICK_W (TICK_W),
                .RADIX_W(RADIX_W),
                .NEV_W  (NEV_W),
                .TC_W   (TC_W),
                .SUP_W  (SUP_W),
                .ID_W   (ID_W),
                .SEQ_W  (SEQ_W),
                .TIME_W (TIME_W)
            ) u_tracker (
                .clk         (clk),
                .rst         (rst),
                .cfg_valid   (cfg_valid),
                .cfg_slot    (cfg_slot),
                .cfg_addr    (cfg_addr[`EVCOT_REG_W-1:0]),
                .cfg_data    (cfg_data),
                .s_valid     (s_valid),
                .s_ready     (s_ready),
                .s_tick      (s_tick),
                .s_event     (s_event),
                .s_skip      (s_skip),
                .s_x         (s_x),
                .s_y         (s_y),
                .s_p         (s_p),
                .m_cm_valid  (m_cm_valid),
                .m_cm_ready  (m_cm_ready),
                .m_cm_kind   (m_cm_kind),
                .m_cm_slot   (m_cm_slot),
                .m_cm_id     (m_cm_id),
                .m_cm_other  (m_cm_other),
                .m_cm_x      (m_cm_x),
                .m_cm_y      (m_cm_y),
                .m_cm_radius (m_cm_radius),
                .m_cm_n_ev   (m_cm_n_ev),
                .m_cm_support(m_cm_support),
                .m_cm_seq    (m_cm_seq),
                .m_cm_time   (m_cm_time),
                .m_own_valid (m_own_valid),
                .m_own_ready (m_own_ready),
                .m_own_slot  (m_own_slot),
                .m_own_x     (m_own_x),
                .m_own_y     (m_own_y),
                .m_own_p     (m_own_p),
                .m_own_seq   (m_own_seq),
                .m_pass_valid(m_pass_valid),
                .m_pass_ready(m_pass_ready),
                .m_pass_x    (m_pass_x),
                .m_pass_y    (m_pass_y),
                .m_pass_p    (m_pass_p),
                .m_pass_seq  (m_pass_seq),
                .idle        (idle)
            );

            assign m_cm_width  = {SIDE_W{1'b0}};
            assign m_cm_height = {SIDE_W{1'b0}};
            assign m_cm_v_x    = 16'd0;
            assign m_cm_v_y    = 16'd0;
            assign m_own_visible = 1'b0;
            assign m_own_id      = {ID_W{1'b0}};

            wire unused = &{1'b0, cfg_addr[`EVCOT_MREG_W-1]};
        end else if (TRACKER == `EVCOT_TRACKER_MOTION) begin : g_motion
            cot_motion #(
                .N      (N),
                .X_W    (X_W),
                .Y_W    (Y_W),
                .TICK_W (TICK_W),
                .RADIX_W(RADIX_W),
                .SUP_W  (SUP_W),
                .ID_W   (ID_W),
                .SEQ_W  (SEQ_W),
                .TIME_W (TIME_W),
                .OWNERS (OWNERS)
            ) u_tracker (
                .clk         (clk),
                .rst         (rst),
                .cfg_valid   (cfg_valid),
                .cfg_slot    (cfg_slot),
                .cfg_addr    (cfg_addr),
                .cfg_data    (cfg_data),
                .s_valid     (s_valid),
                .s_ready     (s_ready),
                .s_tick      (s_tick),
                .s_event     (s_event),
                .s_skip      (s_skip),
                .s_x         (s_x),
                .s_y         (s_y),
                .s_p         (s_p),
                .m_cm_valid  (m_cm_valid),
                .m_cm_ready  (m_cm_ready),
                .m_cm_kind   (m_cm_kind),
                .m_cm_slot   (m_cm_slot),
                .m_cm_id     (m_cm_id),
                .m_cm_other  (m_cm_other),
                .m_cm_x      (m_cm_x),
                .m_cm_y      (m_cm_y),
                .m_cm_width  (m_cm_width),
                .m_cm_height (m_cm_height),
                .m_cm_v_x    (m_cm_v_x),
                .m_cm_v_y    (m_cm_v_y),
                .m_cm_n_ev   (m_cm_n_ev),
                .m_cm_support(m_cm_support),
                .m_cm_seq    (m_cm_seq),
                .m_cm_time   (m_cm_time),
                .m_own_valid (m_own_valid),
                .m_own_ready (m_own_ready),
                .m_own_slot  (m_own_slot),
                .m_own_x     (m_own_x),
                .m_own_y     (m_own_y),
                .m_own_p     (m_own_p),
                .m_own_seq   (m_own_seq),
                .m_own_visible(m_own_visible),
                .m_own_id    (m_own_id),
                .m_pass_valid(m_pass_valid),
                .m_pass_ready(m_pass_ready),
                .m_pass_x    (m_pass_x),
                .m_pass_y    (m_pass_y),
                .m_pass_p    (m_pass_p),
                .m_pass_seq  (m_pass_seq),
                .idle        (idle)
            );

            assign m_cm_radius = {(RADIX_W + 1) {1'b0}};
        end else begin : g_array
            cot_array #(
                .N      (N),
                .X_W    (X_W),
                .Y_W    (Y_W),
                .FRAC   (FRAC),
                .TICK_W (TICK_W),
                .RADIX_W(RADIX_W),
                .NEV_W  (NEV_W),
                .TC_W   (TC_W),
                .SUP_W  (SUP_W),
                .ID_W   (ID_W),
                .SEQ_W  (SEQ_W),
                .TIME_W (TIME_W)
            ) u_tracker (
                .clk         (clk),
                .rst         (rst),
                .cfg_valid   (cfg_valid),
                .cfg_slot    (cfg_slot),
                .cfg_addr    (cfg_addr[`EVCOT_REG_W-1:0]),
                .cfg_data    (cfg_data),
                .s_valid     (s_valid),
                .s_ready     (s_ready),
                .s_tick      (s_tick),
                .s_event     (s_event),
                .s_skip      (s_skip),
                .s_x         (s_x),
                .s_y         (s_y),
                .s_p         (s_p),
                .m_cm_valid  (m_cm_valid),
                .m_cm_ready  (m_cm_ready),
                .m_cm_kind   (m_cm_kind),
                .m_cm_slot   (m_cm_slot),
                .m_cm_id     (m_cm_id),
                .m_cm_other  (m_cm_other),
                .m_cm_x      (m_cm_x),
                .m_cm_y      (m_cm_y),
                .m_cm_radius (m_cm_radius),
                .m_cm_n_ev   (m_cm_n_ev),
                .m_cm_support(m_cm_support),
                .m_cm_seq    (m_cm_seq),
                .m_cm_time   (m_cm_time),
                .m_own_valid (m_own_valid),
                .m_own_ready (m_own_ready),
                .m_own_slot  (m_own_slot),
                .m_own_x     (m_own_x),
                .m_own_y     (m_own_y),
                .m_own_p     (m_own_p),
                .m_own_seq   (m_own_seq),
                .m_pass_valid(m_pass_valid),
                .m_pass_ready(m_pass_ready),
                .m_pass_x    (m_pass_x),
                .m_pass_y    (m_pass_y),
                .m_pass_p    (m_pass_p),
                .m_pass_seq  (m_pass_seq),
                .idle        (idle)
            );

            assign m_cm_width  = {SIDE_W{1'b0}};
            assign m_cm_height = {SIDE_W{1'b0}};
            assign m_cm_v_x    = 16'd0;
            assign m_cm_v_y    = 16'd0;
            assign m_own_visible = 1'b0;
            assign m_own_id      = {ID_W{1'b0}};

            wire unused = &{1'b0, cfg_addr[`EVCOT_MREG_W-1]};
        end
    endgenerate

endmodule

`default_nettype wire
