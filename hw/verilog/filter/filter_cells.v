// SPDX-License-Identifier: Apache-2.0
// The refractory and the activity filter in one, over one memory of cells (docs/filters.md, "One memory of cells").
//
// It decides what the two in series decide: what refractory keeps is what activity sees, so both need the time of the same
// events. Times are stored in units of 2^stamp_shift ticks (stamp_units.v), in few bits (cell_memory.v).
//
// Latency:    14 clocks from s_ to m_: 2 of the units, 9 of the memory, comparison, count, decision.
// Throughput: 1 token per clock; for stalls by the walk over the memory, which are rare, see stamp_walk.v.
// Stall:      while the output is full, the pipeline stalls. After a change of a register no token is taken for a few clocks.
// Reset:      becomes empty and clears the memory: ceil(WIDTH / 4 CELL_PX) * ceil(HEIGHT / 4 CELL_PX) + 8 clocks with idle low, in
//             which three tokens at most are taken.
// RAM:        16 * ceil(WIDTH / 4 CELL_PX) * ceil(HEIGHT / 4 CELL_PX) * 9 bits.
// Combinational paths: none; s_ready comes from registers alone, and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module filter_cells #(
    parameter X_W     = 9,    // bits of an x address
    parameter Y_W     = 9,    // bits of a y address
    parameter TICK_W  = 20,   // bits of the tick input
    parameter WIDTH   = 346,  // pixels of the sensor across
    parameter HEIGHT  = 260,  // pixels of the sensor down
    parameter STAMP_W = 20,   // bits of a register of ticks, and one more
    parameter CELL_PX = 1,    // side of a cell in pixels: 1, 2 or 4
    parameter CELL_STAMP_W = 0  // bits of a time stamp in a cell; 0: as many as 9 bits hold
) (
    input  wire               clk,
    input  wire               rst,

    // registers: see filter_regs.v
    input  wire               changes,    // one is new in the next clock
    input  wire               enable_refractory,
    input  wire               enable_activity,
    input  wire [STAMP_W-2:0] refractory_ticks,
    input  wire [STAMP_W-2:0] activity_ticks,
    input  wire [3:0]         stamp_shift,

    // tokens in
    input  wire               s_valid,
    output wire               s_ready,
    input  wire [TICK_W-1:0]  s_tick,
    input  wire               s_event,
    input  wire               s_skip,
    input  wire [X_W-1:0]     s_x,
    input  wire [Y_W-1:0]     s_y,
    input  wire               s_p,
    input  wire [3:0]         s_support,  // cells that the event needs: see noise_support.v

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
    parameter_check #(.OK(STAMP_W >= `EVCOT_STAMP_W_MIN && STAMP_W <= `EVCOT_STAMP_W_MAX)) STAMP_W_must_be_4_to_32 ();

    localparam CELL_W  = (CELL_STAMP_W != 0) ? CELL_STAMP_W : (CELL_PX == 4) ? 5 : (CELL_PX == 2) ? 7 : 9;
    localparam TOKEN_W = TICK_W + X_W + Y_W + 9;
    localparam [CELL_W-1:0] KEEP   = {2'b11, {(CELL_W - 2) {1'b0}}};

    // ---- the two times in units, as far as stamps reach --------------------------------------------------------------

    // In turn, in clocks in which no token's ticks are converted. No token is taken after a change until both are known.
    reg               turn, units_turn;  // 0: refractory, 1: activity
    reg               units_come;
    reg  [2:0]        unknown;           // conversions until then
    reg  [CELL_W-1:0] long_units, silence, window;
    wire              converts;
    wire [CELL_W-1:0] converted;
    wire [CELL_W-1:0] turn_units = (long_units < KEEP) ? long_units : KEEP;
    wire              known      = unknown == 3'd0;

    always @(posedge clk) begin
        if (converts) begin
            turn    <= !turn;
            unknown <= known ? 3'd0 : unknown - 3'd1;
        end
        units_come <= converts;
        units_turn <= turn;
        long_units <= converted;
        if (units_come) begin
            if (!units_turn) silence <= enable_refractory ? turn_units : {CELL_W{1'b0}};
            else window <= (turn_units == KEEP) ? KEEP - 1'b1 : turn_units;
        end
        if (changes || rst) unknown <= 3'd4;
        if (rst) begin
            turn       <= 1'b0;
            units_come <= 1'b0;
        end
    end

    // ---- units and memory --------------------------------------------------------------------------------------------

    wire space;  // for one more token in the output: everything behind the units moves

    wire               units_valid, units_ready, units_space, units_idle, memory_idle;
    wire [CELL_W-1:0]  units;
    wire [TOKEN_W-1:0] token, old;
    wire               old_valid, old_inside, old_stays;
    wire [15:0]        old_supports;
    wire [16*CELL_W-1:0] no_age;

    assign s_ready = units_space && known;

    stamp_units #(
        .TICK_W (TICK_W),
        .UNITS_W(CELL_W),
        .DATA_W (TOKEN_W),
        .OTHER_W(STAMP_W - 1)
    ) u_units (
        .clk    (clk),
        .rst    (rst),
        .shift  (stamp_shift),
        .s_valid(s_valid && known),
        .s_ready(units_space),
        .s_tick (s_tick),
        .s_data ({s_event && (enable_refractory || enable_activity), enable_activity, s_support, s_tick, s_event, s_skip, s_x, s_y, s_p}),
        .m_valid(units_valid),
        .m_ready(units_ready),
        .m_units(units),
        .m_data (token),
        .other  (turn ? activity_ticks : refractory_ticks),
        .other_valid(converts),
        .other_units(converted),
        .idle   (units_idle)
    );

    cell_memory #(
        .X_W    (X_W),
        .Y_W    (Y_W),
        .WIDTH  (WIDTH),
        .HEIGHT (HEIGHT),
        .CELL_PX(CELL_PX),
        .STEP_W (CELL_W),
        .DATA_W (TOKEN_W),
        .STAMP_W(CELL_W)
    ) u_memory (
        .clk      (clk),
        .rst      (rst),
        .advance  (space),
        .silence  (silence),
        .window   (window),
        .s_valid  (units_valid),
        .s_ready  (units_ready),
        .s_step   (units),
        .s_access (token[TOKEN_W-1]),
        .s_x      (token[Y_W+1 +: X_W]),
        .s_y      (token[1 +: Y_W]),
        .s_data   (token),
        .m_valid  (old_valid),
        .m_data   (old),
        .m_inside (old_inside),
        .m_stays  (old_stays),
        .m_supports(old_supports),
        .m_age    (no_age),
        .idle     (memory_idle)
    );

    // ---- comparison and count ----------------------------------------------------------------------------------------

    reg               compared_valid, compared_stays, counted_valid, counted_stays;
    reg [TOKEN_W-1:0] compared, counted;
    reg [15:0]        supporters;
    reg [3:0]         support;  // 9 at most

    function [1:0] three_of;  // how many of the four banks of a line support: no more than three are around an event
        input [3:0] line;
        three_of = {(line[0] && line[1]) || (line[2] && line[3]) || ((line[0] || line[1]) && (line[2] || line[3])), ^line};
    endfunction

    always @(posedge clk) begin
        if (space) begin
            compared_valid <= old_valid;
            compared_stays <= old_inside && old_stays;
            compared       <= old;
            supporters     <= old_supports;

            counted_valid  <= compared_valid;
            counted_stays  <= compared_stays;
            counted        <= compared;
            support        <= {2'd0, three_of(supporters[3:0])} + {2'd0, three_of(supporters[7:4])}
                            + {2'd0, three_of(supporters[11:8])} + {2'd0, three_of(supporters[15:12])};
        end
        if (rst) begin
            compared_valid <= 1'b0;
            counted_valid  <= 1'b0;
        end
    end

    // ---- decision ----------------------------------------------------------------------------------------------------

    wire              judged, asks_support, is_event, skip;
    wire [3:0]        needed;
    wire [TICK_W-1:0] tick;
    wire [X_W+Y_W:0]  rest;  // x, y, p
    assign {judged, asks_support, needed, tick, is_event, skip, rest} = counted;

    wire drops = judged && !(counted_stays && (!asks_support || support >= needed));

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(counted_valid),
        .s_ready(space),
        .s_data ({tick, is_event && !drops, skip || drops, rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    wire unused = &{1'b0, no_age};

    assign idle = units_idle && memory_idle && !compared_valid && !counted_valid && !m_valid;

endmodule

`default_nettype wire
