// SPDX-License-Identifier: Apache-2.0
// Keeps an event when enough of the last DEPTH events are near it in space and time (docs/filters.md): the paper's
// activity memory with binary weights.
//
// An event is compared with all DEPTH entries at once and pushed in the same clock, so it is compared with every event before it and
// not with itself, independent of the later pipeline stages. The contents of the memory do not depend on the registers: whether an
// entry counts is decided with the recent_ticks at the time of the comparison, and it is removed only at an age that no legal
// recent_ticks reaches.
//
// Ages are exact. Let H = 2^(STAMP_W-1): recent_ticks is less. Time is counted modulo 4H, in quarters of H ticks. An entry is
// kept while it lies in the present quarter or in the one before. A token of fewer than H ticks enters at most one further
// quarter, so an entry kept until then lies at most two back: this is detected, and it is removed, being more than H ticks old.
// A token of H ticks or more removes all. So an entry that is kept is less than 2H ticks old, recent_ticks less its age lies
// between -2H and H, and modulo 4H its sign says whether the entry counts.
//
// Latency:    6 clocks from s_ to m_: time, comparison in two, count in two, decision.
// Throughput: 1 token per clock.
// Stall:      while the output is full, the pipeline stalls.
// Reset:      becomes empty and clears the memory.
// Combinational paths: none; s_ready and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module filter_recent #(
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter TICK_W  = 20,  // bits of the tick input
    parameter STAMP_W = 20,  // bits of a time stamp
    parameter DEPTH   = 32   // events remembered
) (
    input  wire               clk,
    input  wire               rst,

    // registers: see filter_regs.v
    input  wire               enable,
    input  wire [STAMP_W-2:0] recent_ticks,
    input  wire [3:0]         recent_radius,
    input  wire [8:0]         recent_support,

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

    output wire               idle  // nothing inside
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(STAMP_W >= `EVCOT_STAMP_W_MIN && STAMP_W <= `EVCOT_STAMP_W_MAX)) STAMP_W_must_be_4_to_32 ();
    parameter_check #(.OK(DEPTH >= `EVCOT_RECENT_DEPTH_MIN && DEPTH <= `EVCOT_RECENT_DEPTH_MAX)) DEPTH_must_be_1_to_256 ();

    localparam TOKEN_W = TICK_W + 1 + X_W + Y_W + 1;
    localparam TIME_W  = STAMP_W + 1;
    localparam ENTRY_W = X_W + Y_W + TIME_W;
    localparam COUNT_W = (DEPTH > 15) ? $clog2(DEPTH + 1) : 4;  // room for a part of eight
    localparam WIDE_W  = (TICK_W > TIME_W ? TICK_W : TIME_W) + 1;  // room to compare ticks with H
    localparam DX_W    = (X_W > 4 ? X_W : 4) + 2;                  // room for x + recent_radius - any x
    localparam DY_W    = (Y_W > 4 ? Y_W : 4) + 2;

    wire space;  // for one more token in the output: everything moves

    // ---- when and where the token is: what all comparisons share -----------------------------------------------------

    reg               timed_valid, timed_event;
    reg [TOKEN_W-1:0] timed;
    reg [TIME_W-1:0]  now;             // ticks since reset, of the token in `timed`
    reg [TIME_W-1:0]  oldest;          // stamp that still counts
    reg               jump;            // H ticks or more
    reg [DX_W-1:0]    last_x;          // last column and row that count
    reg [DY_W-1:0]    last_y;

    wire [WIDE_W-1:0] wide_tick = {{(WIDE_W - TICK_W) {1'b0}}, s_tick};
    wire [TIME_W-1:0] next_now  = now + wide_tick[TIME_W-1:0];

    always @(posedge clk) begin
        if (space) begin
            timed_valid <= s_valid;
            timed_event <= s_event;
            timed       <= {s_tick, s_skip, s_x, s_y, s_p};
            if (s_valid) now <= next_now;
            oldest      <= next_now - {2'b00, recent_ticks};
            jump        <= |wide_tick[WIDE_W-1:STAMP_W-1];
            last_x      <= {{(DX_W - X_W) {1'b0}}, s_x} + {{(DX_W - 4) {1'b0}}, recent_radius};
            last_y      <= {{(DY_W - Y_W) {1'b0}}, s_y} + {{(DY_W - 4) {1'b0}}, recent_radius};
        end
        if (rst) begin
            timed_valid <= 1'b0;
            now         <= {TIME_W{1'b0}};
        end
    end

    // ---- comparison: with each entry, as it was before the event -----------------------------------------------------

    reg [DEPTH*ENTRY_W-1:0] entries;  // the newest first
    reg [DEPTH-1:0]         holds;    // entries that are not forgotten

    wire [DEPTH-1:0] kept, in_time, near_x, near_y, same_x, same_y;

    genvar i;
    generate
        for (i = 0; i < DEPTH; i = i + 1) begin : g_entry
            wire [X_W-1:0]    entry_x;
            wire [Y_W-1:0]    entry_y;
            wire [TIME_W-1:0] then;
            assign {entry_x, entry_y, then} = entries[i*ENTRY_W +: ENTRY_W];

            wire [1:0]        quarters = now[TIME_W-1 -: 2] - then[TIME_W-1 -: 2];
            wire [TIME_W-1:0] margin   = then - oldest;  // recent_ticks - age

            // 0 to 2 radii where it counts, 1 radius in the same column or row
            wire [DX_W-1:0]   from_x = last_x - {{(DX_W - X_W) {1'b0}}, entry_x};
            wire [DY_W-1:0]   from_y = last_y - {{(DY_W - Y_W) {1'b0}}, entry_y};
            assign near_x[i] = !(|from_x[DX_W-1:5]) && from_x[4:0] <= {recent_radius, 1'b0};
            assign near_y[i] = !(|from_y[DY_W-1:5]) && from_y[4:0] <= {recent_radius, 1'b0};
            assign same_x[i] = from_x[4:0] == {1'b0, recent_radius};
            assign same_y[i] = from_y[4:0] == {1'b0, recent_radius};

            assign kept[i]    = holds[i] && !jump && !quarters[1];
            assign in_time[i] = kept[i] && !margin[TIME_W-1];

            wire unused = &{1'b0, quarters[0], margin};
        end
    endgenerate

    wire                         pushes       = timed_event && enable;
    wire [(DEPTH+1)*ENTRY_W-1:0] next_entries = {entries, timed[1 +: X_W+Y_W], now};
    wire [DEPTH:0]               next_holds   = {kept, 1'b1};

    reg               placed_valid, placed_event, compared_valid, compared_event;
    reg [TOKEN_W-1:0] placed, compared;
    reg [DEPTH-1:0]   is_in_time, is_near_x, is_near_y, is_same_x, is_same_y, supporters;

    always @(posedge clk) begin
        if (space) begin
            placed_valid   <= timed_valid;
            placed_event   <= timed_event;
            placed         <= timed;
            is_in_time     <= in_time;
            is_near_x      <= near_x;
            is_near_y      <= near_y;
            is_same_x      <= same_x;
            is_same_y      <= same_y;
            compared_valid <= placed_valid;
            compared_event <= placed_event;
            compared       <= placed;
            supporters     <= is_in_time & is_near_x & is_near_y & ~(is_same_x & is_same_y);
            if (timed_valid) begin
                holds <= pushes ? next_holds[DEPTH-1:0] : kept;
                if (pushes) entries <= next_entries[DEPTH*ENTRY_W-1:0];
            end
        end
        if (rst) begin
            placed_valid   <= 1'b0;
            compared_valid <= 1'b0;
            holds          <= {DEPTH{1'b0}};
        end
    end

    // ---- count -------------------------------------------------------------------------------------------------------

    localparam PARTS = (DEPTH + 7) / 8;

    reg               added_valid, added_event, counted_valid, counted_event;
    reg [TOKEN_W-1:0] added, counted;
    reg [4*PARTS-1:0] part, parts;  // sums of eight entries each
    reg [COUNT_W-1:0] support, sum;

    wire [8*PARTS-1:0] of_eight = {{(8 * PARTS - DEPTH) {1'b0}}, supporters};

    always @* begin : add_up
        integer k, j;
        k   = 0;  // on every path, or it would be a latch
        j   = 0;
        sum = {COUNT_W{1'b0}};
        for (k = 0; k < PARTS; k = k + 1) begin
            part[4*k +: 4] = 4'd0;
            for (j = 0; j < 8; j = j + 1) part[4*k +: 4] = part[4*k +: 4] + {3'd0, of_eight[8*k + j]};
            sum = sum + {{(COUNT_W - 4) {1'b0}}, parts[4*k +: 4]};
        end
    end

    always @(posedge clk) begin
        if (space) begin
            added_valid   <= compared_valid;
            added_event   <= compared_event;
            added         <= compared;
            parts         <= part;
            counted_valid <= added_valid;
            counted_event <= added_event;
            counted       <= added;
            support       <= sum;
        end
        if (rst) begin
            added_valid   <= 1'b0;
            counted_valid <= 1'b0;
        end
    end

    // ---- decision ----------------------------------------------------------------------------------------------------

    wire [TICK_W-1:0] tick;
    wire              skip;
    wire [X_W+Y_W:0]  rest;  // x, y, p
    assign {tick, skip, rest} = counted;

    wire drops = counted_event && enable && {{(10 - COUNT_W) {1'b0}}, support} < {1'b0, recent_support};

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(counted_valid),
        .s_ready(space),
        .s_data ({tick, counted_event && !drops, skip || drops, rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign s_ready = space;
    assign idle    = !timed_valid && !placed_valid && !compared_valid && !added_valid && !counted_valid && !m_valid;

    wire unused = &{1'b0, next_entries[DEPTH*ENTRY_W +: ENTRY_W], next_holds[DEPTH]};

endmodule

`default_nettype wire
