// SPDX-License-Identifier: Apache-2.0
// A correction, or a candidate that begins, in order: what the other parts of motion_work.v do, and when.
//
// Commands to motion_sides.v are given while `lane` is high, so they are decided while it is low; how many clocks lie between two of them
// is written there.
//
// Latency:    from start to done 23 to 40 clocks for a correction, 37 to 178 with a look for gaps; 30 or 31 for a candidate that begins.
// Throughput: one at a time.
// Stall:      waits for the leading bit of the time, for masks of the job before to be written, and for its record to be accepted.
// Reset:      waits for a start.
// Combinational paths: none.
`default_nettype none

module motion_correct #(
    parameter SLOT_W = 3
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              start,        // nothing else is being done
    input  wire              seed,         // it is a candidate that begins
    input  wire [SLOT_W-1:0] slot,
    output wire              done,
    output reg               rests,
    output reg  [SLOT_W-1:0] at,

    input  wire              read_done,    // the slot was read
    output reg               op_clear,     // bin op_bin is cleared
    output reg  [3:0]        op_bin,

    // what decides
    input  wire              lane,
    input  wire              visible,      // the slot is, two clocks behind `at`
    input  wire              shrinks,      // with q_meets, which is what memory has: sides shrink
    input  wire              q_meets,
    input  wire [5:0]        corrections,
    input  wire              look_due,
    input  wire              merged,       // with it: bins are only cleared
    input  wire              instant,      // no more than a tick since the last correction
    input  wire              resting,      // its velocity is 0
    input  wire              looks,        // at axis look_y
    input  wire              look_done,
    input  wire              gap_found,
    input  wire              low_stays,
    input  wire              inverse_goes_on,  // in the next clock its leading bit is still looked for
    input  wire              window_done,
    input  wire              mask_busy,    // the window of another slot is still being written to masks, and must stay
    input  wire              record_free,

    // commands
    output wire              load,         // the slot is being read: it is loaded
    output reg               c_seed,
    output reg               c_shrink,
    output reg               c_cut_high,
    output reg               c_cut_low,
    output reg               c_order,
    output reg               c_offset,
    output reg               c_reflect,    // places in place of offsets, which stay
    output reg               c_settle,
    output reg               c_inverse,
    output reg               c_speed,
    output reg               c_times,
    output reg               c_count,
    output reg               c_bins,
    output reg               c_window,
    output reg               c_note,
    output reg               look,
    output reg               look_y,
    output reg               say,          // the record is taken
    output reg  [1:0]        since,        // see motion_times.v
    output reg               keep,
    output reg               keep_now,
    output reg               keep_until,
    output reg               keep_window,
    output reg               keep_start
);

    localparam [1:0] LAST     = 2'd0;
    localparam [1:0] SEEDED   = 2'd1;
    localparam [1:0] REPORTED = 2'd2;

    localparam [4:0] REST    = 5'd0;   // waits for a job
    localparam [4:0] SEED    = 5'd1;   // a candidate begins
    localparam [4:0] SEED_1  = 5'd2;
    localparam [4:0] SEED_2  = 5'd3;
    localparam [4:0] LOAD    = 5'd5;   // a correction: the slot is being read
    localparam [4:0] SHRINK  = 5'd6;   // how far sides move inwards
    localparam [4:0] OFFSET  = 5'd7;   // offsets in place of places
    localparam [4:0] LOOK    = 5'd8;   // bins are looked at
    localparam [4:0] LOOK_AT = 5'd9;   // on which axes?
    localparam [4:0] LOOK_GO = 5'd10;  // each axis
    localparam [4:0] LOOKING = 5'd11;
    localparam [4:0] CUT     = 5'd12;
    localparam [4:0] ORDER   = 5'd13;
    localparam [4:0] ORDERED = 5'd14;
    localparam [4:0] LOOKED  = 5'd15;  // begins new bins
    localparam [4:0] CLEAR   = 5'd16;  // clears them
    localparam [4:0] SPEED   = 5'd17;  // waits for the leading bit of the time
    localparam [4:0] TURN    = 5'd18;  // waits for the velocity
    localparam [4:0] COUNT   = 5'd19;  // the next N_ev
    localparam [4:0] SAY     = 5'd20;  // hands over a record
    localparam [4:0] PLACE   = 5'd21;  // box and window
    localparam [4:0] WINDOW  = 5'd22;  // waits for them
    localparam [4:0] KEPT    = 5'd23;

    reg [4:0] state;
    reg [6:0] pause;             // a one for each clock until the state is gone on with
    reg       seeds;             // it is a candidate that begins
    reg       reads;             // the slot is being read
    wire      goes_on = !pause[0];
    reg       lane_next;         // `lane` in the next clock: it changes in each but while a slot is being read
    reg       may_turn;          // it is high in the next clock, and the leading bit of the time is known
    reg       turns;             // its velocity is corrected
    reg       old;               // and it may be looked at

    assign load  = reads;
    assign done  = state == KEPT;

    // As many ones as clocks until the state is gone on with.
    function [6:0] clocks;
        input [2:0] number;
        clocks = ~(7'h7f << number);
    endfunction

    always @(posedge clk) begin
        {c_seed, c_shrink, c_cut_high, c_cut_low, c_order, c_offset, c_reflect, c_settle, c_inverse, c_speed} <= 10'd0;
        {c_times, c_count, c_bins, c_window, c_note, look} <= 6'd0;
        {keep, keep_now, keep_until, keep_window, keep_start, say} <= 6'd0;
        lane_next <= lane;
        may_turn  <= lane && !inverse_goes_on;
        turns <= corrections >= 6'd2 && !instant;
        old   <= corrections >= 6'd8 && !merged;
        if (op_clear) op_bin <= op_bin + 4'd1;
        if (&op_bin) op_clear <= 1'b0;

        pause <= {1'b0, pause[6:1]};
        if (goes_on) case (state)
            REST: begin
                since  <= LAST;
                at     <= slot;
                seeds  <= seed;
                look_y <= 1'b0;
                reads  <= start && !seed;
                if (start) begin
                    rests <= 1'b0;
                    pause <= clocks(3'd1);  // what comes with the job is on its way
                    state <= SEED;
                    if (!seed) begin
                        pause <= 7'd0;
                        state <= LOAD;
                    end
                end
            end

            SEED:
            if (lane_next) begin
                c_seed   <= 1'b1;
                since    <= SEEDED;
                keep_now <= 1'b1;
                pause    <= clocks(3'd3);
                state    <= SEED_1;
            end
            SEED_1: begin
                c_settle <= 1'b1;
                pause    <= clocks(3'd5);
                state    <= SEED_2;
            end
            SEED_2: begin
                c_bins <= 1'b1;
                state  <= CLEAR;
            end

            LOAD:
            if (read_done) begin  // then the time since the last correction is there, too
                c_inverse <= 1'b1;
                reads     <= 1'b0;
                pause     <= clocks(3'd1);
                state     <= !q_meets && shrinks ? SHRINK : OFFSET;
            end
            SHRINK: begin
                c_shrink <= 1'b1;
                pause    <= clocks(3'd1);
                state    <= OFFSET;
            end
            OFFSET: begin
                c_offset <= 1'b1;
                state    <= look_due ? LOOK : SPEED;
            end

            LOOK: begin
                pause <= clocks(3'd7);
                state <= LOOK_AT;
            end
            LOOK_AT: begin
                c_note <= 1'b1;
                pause  <= clocks(3'd3);
                state  <= old && !resting ? LOOK_GO : LOOKED;
            end
            LOOK_GO:
            if (looks) begin
                look  <= 1'b1;
                state <= LOOKING;
            end else begin
                look_y <= 1'b1;
                pause  <= clocks(3'd2);
                state  <= look_y ? LOOKED : LOOK_GO;
            end
            LOOKING:
            if (look_done) begin
                state <= CUT;
                if (!gap_found) begin
                    look_y <= 1'b1;
                    pause  <= clocks(3'd2);
                    state  <= look_y ? LOOKED : LOOK_GO;
                end
            end
            CUT:
            if (lane_next) begin
                c_cut_high <= low_stays;
                c_cut_low  <= !low_stays;
                pause      <= clocks(3'd5);
                state      <= ORDER;
            end
            ORDER: begin
                c_order <= !low_stays;
                pause   <= clocks(3'd1);  // the command is of this axis for two clocks
                state   <= ORDERED;
            end
            ORDERED: begin
                look_y <= 1'b1;
                pause  <= clocks(3'd6);
                state  <= look_y ? LOOKED : LOOK_GO;
            end
            LOOKED: begin
                c_bins <= 1'b1;
                state  <= CLEAR;
            end
            CLEAR: begin  // bins are cleared until they count again
                op_clear <= 1'b1;
                op_bin   <= 4'd0;
                state    <= seeds ? PLACE : SPEED;
            end

            SPEED:
            if (may_turn) begin
                c_speed   <= turns;
                c_settle  <= !instant;
                c_reflect <= instant;
                c_times   <= 1'b1;
                pause     <= turns ? clocks(3'd7) : clocks(3'd2);
                state    <= TURN;
            end
            TURN: begin
                pause <= turns ? clocks(3'd5) : clocks(3'd1);
                state <= COUNT;
            end
            COUNT: begin
                c_count    <= 1'b1;
                keep_start <= corrections == 6'd3;
                pause      <= turns ? clocks(3'd2) : clocks(3'd1);
                state      <= visible ? SAY : PLACE;
            end
            SAY:
            if (record_free) begin
                say      <= 1'b1;
                since    <= REPORTED;
                keep_now <= 1'b1;
                state    <= PLACE;
            end

            PLACE:
            if ((!op_clear || op_bin[3]) && !mask_busy) begin  // the rest is cleared in time
                c_window <= 1'b1;
                state    <= WINDOW;
            end
            WINDOW:
            if (window_done) begin
                since       <= LAST;
                keep        <= 1'b1;
                keep_now    <= 1'b1;
                keep_window <= 1'b1;
                state       <= KEPT;
            end
            KEPT: begin
                keep_until <= 1'b1;
                rests      <= 1'b1;
                state      <= REST;
            end
            default: state <= REST;
        endcase

        if (rst) begin
            state    <= REST;
            rests    <= 1'b1;
            pause    <= 7'd0;
            reads    <= 1'b0;
            op_clear <= 1'b0;
        end
    end

endmodule

`default_nettype wire
