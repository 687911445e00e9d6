// SPDX-License-Identifier: Apache-2.0
// Two slots that become one, in order: docs/motion.md, rule M4. The one whose step it is, is being worked on; then the other one may be
// read, and at last the one that stays, whose sides are made to cover both.
//
// Commands to motion_sides.v are given while `lane` is high, so they are decided while it is low.
//
// Latency:    52 to 55 clocks from start to done.
// Throughput: one at a time.
// Stall:      waits for its records to be accepted, and for masks of the window before to be written.
// Reset:      waits for a start.
// Combinational paths: none.
`default_nettype none
`include "evcot_defs.vh"

module motion_merge #(
    parameter SLOT_W = 3,
    parameter ID_W   = 32
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              start,
    input  wire [SLOT_W-1:0] stays,
    input  wire [SLOT_W-1:0] goes,
    output reg               rests,
    output reg               done,
    output reg  [SLOT_W-1:0] at,

    output reg               fetch,        // the slot `at` is read,
    input  wire              read_done,    // and was

    // what decides
    input  wire              lane,
    input  wire [1:0]        at_state,     // of `at`, two clocks late: free, candidate, visible, left
    input  wire              later,        // the deadline that is held is not before that of `at`
    input  wire              window_done,
    input  wire              mask_busy,    // the window before is still being written to masks, and must stay
    input  wire              record_free,
    input  wire [ID_W-1:0]   id,

    // commands
    output wire              load,         // the one that goes is being read,
    output wire              unite,        // the one that stays
    output reg               c_settle,
    output reg               c_reflect,
    output reg               c_cover,
    output reg               c_window,
    output reg               c_hold,       // the deadline of the one that goes
    output reg               lapse,
    output reg               say,          // the record is taken
    output reg  [1:0]        kind,
    output reg  [ID_W-1:0]   stays_id,
    output reg               keep,
    output reg               keep_now,
    output reg               keep_until,
    output reg               keep_window
);

    localparam [1:0] VISIBLE = 2'd2;   // state of a slot

    localparam [4:0] REST    = 5'd0;   // waits for a start
    localparam [4:0] SAVED   = 5'd2;   // reads the one that goes
    localparam [4:0] GOES    = 5'd3;
    localparam [4:0] GONE    = 5'd4;   // the id of the one that stays, then a record
    localparam [4:0] STAYS   = 5'd5;
    localparam [4:0] SAY_END = 5'd6;
    localparam [4:0] END     = 5'd7;   // keeps its sides
    localparam [4:0] RETURN  = 5'd8;   // reads the one that stays
    localparam [4:0] READ    = 5'd9;
    localparam [4:0] UNITE   = 5'd10;
    localparam [4:0] COVER   = 5'd11;  // they cover both
    localparam [4:0] COVERED = 5'd12;
    localparam [4:0] LATER   = 5'd13;  // the deadline
    localparam [4:0] PLACE   = 5'd15;  // box and window
    localparam [4:0] WINDOW  = 5'd16;
    localparam [4:0] WRITE   = 5'd17;  // writes it back
    localparam [4:0] SAY     = 5'd18;  // hands over a record
    localparam [4:0] WRITTEN = 5'd19;
    localparam [4:0] BEGIN   = 5'd20;  // writes back the one that stays

    reg [4:0] state;
    reg [6:0] pause;       // a one for each clock until the state is gone on with
    reg       goes_visible;
    reg       reads, unites;  // the one that goes is being read; the one that stays is
    wire      goes_on = !pause[0];

    assign load  = reads;
    assign unite = unites;

    // As many ones as clocks until the state is gone on with.
    function [6:0] clocks;
        input [2:0] number;
        clocks = ~(7'h7f << number);
    endfunction

    always @(posedge clk) begin
        {c_settle, c_reflect, c_cover, c_window, c_hold, lapse, done, fetch} <= 8'd0;
        {keep, keep_now, keep_until, keep_window, say} <= 5'd0;

        pause <= {1'b0, pause[6:1]};
        if (goes_on) case (state)
            REST: begin
                at <= stays;
                if (start) begin
                    rests <= 1'b0;
                    state <= BEGIN;
                end
            end
            BEGIN: begin
                keep  <= 1'b1;
                pause <= clocks(3'd2);
                state <= SAVED;
            end
            SAVED: begin
                at    <= goes;
                fetch <= 1'b1;
                reads <= 1'b1;
                state <= GOES;
            end
            GOES:
            if (read_done) begin
                reads        <= 1'b0;
                goes_visible <= at_state == VISIBLE;
                state        <= GONE;
            end

            GONE: begin
                c_hold <= 1'b1;
                at     <= stays;
                pause  <= clocks(3'd3);
                state  <= STAYS;
            end
            STAYS: begin
                stays_id <= id;
                at       <= goes;
                kind     <= `EVCOT_KIND_MERGED;
                pause    <= clocks(3'd4);  // its stated velocity
                state    <= goes_visible ? SAY_END : END;
            end
            SAY_END:
            if (record_free) begin
                say   <= 1'b1;
                state <= END;
            end
            END:
            if (!lane) begin
                c_settle <= 1'b1;
                lapse    <= 1'b1;
                state    <= RETURN;
            end

            RETURN: begin
                at    <= stays;
                state <= READ;
            end
            READ: begin
                fetch  <= 1'b1;
                unites <= 1'b1;
                state  <= UNITE;
            end
            UNITE:
            if (read_done) begin
                c_reflect <= 1'b1;
                unites    <= 1'b0;
                pause     <= clocks(3'd1);
                state     <= COVER;
            end
            COVER: begin
                c_cover <= 1'b1;
                pause   <= clocks(3'd1);
                state   <= COVERED;
            end
            COVERED: begin
                c_settle <= 1'b1;
                pause    <= clocks(3'd5);
                state    <= LATER;
            end
            LATER: begin
                keep_until <= later;
                pause      <= clocks(3'd5);
                state      <= PLACE;
            end

            PLACE:
            if (!mask_busy) begin
                c_window <= 1'b1;
                state    <= WINDOW;
            end
            WINDOW:
            if (window_done) begin
                keep_window <= 1'b1;
                state       <= WRITE;
            end
            WRITE: begin
                keep     <= 1'b1;
                kind     <= `EVCOT_KIND_MOVED;
                state    <= at_state == VISIBLE ? SAY : WRITTEN;
            end
            SAY:
            if (record_free) begin
                say      <= 1'b1;
                keep_now <= 1'b1;
                state    <= WRITTEN;
            end
            WRITTEN: begin
                done  <= 1'b1;
                rests <= 1'b1;
                state <= REST;
            end
            default: state <= REST;
        endcase

        if (rst) begin
            state    <= REST;
            rests    <= 1'b1;
            pause    <= 7'd0;
            reads    <= 1'b0;
            unites   <= 1'b0;
        end
    end

endmodule

`default_nettype wire
