// SPDX-License-Identifier: Apache-2.0
// The slot that is worked on, but for its sides and times: what is counted of it, its state towards others, and the memory of all slots.
//
// Latency:    1 clock from a command, of which the next N_ev and new bins follow the lengths of the clock before it; then 3 clocks to
//             gain and room, 1 to look_due. From `at` to what memory has see motion_context.v.
// Throughput: a command per clock.
// Stall:      none, without a command everything stays.
// Reset:      births begin with id 0; nothing else is used before it was loaded or written.
// Combinational paths: none.
`default_nettype none

module motion_slot #(
    parameter SLOT_W = 3,
    parameter SIDE_W = 25,
    parameter PX_W   = 13,
    parameter REL_W  = 10,
    parameter SUP_W  = 16,
    parameter ID_W   = 32
) (
    input  wire                clk,
    input  wire                rst,

    input  wire [SLOT_W-1:0]   at,
    input  wire [SLOT_W-1:0]   from,         // box and window are of this slot
    input  wire [SLOT_W-1:0]   e_slot,       // what takes effect, of this one

    // commands
    input  wire                load,         // what memory has
    input  wire                begin_job,    // with it: the marks and the support that come with the job
    input  wire                unite,        // with it: both supports; all sides are marked, partners forgotten
    input  wire                seed,         // a candidate begins
    input  wire                offset,       // a correction: marks are cleared, looks counted
    input  wire                count,        // it is counted; the next N_ev
    input  wire                begin_bins,   // new bins are begun
    input  wire                pair,         // `at` is the partner in this step
    input  wire                part,         // there is none
    input  wire                meet,         // what it meets was found
    input  wire                keep,         // the state is written,
    input  wire                keep_window,  // box and window,
    input  wire                keep_id,      // the next id, or with `resume` that of the slot that `at` has left,
    input  wire                resume,
    input  wire                ask_start,    // the start is read, else the id
    input  wire                on_y,         // the start of which axis is read, or written
    input  wire                read_y,       // of which axis sides, refs and moves are read
    input  wire                keep_start,   // the place at the fourth correction
    input  wire                finish,       // what takes effect

    // operands
    input  wire [SUP_W-1:0]    job_owned,
    input  wire [3:0]          job_marks,
    input  wire                sides_y,      // axes in turn: see motion_context.v
    input  wire [2*SIDE_W-1:0] sides,
    input  wire [2*SIDE_W-1:0] refs,
    input  wire                moves_y,
    input  wire [2*SIDE_W-1:0] moves,        // how far sides move as they take effect
    input  wire [1:0]          state,
    input  wire [PX_W-1:0]     length_x,
    input  wire [PX_W-1:0]     length_y,
    input  wire                meets_now,
    input  wire [3:0]          hidden_now,
    input  wire [31:0]         v,            // y, x
    input  wire [23:0]         usual,
    input  wire [4*PX_W-1:0]   box,
    input  wire [4*PX_W-1:0]   window,
    input  wire [2*REL_W-1:0]  middle,       // of the box, half pixels, y and x
    input  wire                ran,          // run_next is that of x; in the next clock, of y
    input  wire [3:0]          run_next,
    input  wire [SIDE_W:0]     start,        // sum of both sides
    input  wire [9:0]          nev_low,
    input  wire [9:0]          nev_high,
    input  wire                burst,        // of a correction: its event is within a burst
    input  wire [3:0]          gain_log2,
    input  wire [2:0]          gain_slow,
    input  wire [3:0]          gain_fast,
    input  wire [7:0]          gap_corrections,

    // the slot
    output reg  [SUP_W-1:0]    support,
    output reg  [5:0]          corrections,
    output reg  [3:0]          gain,
    output reg  [3:0]          room,         // so much of it corrections that go one way may take off
    output reg  [7:0]          runs,         // how many did, y and x
    output reg                 look_due,     // with the next correction bins are looked at, and cleared,
    output reg                 merged,       // or only cleared
    output reg                 meets,
    output reg  [3:0]          hidden,       // sides: hi and lo of y, hi and lo of x
    output reg  [3:0]          marks,
    output reg  [9:0]          n_ev,
    output reg  [15:0]         together,
    output reg  [9:0]          log2,         // of bins, y and x

    // what memory has
    output wire [2*SIDE_W-1:0] q_sides,
    output wire [2*SIDE_W-1:0] q_refs,
    output wire [2*SIDE_W-1:0] q_moves,
    output wire [SUP_W-1:0]    q_support,
    output wire                q_meets,
    output wire [31:0]         q_v,
    output wire [23:0]         q_usual,
    output wire [ID_W-1:0]     q_id,
    output wire [SIDE_W:0]     q_start,
    output wire [4*PX_W-1:0]   p_box,
    output wire [4*PX_W-1:0]   p_window,

    // what takes effect
    output wire [1:0]          e_state,
    output wire [4*SIDE_W-1:0] e_moves,
    output wire [3:0]          e_marks,
    output wire [3:0]          e_hidden,
    output wire [2*REL_W-1:0]  e_middle,
    output wire [9:0]          e_n_ev
);

    reg  [7:0]        looked;
    reg               has_partner;
    reg  [SLOT_W-1:0] partner;
    reg  [ID_W-1:0]   births;
    wire [15:0]       next_together;
    reg  [PX_W:0]     outline;
    reg  [9:0]        next_log2;

    wire [5:0]        q_corrections;
    wire [7:0]        q_looked;
    wire [3:0]        q_hidden;
    wire              q_has_partner;
    wire [SLOT_W-1:0] q_partner;
    wire [15:0]       q_together;
    wire [7:0]        q_runs;
    reg               ran_x;       // run_next is that of y
    wire [9:0]        q_n_ev, q_log2;

    reg  [5:0]     slow;        // corrections, slower
    reg  [3:0]     least_gain;  // g, alone
    wire           q_merged;
    wire [SUP_W:0] sum_support = {1'b0, q_support} + {1'b0, unite ? support : begin_job ? job_owned : {SUP_W{1'b0}}};

    motion_context #(
        .SLOT_W(SLOT_W),
        .SIDE_W(SIDE_W),
        .PX_W  (PX_W),
        .REL_W (REL_W),
        .SUP_W (SUP_W),
        .ID_W  (ID_W)
    ) u_context (
        .clk          (clk),
        .at           (at),
        .from         (from),
        .e_slot       (e_slot),
        .keep         (keep),
        .keep_window  (keep_window),
        .keep_id      (keep_id),
        .ask_start    (ask_start),
        .on_y         (on_y),
        .read_y       (read_y),
        .keep_start   (keep_start),
        .finish       (finish),
        .sides_y      (sides_y),
        .sides        (sides),
        .refs         (refs),
        .moves_y      (moves_y),
        .moves        (moves),
        .support      (support),
        .merged       (merged),
        .marks        (marks),
        .state        (state),
        .v            (v),
        .corrections  (corrections),
        .looked       (looked),
        .meets        ({hidden, meets}),
        .runs         (runs),
        .n_ev         (n_ev),
        .has_partner  (has_partner),
        .partner      (partner),
        .together     (together),
        .usual        (usual),
        .box          (box),
        .window       (window),
        .middle       (middle),
        .id           (resume ? q_id : births),
        .start        (start),
        .log2         (log2),
        .q_sides      (q_sides),
        .q_refs       (q_refs),
        .q_moves      (q_moves),
        .q_support    (q_support),
        .q_merged     (q_merged),
        .q_v          (q_v),
        .q_corrections(q_corrections),
        .q_looked     (q_looked),
        .q_meets      ({q_hidden, q_meets}),
        .q_runs       (q_runs),
        .q_n_ev       (q_n_ev),
        .q_has_partner(q_has_partner),
        .q_partner    (q_partner),
        .q_together   (q_together),
        .q_usual      (q_usual),
        .q_log2       (q_log2),
        .q_id         (q_id),
        .q_start      (q_start),
        .p_box        (p_box),
        .p_window     (p_window),
        .e_state      (e_state),
        .e_moves      (e_moves),
        .e_marks      (e_marks),
        .e_hidden     (e_hidden),
        .e_middle     (e_middle),
        .e_n_ev       (e_n_ev)
    );

    motion_sum #(
        .W(16)
    ) u_together (
        .adds (part || (has_partner && partner == at)),
        .a    (together),
        .minus(part),
        .b    (16'd1),
        .y    (next_together)
    );

    // Of events until the next correction: as many as pixels, within limits.
    wire       few  = outline < {{(PX_W - 9) {1'b0}}, nev_low};
    wire       many = {{(PX_W - 9) {1'b0}}, nev_high} < outline;
    wire [9:0] next_n_ev;

    mux4 #(
        .W(10)
    ) u_n_ev (
        .select(load ? 2'd3 : seed || few ? 2'd2 : {1'b0, many}),
        .words ({q_n_ev, nev_low, nev_high, outline[9:0]}),
        .y     (next_n_ev)
    );

    // Bins of 2^n pixels, eight to sixteen for the whole side.
    function [4:0] log2_of;
        input [PX_W-1:0] length;
        integer k;
        begin
            log2_of = 5'd0;
            for (k = 5; k <= PX_W; k = k + 1) if (length[k-1]) log2_of = k[4:0] - 5'd4;
        end
    endfunction

    always @(posedge clk) begin
        slow     <= corrections >> gain_slow;
        least_gain <= burst ? 4'd1 : slow < {2'd0, gain_log2} ? slow[3:0] + 4'd1 : gain_log2;
        gain     <= least_gain + {3'd0, meets};
        room     <= meets ? 4'd0 : burst ? 4'd1 : gain_fast == 4'd0 || least_gain < gain_fast ? 4'd0 : least_gain - gain_fast;
        look_due <= gap_corrections != 8'd0 && (merged || !({1'b0, looked} + 9'd1 < {1'b0, gap_corrections}));
        next_log2 <= {log2_of(length_y), log2_of(length_x)};
        outline  <= {1'b0, length_x} + {1'b0, length_y};

        if (load || seed || count) n_ev <= next_n_ev;
        if (load) begin
            marks       <= begin_job ? job_marks : 4'd0;
            support     <= sum_support[SUP_W] ? {SUP_W{1'b1}} : sum_support[SUP_W-1:0];
            merged      <= q_merged;
            hidden      <= q_hidden;
            meets       <= q_meets;
            runs        <= q_runs;
            corrections <= q_corrections;
            looked      <= q_looked;
            has_partner <= q_has_partner;
            partner     <= q_partner;
            together    <= q_together;
            log2        <= q_log2;
        end
        if (seed) begin
            support     <= {{(SUP_W - 1) {1'b0}}, 1'b1};
            marks       <= 4'd0;
            hidden      <= 4'd0;
            meets       <= 1'b0;
            runs        <= 8'd0;
            corrections <= 6'd0;
        end
        if (offset) begin
            marks <= 4'd0;
            if (gap_corrections != 8'd0) looked <= looked + 8'd1;
        end
        if (count) begin
            if (corrections != 6'd63) corrections <= corrections + 6'd1;
        end
        if (begin_bins) begin
            looked <= 8'd0;
            merged <= 1'b0;
            log2   <= next_log2;
        end
        ran_x <= ran;
        if (ran) runs[3:0] <= run_next;
        if (ran_x) runs[7:4] <= run_next;
        if (pair) begin
            has_partner <= 1'b1;
            partner     <= at;
        end
        if (pair || (part && together != 16'd0)) together <= next_together;
        if (meet) begin
            meets  <= meets_now;
            hidden <= hidden_now;
        end
        if (unite) {merged, marks} <= 5'h1f;
        if (seed || unite) begin
            has_partner <= 1'b0;
            together    <= 16'd0;
        end
        if (keep_id && !resume) births <= births + {{(ID_W - 1) {1'b0}}, 1'b1};
        if (rst) births <= {ID_W{1'b0}};
    end

endmodule

`default_nettype wire
