// SPDX-License-Identifier: Apache-2.0
// The paper's cascade: N trackers in series, each of which receives the events that the previous one passed on.
//
// The first tracker whose window contains an event owns it. Ticks are passed on in order with the events, so every tracker decides
// each event at the tick at which it happened, however late it arrives. Events are numbered at the input; the records and the owned
// events of all trackers are merged round robin, and each tracker's own stay in order.
//
// Latency:    unstalled: that of cot.v, plus 1 clock at the input, 2 per upstream tracker, and 2 where records and owned events
//             are merged.
// Throughput: that of cot.v, an event every 3 to 5 clocks, in every tracker at once.
// Stall:      every output is held until accepted, and a tracker that waits stops those before it.
// Reset:      turns all trackers off.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

module cot_chain #(
    parameter N       = 8,   // trackers
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
    parameter SLOT_W  = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire                clk,
    input  wire                rst,

    // registers: see cot_regs.v
    input  wire                cfg_valid,
    input  wire [SLOT_W-1:0]   cfg_slot,
    input  wire [`EVCOT_REG_W-1:0] cfg_addr,
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

    // centre of mass: one record per birth, move and loss
    output wire                m_cm_valid,
    input  wire                m_cm_ready,
    output wire [1:0]          m_cm_kind,
    output wire [SLOT_W-1:0]   m_cm_slot,
    output wire [ID_W-1:0]     m_cm_id,
    output wire [ID_W-1:0]     m_cm_other,   // trackers in a chain do not merge: 0
    output wire [X_W+FRAC-1:0] m_cm_x,
    output wire [Y_W+FRAC-1:0] m_cm_y,
    output wire [RADIX_W:0]    m_cm_radius,
    output wire [NEV_W-1:0]    m_cm_n_ev,
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

    // events that no tracker took
    output wire                m_pass_valid,
    input  wire                m_pass_ready,
    output wire [X_W-1:0]      m_pass_x,
    output wire [Y_W-1:0]      m_pass_y,
    output wire                m_pass_p,
    output wire [SEQ_W-1:0]    m_pass_seq,

    output wire                idle          // nothing inside, no register write under way
);

    parameter_check #(.OK(N >= `EVCOT_N_SLOTS_MIN && N <= `EVCOT_N_SLOTS_MAX)) N_must_be_1_to_64 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();

    localparam CM_W    = 2 + SLOT_W + ID_W + (X_W + FRAC) + (Y_W + FRAC) + (RADIX_W + 1) + NEV_W + SUP_W + SEQ_W + TIME_W;
    localparam OWN_W   = SLOT_W + 2 * (RADIX_W + 2) + 1 + SEQ_W;
    localparam EVENT_W = 1 + X_W + Y_W + 1;            // is there one, x, y, p
    localparam TOKEN_W = TICK_W + EVENT_W + SEQ_W;

    // ---- entrance: number the events -------------------------------------------------------------------------------

    wire                      first_valid, first_ready, first_skip;
    wire [TICK_W+EVENT_W-1:0] first;

    skid_buffer #(
        .W(TICK_W + EVENT_W + 1)
    ) u_input (
        .clk    (clk),
        .rst    (rst),
        .s_valid(s_valid),
        .s_ready(s_ready),
        .s_data ({s_tick, s_event, s_x, s_y, s_p, s_skip}),
        .m_valid(first_valid),
        .m_ready(first_ready),
        .m_data ({first, first_skip})
    );

    reg [SEQ_W-1:0] seq;  // number of the next event

    always @(posedge clk) begin
        if (first_valid && first_ready && (first[EVENT_W-1] || first_skip)) seq <= seq + 1'b1;
        if (rst) seq <= {SEQ_W{1'b0}};
    end

    // ---- the row: link i enters tracker i --------------------------------------------------------------------------

    wire [N:0]             link_valid, link_ready;
    wire [(N+1)*TOKEN_W-1:0] link;
    wire [N-1:0]           cm_valid, cm_ready, own_valid, own_ready, tracker_idle;
    wire [N*CM_W-1:0]      cm;
    wire [N*OWN_W-1:0]     own;

    assign link_valid[0]       = first_valid;
    assign first_ready         = link_ready[0];
    assign link[0 +: TOKEN_W]  = {first, seq};

    genvar i;
    generate
        for (i = 0; i < N; i = i + 1) begin : tracker
            localparam [SLOT_W-1:0] SLOT = i;

            wire [1:0]          kind;
            wire [ID_W-1:0]     id;
            wire [X_W+FRAC-1:0] cm_x;
            wire [Y_W+FRAC-1:0] cm_y;
            wire [RADIX_W:0]    radius;
            wire [NEV_W-1:0]    n_ev;
            wire [SUP_W-1:0]    support;
            wire [SEQ_W-1:0]    cm_seq, own_seq;
            wire [TIME_W-1:0]   cm_time;
            wire [RADIX_W+1:0]  own_x, own_y;
            wire                own_p;

            cot #(
                .X_W     (X_W),
                .Y_W     (Y_W),
                .FRAC    (FRAC),
                .TICK_W  (TICK_W),
                .RADIX_W (RADIX_W),
                .NEV_W   (NEV_W),
                .TC_W    (TC_W),
                .SUP_W   (SUP_W),
                .ID_W    (ID_W),
                .SEQ_W   (SEQ_W),
                .TIME_W  (TIME_W),
                .ID_FIRST(i),
                .ID_STEP (N)
            ) u_cot (
                .clk         (clk),
                .rst         (rst),
                .cfg_valid   (cfg_valid && cfg_slot == SLOT),
                .cfg_addr    (cfg_addr),
                .cfg_data    (cfg_data),
                .s_valid     (link_valid[i]),
                .s_ready     (link_ready[i]),
                .s_tick      (link[i*TOKEN_W + SEQ_W + EVENT_W +: TICK_W]),
                .s_event     (link[i*TOKEN_W + SEQ_W + 1 + Y_W + X_W]),
                .s_x         (link[i*TOKEN_W + SEQ_W + 1 + Y_W +: X_W]),
                .s_y         (link[i*TOKEN_W + SEQ_W + 1 +: Y_W]),
                .s_p         (link[i*TOKEN_W + SEQ_W]),
                .s_seq       (link[i*TOKEN_W +: SEQ_W]),
                .next_seq    (seq),
                .m_cm_valid  (cm_valid[i]),
                .m_cm_ready  (cm_ready[i]),
                .m_cm_kind   (kind),
                .m_cm_id     (id),
                .m_cm_x      (cm_x),
                .m_cm_y      (cm_y),
                .m_cm_radius (radius),
                .m_cm_n_ev   (n_ev),
                .m_cm_support(support),
                .m_cm_seq    (cm_seq),
                .m_cm_time   (cm_time),
                .m_own_valid (own_valid[i]),
                .m_own_ready (own_ready[i]),
                .m_own_x     (own_x),
                .m_own_y     (own_y),
                .m_own_p     (own_p),
                .m_own_seq   (own_seq),
                .m_pass_valid(link_valid[i+1]),
                .m_pass_ready(link_ready[i+1]),
                .m_pass_tick (link[(i+1)*TOKEN_W + SEQ_W + EVENT_W +: TICK_W]),
                .m_pass_event(link[(i+1)*TOKEN_W + SEQ_W + 1 + Y_W + X_W]),
                .m_pass_x    (link[(i+1)*TOKEN_W + SEQ_W + 1 + Y_W +: X_W]),
                .m_pass_y    (link[(i+1)*TOKEN_W + SEQ_W + 1 +: Y_W]),
                .m_pass_p    (link[(i+1)*TOKEN_W + SEQ_W]),
                .m_pass_seq  (link[(i+1)*TOKEN_W +: SEQ_W]),
                .idle        (tracker_idle[i])
            );

            assign cm[i*CM_W +: CM_W]    = {kind, SLOT, id, cm_x, cm_y, radius, n_ev, support, cm_seq, cm_time};
            assign own[i*OWN_W +: OWN_W] = {SLOT, own_x, own_y, own_p, own_seq};
        end
    endgenerate

    // ---- exit: events only, the row's time ends here ---------------------------------------------------------------

    wire last_event;
    wire [TICK_W-1:0] last_tick;

    assign {last_tick, last_event, m_pass_x, m_pass_y, m_pass_p, m_pass_seq} = link[N*TOKEN_W +: TOKEN_W];
    assign m_pass_valid  = link_valid[N] && last_event;
    assign link_ready[N] = m_pass_ready || !last_event;

    stream_arbiter #(
        .N(N),
        .W(CM_W)
    ) u_cm (
        .clk    (clk),
        .rst    (rst),
        .s_valid(cm_valid),
        .s_ready(cm_ready),
        .s_data (cm),
        .m_valid(m_cm_valid),
        .m_ready(m_cm_ready),
        .m_data ({m_cm_kind, m_cm_slot, m_cm_id, m_cm_x, m_cm_y, m_cm_radius, m_cm_n_ev, m_cm_support, m_cm_seq, m_cm_time})
    );
    assign m_cm_other = {ID_W{1'b0}};

    stream_arbiter #(
        .N(N),
        .W(OWN_W)
    ) u_own (
        .clk    (clk),
        .rst    (rst),
        .s_valid(own_valid),
        .s_ready(own_ready),
        .s_data (own),
        .m_valid(m_own_valid),
        .m_ready(m_own_ready),
        .m_data ({m_own_slot, m_own_x, m_own_y, m_own_p, m_own_seq})
    );

    assign idle = &tracker_idle && !first_valid && &cm_ready && &own_ready && !m_cm_valid && !m_own_valid;

    wire unused = &{1'b0, last_tick};

endmodule

`default_nettype wire
