// SPDX-License-Identifier: Apache-2.0
// What events do not change of a slot: memories that are read at one slot, all at once, and written in groups.
//
// Latency:    1 clock from `at` to what it has; box and window from `place`, which is `put_slot` while one is put in force.
// Throughput: a slot per clock.
// Stall:      none.
// Reset:      none, nothing is used before it was written.
// Combinational paths: none.
`default_nettype none

module motion_context #(
    parameter SLOT_W = 3,
    parameter SIDE_W = 25,
    parameter PX_W   = 13,
    parameter ID_W   = 32,
    parameter TIME_W = 48
) (
    input  wire                clk,
    input  wire [SLOT_W-1:0]   at,
    input  wire                puts,         // box, window and N_ev are those of put_slot
    input  wire [SLOT_W-1:0]   put_slot,

    input  wire                keep,         // the state is written,
    input  wire                keep_times,   // the times of a correction,
    input  wire                keep_deadline,
    input  wire                keep_window,
    input  wire                keep_seed,    // the time of the seed,
    input  wire                keep_report,  // of a record,
    input  wire                keep_id,
    input  wire                keep_start,   // the place at the fourth correction,
    input  wire                keep_log2,    // the size of bins

    input  wire [31:0]         v,            // y, x
    input  wire [4*SIDE_W-1:0] refs,         // lo and hi of x, lo and hi of y
    input  wire [5:0]          corrections,
    input  wire [7:0]          looked,
    input  wire [4:0]          meets,        // hidden sides, and whether it does
    input  wire [9:0]          n_ev,
    input  wire                has_partner,
    input  wire [SLOT_W-1:0]   partner,
    input  wire [15:0]         together,
    input  wire [TIME_W-1:0]   now,
    input  wire [23:0]         usual,
    input  wire [TIME_W-1:0]   deadline,
    input  wire [4*PX_W-1:0]   box,
    input  wire [4*PX_W-1:0]   window,
    input  wire [ID_W-1:0]     id,
    input  wire [2*SIDE_W+1:0] start,        // sums of both sides, x, y
    input  wire [9:0]          log2,

    output reg  [31:0]         q_v,
    output reg  [4*SIDE_W-1:0] q_refs,
    output reg  [5:0]          q_corrections,
    output reg  [7:0]          q_looked,
    output reg  [4:0]          q_meets,
    output reg  [9:0]          q_n_ev,
    output reg                 q_has_partner,
    output reg  [SLOT_W-1:0]   q_partner,
    output reg  [15:0]         q_together,
    output reg  [TIME_W-1:0]   q_last,
    output reg  [23:0]         q_usual,
    output reg  [TIME_W-1:0]   q_deadline,
    output reg  [TIME_W-1:0]   q_seeded,
    output reg  [TIME_W-1:0]   q_reported,
    output reg  [ID_W-1:0]     q_id,
    output reg  [2*SIDE_W+1:0] q_start,
    output reg  [9:0]          q_log2,
    output reg  [4*PX_W-1:0]   p_box,
    output reg  [4*PX_W-1:0]   p_window,
    output reg  [9:0]          p_n_ev
);

    localparam STATE_W = 4 * SIDE_W + SLOT_W + 78;
    localparam DEPTH   = 1 << SLOT_W;

    reg [STATE_W-1:0]    states   [0:DEPTH-1];
    reg [TIME_W+23:0]    times    [0:DEPTH-1];
    reg [TIME_W-1:0]     deadlines[0:DEPTH-1];
    reg [8*PX_W-1:0]     windows  [0:DEPTH-1];
    reg [9:0]            n_evs    [0:DEPTH-1];
    reg [TIME_W-1:0]     seeds    [0:DEPTH-1];
    reg [TIME_W-1:0]     reports  [0:DEPTH-1];
    reg [ID_W-1:0]       ids      [0:DEPTH-1];
    reg [2*SIDE_W+1:0]   starts   [0:DEPTH-1];
    reg [9:0]            log2s    [0:DEPTH-1];

    wire [SLOT_W-1:0] place = puts ? put_slot : at;

    always @(posedge clk) begin
        {q_v, q_refs, q_corrections, q_looked, q_meets, q_n_ev, q_has_partner, q_partner, q_together} <= states[at];
        {q_last, q_usual} <= times[at];
        q_deadline <= deadlines[at];
        q_seeded   <= seeds[at];
        q_reported <= reports[at];
        q_id       <= ids[at];
        q_start    <= starts[at];
        q_log2     <= log2s[at];
        {p_box, p_window} <= windows[place];
        p_n_ev     <= n_evs[place];
        if (keep) begin
            states[at] <= {v, refs, corrections, looked, meets, n_ev, has_partner, partner, together};
            n_evs[at]  <= n_ev;
        end
        if (keep_times) times[at] <= {now, usual};
        if (keep_deadline) deadlines[at] <= deadline;
        if (keep_window) windows[at] <= {box, window};
        if (keep_seed) seeds[at] <= now;
        if (keep_report) reports[at] <= now;
        if (keep_id) ids[at] <= id;
        if (keep_start) starts[at] <= start;
        if (keep_log2) log2s[at] <= log2;
    end

endmodule

`default_nettype wire
