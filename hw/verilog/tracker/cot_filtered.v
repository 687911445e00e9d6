// SPDX-License-Identifier: Apache-2.0
// A filter chain in front of N trackers: the array, the chain or cot_motion.
//
// Ports and behaviour are those of the trackers, and filter_cfg_* writes the registers of filter_chain.v. An event that a
// filter drops is not output, but it is numbered: every record and every output event carries the number that its
// event had at the input.
//
// Latency:    that of the filters that HAS builds, plus that of the trackers.
// Throughput: that of the slower one.
// Stall:      every output is held until accepted; one that waits stops the trackers, and these the filters.
// Reset:      disables all filters and turns all slots off; idle rises when the filters' memories have been cleared.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

module cot_filtered #(
    parameter TRACKER = 0,   // EVCOT_TRACKER_*: cot_array, cot_chain or cot_motion
    parameter HAS     = 255, // filters to build, one bit each in the order of EVCOT_FILTER_*
    parameter WIDTH   = 346, // pixels of the sensor across
    parameter HEIGHT  = 260, // pixels of the sensor down
    parameter STAMP_W = 20,  // bits of a time stamp in a filter's memory
    parameter RECENT_DEPTH = 32,  // events in the FIFO of recent events
    parameter CELL_PX = 0,   // side of a cell of the filters' memory in pixels; 0: a time stamp per pixel and filter
    parameter CELL_STAMP_W = 0,  // bits of a time stamp in a cell of refractory and activity; 0: as many as 9 bits hold
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

    // registers of the trackers: see cot_regs.v, motion_regs.v
    input  wire                cfg_valid,
    input  wire [SLOT_W-1:0]   cfg_slot,
    input  wire [`EVCOT_MREG_W-1:0] cfg_addr,  // without motion the upper bit is not read
    input  wire [31:0]         cfg_data,

    // registers of the filters: see filter_regs.v
    input  wire                filter_cfg_valid,
    input  wire [`EVCOT_FREG_W-1:0] filter_cfg_addr,
    input  wire [31:0]         filter_cfg_data,

    // tokens: s_tick ticks have passed, then an event if s_event; s_skip: one that was taken out before, only counted
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
    output wire [ID_W-1:0]     m_cm_other,
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

    output wire                filtered,     // a filter took out an event, or found one taken out, this clock
    output wire                idle          // nothing inside, no memory being emptied, no register write under way
);

    wire              valid, ready, is_event, skip, p, filters_idle, trackers_idle;
    wire [TICK_W-1:0] tick;
    wire [X_W-1:0]    x;
    wire [Y_W-1:0]    y;

    filter_chain #(
        .HAS         (HAS),
        .X_W         (X_W),
        .Y_W         (Y_W),
        .TICK_W      (TICK_W),
        .WIDTH       (WIDTH),
        .HEIGHT      (HEIGHT),
        .STAMP_W     (STAMP_W),
        .RECENT_DEPTH(RECENT_DEPTH),
        .CELL_PX     (CELL_PX),
        .CELL_STAMP_W(CELL_STAMP_W)
    ) u_filters (
        .clk      (clk),
        .rst      (rst),
        .cfg_valid(filter_cfg_valid),
        .cfg_addr (filter_cfg_addr),
        .cfg_data (filter_cfg_data),
        .s_valid  (s_valid),
        .s_ready  (s_ready),
        .s_tick   (s_tick),
        .s_event  (s_event),
        .s_skip   (s_skip),
        .s_x      (s_x),
        .s_y      (s_y),
        .s_p      (s_p),
        .m_valid  (valid),
        .m_ready  (ready),
        .m_tick   (tick),
        .m_event  (is_event),
        .m_skip   (skip),
        .m_x      (x),
        .m_y      (y),
        .m_p      (p),
        .idle     (filters_idle)
    );

    cot_tracker #(
        .TRACKER(TRACKER),
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
        .TIME_W (TIME_W),
        .OWNERS (OWNERS)
    ) u_trackers (
        .clk         (clk),
        .rst         (rst),
        .cfg_valid   (cfg_valid),
        .cfg_slot    (cfg_slot),
        .cfg_addr    (cfg_addr),
        .cfg_data    (cfg_data),
        .s_valid     (valid),
        .s_ready     (ready),
        .s_tick      (tick),
        .s_event     (is_event),
        .s_skip      (skip),
        .s_x         (x),
        .s_y         (y),
        .s_p         (p),
        .m_cm_valid  (m_cm_valid),
        .m_cm_ready  (m_cm_ready),
        .m_cm_kind   (m_cm_kind),
        .m_cm_slot   (m_cm_slot),
        .m_cm_id     (m_cm_id),
        .m_cm_other  (m_cm_other),
        .m_cm_x      (m_cm_x),
        .m_cm_y      (m_cm_y),
        .m_cm_radius (m_cm_radius),
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
        .idle        (trackers_idle)
    );

    assign filtered = valid && ready && skip;
    assign idle     = filters_idle && trackers_idle;

endmodule

`default_nettype wire
