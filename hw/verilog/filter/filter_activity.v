// SPDX-License-Identifier: Apache-2.0
// Keeps an event when enough of its 8 neighbours had an event a short while ago (docs/filters.md).
//
// All neighbours are read at once: see stamp_memory.v, which also explains why stamps of STAMP_W bits are exact.
//
// Latency:    8 clocks from s_ to m_: 6 of the memory, comparison, count and decision.
// Throughput: 1 token per clock; for stalls by the walk over the memory, which are rare, see stamp_walk.v.
// Stall:      while the output is full, the pipeline stalls.
// Reset:      becomes empty and clears the memory: ceil(WIDTH/4) * ceil(HEIGHT/4) + 6 clocks with idle and s_ready low.
// RAM:        16 * ceil(WIDTH/4) * ceil(HEIGHT/4) * STAMP_W bits.
// Combinational paths: none; s_ready comes from registers alone, and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module filter_activity #(
    parameter X_W     = 9,    // bits of an x address
    parameter Y_W     = 9,    // bits of a y address
    parameter TICK_W  = 20,   // bits of the tick input
    parameter WIDTH   = 346,  // pixels of the sensor across
    parameter HEIGHT  = 260,  // pixels of the sensor down
    parameter STAMP_W = 20    // bits of a time stamp
) (
    input  wire               clk,
    input  wire               rst,

    // registers: see filter_regs.v
    input  wire               enable,
    input  wire [STAMP_W-2:0] activity_ticks,
    input  wire [3:0]         activity_support,

    // tokens in
    input  wire               s_valid,
    output wire               s_ready,
    input  wire [TICK_W-1:0]  s_tick,
    input  wire               s_event,
    input  wire               s_skip,
    input  wire [X_W-1:0]     s_x,
    input  wire [Y_W-1:0]     s_y,
    input  wire               s_p,

    // tokens out
    output wire               m_valid,
    input  wire               m_ready,
    output wire [TICK_W-1:0]  m_tick,
    output wire               m_event,
    output wire               m_skip,
    output wire [X_W-1:0]     m_x,
    output wire [Y_W-1:0]     m_y,
    output wire               m_p,

    output wire               idle  // nothing inside, memory emptied after reset
);

    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();

    localparam TOKEN_W = TICK_W + X_W + Y_W + 4;

    wire space;  // for one more token in the output: everything moves

    // ---- the neighbours ----------------------------------------------------------------------------------------------

    wire                  old_valid, old_inside, memory_idle;
    wire [TOKEN_W-1:0]    old;
    wire [15:0]           near;
    wire [16*STAMP_W-1:0] age;

    stamp_memory #(
        .X_W      (X_W),
        .Y_W      (Y_W),
        .WIDTH    (WIDTH),
        .HEIGHT   (HEIGHT),
        .STAMP_W  (STAMP_W),
        .SEGMENT_W(STAMP_W - 2),  // ages up to 2^(STAMP_W-1) - 1 matter
        .STEP_W   (TICK_W),
        .DATA_W   (TOKEN_W)
    ) u_memory (
        .clk     (clk),
        .rst     (rst),
        .advance (space),
        .s_valid (s_valid),
        .s_ready (s_ready),
        .s_step  (s_tick),
        .s_access(s_event && enable),
        .s_x     (s_x),
        .s_y     (s_y),
        .s_data  ({s_event && enable, s_tick, s_event, s_skip, s_x, s_y, s_p}),
        .m_valid (old_valid),
        .m_data  (old),
        .m_inside(old_inside),
        .m_near  (near),
        .m_age   (age),
        .idle    (memory_idle)
    );

    // ---- comparison: with each neighbour -----------------------------------------------------------------------------

    reg               compared_valid, compared_inside;
    reg [TOKEN_W-1:0] compared;
    reg [15:0]        supporters;

    always @(posedge clk) begin : compare
        integer k;
        if (space) begin
            compared_valid  <= old_valid;
            compared_inside <= old_inside;
            compared        <= old;
            for (k = 0; k < 16; k = k + 1)
                supporters[k] <= near[k] && age[k*STAMP_W +: STAMP_W] <= {1'b0, activity_ticks};
        end
        if (rst) compared_valid <= 1'b0;
    end

    // ---- count and decision ------------------------------------------------------------------------------------------

    reg [3:0] support;  // 8 at most

    always @* begin : add_up
        integer k;
        k       = 0;  // on every path, or it would be a latch
        support = 4'd0;
        for (k = 0; k < 16; k = k + 1) support = support + {3'd0, supporters[k]};
    end

    wire              judged, is_event, skip;
    wire [TICK_W-1:0] tick;
    wire [X_W+Y_W:0]  rest;  // x, y, p
    assign {judged, tick, is_event, skip, rest} = compared;

    wire drops = judged && !(compared_inside && support >= activity_support);

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(compared_valid),
        .s_ready(space),
        .s_data ({tick, is_event && !drops, skip || drops, rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign idle = memory_idle && !compared_valid && !m_valid;

endmodule

`default_nettype wire
