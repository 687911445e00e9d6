// SPDX-License-Identifier: Apache-2.0
// The clock of a memory of time stamps, and the walk over its cells that keeps stamps exact while they wrap.
//
// A stamp is the low W bits of a clock that counts steps. Ages below KEEP = 2^W - 2^(SEGMENT_W+1) matter; a stamp that is
// older, or of a cell that was never written, may read as any age from KEEP to 2^W - 1: none.
//
// Why no stamp is ever mistaken for a newer one: time is divided into segments of S = 2^SEGMENT_W steps. In each, the walk visits
// every cell once, and sets a stamp of age KEEP or more to age KEEP. A token goes on to the next segment when the walk of
// this one has come to its end, and it enters at most one segment at a time. So at any time each cell has been visited at
// most 2S - 1 steps ago, when its age was KEEP at most (or it was written since): its age is at most
// KEEP + 2S - 1 = 2^W - 1, which W bits can represent. Of one token at most KEEP steps are counted: after that every age counts as
// none, whatever was stored, and later stamps are compared with later ones only.
//
// The walk takes a slot of the pipeline, one cell (or row of cells in banks) per slot, whenever no event needs it. So a token
// waits only where a segment ends before the walk does: after jumps of S steps or more, or when a segment has so many events
// that fewer slots than ROWS were left.
//
// Reset: time 0, no token held; then a first walk, during which `clearing` is high, to write every cell. No token is accepted meanwhile.
// Combinational paths: advance -> s_ready.
// Latency:    none: `advance` moves the token that is held.
// Throughput: a token per clock, but as above where a segment ends before its walk.
// Stall:      advance low holds everything.
`default_nettype none

module stamp_walk #(
    parameter W         = 20,  // bits of a stamp
    parameter SEGMENT_W = 18,  // log2 of the steps in a segment, at most W - 2
    parameter STEP_W    = 20,  // bits of a token's steps
    parameter ROWS      = 16,  // rows of cells to visit
    parameter ROW_W     = 4    // bits of a row's number
) (
    input  wire              clk,
    input  wire              rst,
    input  wire              advance,   // the pipeline moves

    // tokens: s_step steps have passed, then an event that needs the memory, if s_access
    input  wire              s_valid,
    output wire              s_ready,
    input  wire [STEP_W-1:0] s_step,
    input  wire              s_access,

    // the slot that enters the pipeline in this clock: a token, or a visit, or both when the token has no access
    output wire              enters,    // the token taken last
    output wire              access,    // and its event
    output wire              visits,    // a row
    output reg  [ROW_W-1:0]  row,
    output wire [W-1:0]      now,       // for both

    // a visit that has come to the end of the pipeline
    input  wire              visited,
    input  wire              missed,    // in vain: it and all those under way are to be done again
    input  wire [ROW_W-1:0]  visited_row,

    output reg               clearing,  // visits are to empty their rows
    output wire              waits      // holds a token
);

    parameter_check #(.OK(SEGMENT_W >= 1 && SEGMENT_W <= W - 2)) SEGMENT_W_must_be_1_to_W_minus_2 ();
    parameter_check #(.OK(ROWS >= 1)) ROWS_must_be_at_least_1 ();

    localparam COUNT_W = W - SEGMENT_W;                    // bits that tell segments apart
    localparam WIDE_W  = (STEP_W > W ? STEP_W : W) + 1;    // room to compare steps with KEEP
    localparam [31:0] LAST = ROWS - 1;
    localparam [SEGMENT_W-1:0] NONE = {SEGMENT_W{1'b0}};

    // ---- the token's steps, as far as they count ---------------------------------------------------------------------

    localparam [W-1:0] KEEP = {{(W - SEGMENT_W - 1) {1'b1}}, {(SEGMENT_W + 1) {1'b0}}};

    wire [WIDE_W-1:0] wide_step = {{(WIDE_W - STEP_W) {1'b0}}, s_step};
    wire              most      = (|wide_step[WIDE_W-1:W]) || (&wide_step[W-1:SEGMENT_W+1]);  // KEEP or more
    wire [W-1:0]      counting  = most ? KEEP : wide_step[W-1:0];

    reg                  held, held_access;
    reg  [COUNT_W-1:0]   segments_left;  // whole ones, before the rest of the token's steps

    // ---- time --------------------------------------------------------------------------------------------------------

    reg  [COUNT_W-1:0]   segment;
    reg  [SEGMENT_W-1:0] place;          // within it
    reg  [SEGMENT_W:0]   sum;            // the place after the rest of the steps of the token held; without one, the place
    reg                  issued, walked; // all visits of this segment: on their way, done

    wire                 far         = segments_left != {COUNT_W{1'b0}};
    wire                 crosses     = far || sum[SEGMENT_W];
    wire                 goes        = held && !clearing && (walked || !crosses);
    wire [COUNT_W-1:0]   new_segment = segment + {{(COUNT_W - 1) {1'b0}}, goes && crosses};
    wire [SEGMENT_W-1:0] new_place   = (goes && !far) ? sum[SEGMENT_W-1:0] : place;

    assign enters  = goes && !far;
    assign access  = enters && held_access;
    assign now     = {new_segment, new_place};
    assign visits  = !issued && !access;
    assign s_ready = advance && !clearing && (enters || !held);
    assign waits   = held;

    always @(posedge clk) begin
        if (advance) begin
            segment <= new_segment;
            place   <= new_place;
            if (goes && far) segments_left <= segments_left - 1'b1;
            if (enters || !held) begin
                held          <= s_valid && !clearing;
                held_access   <= s_access;
                segments_left <= counting[W-1:SEGMENT_W];
                sum           <= {1'b0, sum[SEGMENT_W-1:0]} + {1'b0, (s_valid && !clearing) ? counting[SEGMENT_W-1:0] : NONE};
            end

            if (visits) begin
                row    <= row + 1'b1;
                issued <= row == LAST[ROW_W-1:0];
            end
            if (visited && missed) begin
                row    <= visited_row;
                issued <= 1'b0;
            end
            if (visited && !missed && visited_row == LAST[ROW_W-1:0]) begin
                walked   <= 1'b1;
                clearing <= 1'b0;
            end
            if (goes && crosses) begin
                row    <= {ROW_W{1'b0}};
                issued <= 1'b0;
                walked <= 1'b0;
            end
        end
        if (rst) begin
            held     <= 1'b0;
            segment  <= {COUNT_W{1'b0}};
            place    <= {SEGMENT_W{1'b0}};
            sum      <= {(SEGMENT_W + 1) {1'b0}};
            row      <= {ROW_W{1'b0}};
            issued   <= 1'b0;
            walked   <= 1'b0;
            clearing <= 1'b1;
        end
    end

endmodule

`default_nettype wire
