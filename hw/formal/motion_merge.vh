// SPDX-License-Identifier: Apache-2.0
/*
[properties]
ends = "two slots are one 55 clocks after the start at most, besides waits for masks and records"

[[tasks]]
name = "8 slots"
parameters = { SLOT_W = 3 }
k = 1
covers_within = 60
quick = true

[[tasks]]
name = "64 slots"
parameters = { SLOT_W = 6 }
k = 1
covers_within = 1
only = []

[[faults]]
meaning = "the sides are waited for for one clock more"
right = "pause     <= clocks(3'd1);\n                state     <= COVER;"
wrong = "pause     <= clocks(3'd2);\n                state     <= COVER;"
breaks = ["ends"]
since = 55
within = 60
*/
// The clocks from `start` to `done`. For each state, f_left is how many clocks are left at most.
//
// What is assumed of the parts around is proven in motion_work.vh: a slot is read four clocks after it is asked for, the window is there
// after six, and `lane` changes in each clock in which no slot is loaded.
reg       f_was_rst, f_ok, f_was_lane;
reg       f_job;
reg [6:0] f_clocks;  // since start, without waits
reg [4:1] f_read;    // so many clocks ago a slot was asked for,
reg [6:1] f_window;  // and a window

always @* assume (!f_past || f_ok || rst);
always @* assume (!start || rests);
always @* assume (read_done == f_read[4]);
always @* assume (window_done == f_window[6]);
always @* assume (state != END || lane == !f_was_lane);

wire f_stall = goes_on && (((state == SAY_END || state == SAY) && !record_free) || (state == PLACE && mask_busy));

always @(posedge clk) begin
    f_was_rst  <= rst;
    f_ok       <= rst ? f_was_rst && f_past : f_ok;
    f_was_lane <= lane;
    f_job      <= start || (f_job && !done);
    f_clocks   <= start ? 7'd1 : f_clocks + {6'd0, f_job && !f_stall};
    f_read     <= {f_read[3:1], fetch};
    f_window   <= {f_window[5:1], c_window};
    if (rst) begin
        f_job    <= 1'b0;
        f_read   <= 4'd0;
        f_window <= 6'd0;
    end
end

function [6:0] f_count;  // of a pause
    input [6:0] ones;
    f_count = ones[6] ? 7'd7 : ones[5] ? 7'd6 : ones[4] ? 7'd5 : ones[3] ? 7'd4 : ones[2] ? 7'd3 : ones[1] ? 7'd2 : {6'd0, ones[0]};
endfunction

wire [6:0] f_p = f_count(pause);
wire [6:0] f_r = f_read[4] ? 7'd0 : f_read[3] ? 7'd1 : f_read[2] ? 7'd2 : f_read[1] ? 7'd3 : 7'd4;  // until a slot is read
wire [6:0] f_w = f_window[6] ? 7'd0 : f_window[5] ? 7'd1 : f_window[4] ? 7'd2 : f_window[3] ? 7'd3 : f_window[2] ? 7'd4
               : f_window[1] ? 7'd5 : 7'd6;                                                         // until the window is there
wire       f_reads = state == GOES || state == UNITE;

reg [6:0] f_left;
always @* begin
    f_left = 7'd0;
    case (state)
        BEGIN:   f_left = f_p + 7'd54;
        SAVED:   f_left = f_p + 7'd51;
        GOES:    f_left = f_r + 7'd46;
        GONE:    f_left = f_p + 7'd45;
        STAYS:   f_left = f_p + 7'd41;
        SAY_END: f_left = f_p + 7'd36;
        END:     f_left = goes_on ? 7'd34 + {6'd0, lane} : f_p + 7'd35;
        RETURN:  f_left = f_p + 7'd33;
        READ:    f_left = f_p + 7'd32;
        UNITE:   f_left = f_r + 7'd27;
        COVER:   f_left = f_p + 7'd25;
        COVERED: f_left = f_p + 7'd23;
        LATER:   f_left = f_p + 7'd17;
        PLACE:   f_left = f_p + 7'd11;
        WINDOW:  f_left = f_w + 7'd4;
        WRITE:   f_left = f_p + 7'd3;
        SAY:     f_left = f_p + 7'd2;
        WRITTEN: f_left = f_p + 7'd1;
        default: f_left = 7'd0;
    endcase
end

wire [4:0] f_reading = {fetch, f_read};
wire [6:0] f_placing = {c_window, f_window};

always @* if (f_past) begin
    i_begin: assert (f_ok || (f_was_rst && state == REST && rests && goes_on));
end

always @* if (f_past && f_ok) begin
    p_ends:  assert (!f_job || f_clocks <= 7'd55);

    i_job:   assert (rests == (state == REST) && f_job == (!rests || done) && (!done || rests) && (!f_was_rst || (rests && !done))
                     && state <= BEGIN && state != 5'd1 && state != 5'd14);
    i_pause: assert ((pause & (pause + 7'd1)) == 7'd0 && (goes_on || !(state == REST || f_reads || state == WINDOW)));
    i_read:  assert ((f_reading & (f_reading - 5'd1)) == 5'd0 && (f_reading != 5'd0) == f_reads);
    i_place: assert ((f_placing & (f_placing - 7'd1)) == 7'd0 && (f_placing != 7'd0) == (state == WINDOW));
    i_left:  assert (!f_job || f_clocks + f_left <= 7'd55);

    c_ends:  cover (f_job && done && f_clocks == 7'd55);
end
