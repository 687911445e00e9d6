// SPDX-License-Identifier: Apache-2.0
/*
[properties]
seed_ends = "a candidate that begins takes 31 clocks at most, besides waits for masks"
plain_ends = "a correction without a look for gaps takes 40 clocks at most, besides waits for masks and for its record"
look_ends = "a correction with a look for gaps takes 178 clocks at most, besides the same waits"

[[tasks]]
name = "8 slots"
parameters = { SLOT_W = 3 }
k = 1
covers_within = 180

[[tasks]]
name = "64 slots"
parameters = { SLOT_W = 6 }
k = 1
covers_within = 42
only = ["seed_ends", "plain_ends"]
quick = true

[[faults]]
task = "64 slots"
meaning = "the bins are waited for to the last one"
right = "(!op_clear || op_bin[3])"
wrong = "!op_clear"
breaks = ["seed_ends"]
since = 34
within = 36

[[faults]]
task = "64 slots"
meaning = "the velocity is waited for for too long"
right = "pause <= turns ? clocks(3'd5) : clocks(3'd1);"
wrong = "pause <= turns ? clocks(3'd7) : clocks(3'd1);"
breaks = ["plain_ends"]
since = 43
within = 46

[[faults]]
meaning = "the second axis is looked at again and again"
right = "state  <= look_y ? LOOKED : LOOK_GO;\n            end\n            LOOKING:"
wrong = "state  <= LOOK_GO;\n            end\n            LOOKING:"
breaks = ["look_ends"]
since = 184
within = 186
*/
// The clocks from `start` to `done`. For each state, f_left is how many clocks are left at most, so with those that have passed they are
// no more than the bound.
//
// What is assumed of the parts around is proven in motion_work.vh and motion_gaps.vh: the slot is read four clocks after start, `lane`
// changes in each clock but when the slot was read, the leading bit of the time is known seven clocks after it is asked for, the window
// is there after six, and a look for gaps takes 47 at most. A reset takes two clocks.
localparam [5:0] F_LOOK = 6'd47;

reg       f_was_rst, f_ok;                 // what was set before the first clock of a reset is over
reg [7:0] f_time = 8'd0;                   // covers are looked for in one clock, the first that is possible
reg       f_job, f_seed, f_looks;          // a correction, or a seed, is being computed; it is a seed; it has a look
reg [8:0] f_clocks;                        // since start, without waits
reg [4:1] f_read;                          // start of a correction, so many clocks ago
reg [6:1] f_window;                        // and c_window
reg       f_works, f_was_lane, f_loads;    // the clock before: a job begins or goes on, `lane`, and a slot is loaded
reg [2:0] f_inverse;                       // for so many clocks the leading bit may still be looked for
reg       f_looking;
reg [5:0] f_look;                          // clocks since look

always @* assume (!f_past || f_ok || rst);
always @* assume (!start || rests);
always @* assume (state != LOAD || read_done == f_read[4]);
always @* assume (state != WINDOW || window_done == f_window[6]);
always @* assume (!f_works || lane == (!f_was_lane || f_loads));
always @* assume (!inverse_goes_on || c_inverse || f_inverse != 3'd0);
always @* assume (!f_looking || f_look != F_LOOK || look_done);

wire f_stall = goes_on && ((state == SAY && !record_free) || (state == PLACE && mask_busy));

always @(posedge clk) begin
    f_was_rst  <= rst;
    f_ok       <= rst ? f_was_rst && f_past : f_ok;
    f_time     <= f_time + 8'd1;
    f_read     <= {f_read[3:1], start && !seed};
    f_window   <= {f_window[5:1], c_window};
    f_works    <= start || !rests;
    f_was_lane <= lane;
    f_loads    <= load && read_done;
    f_inverse  <= c_inverse ? 3'd6 : f_inverse == 3'd0 ? 3'd0 : f_inverse - 3'd1;
    f_look     <= look ? 6'd1 : f_look + {5'd0, f_looking};
    f_looking  <= (look || f_looking) && !look_done;
    f_clocks   <= start ? 9'd1 : f_clocks + {8'd0, f_job && !f_stall};
    f_job      <= start || (f_job && !done);
    f_seed     <= start ? seed : f_seed;
    f_looks    <= !start && (f_looks || state == LOOK);
    if (rst) begin
        {f_job, f_looking, f_works} <= 3'b000;
        f_read    <= 4'd0;
        f_window  <= 6'd0;
        f_inverse <= 3'd0;
    end
end

// ---- clocks that are left ------------------------------------------------------------------------------------------------

function [2:0] f_count;  // of a pause
    input [6:0] ones;
    f_count = ones[6] ? 3'd7 : ones[5] ? 3'd6 : ones[4] ? 3'd5 : ones[3] ? 3'd4 : ones[2] ? 3'd3 : ones[1] ? 3'd2 : {2'd0, ones[0]};
endfunction

wire [8:0] f_p = {6'd0, f_count(pause)};

wire [8:0] f_wait = c_inverse ? 9'd7 : {6'd0, f_inverse};  // for so many clocks the leading bit is still looked for, at most

// All these are clocks from now on. `lane` changes in each clock.
function [8:0] f_max;
    input [8:0] a, b;
    f_max = a < b ? b : a;
endfunction

function f_lane_at;  // `lane`
    input       now;
    input [8:0] then;
    f_lane_at = now ^ then[0];
endfunction

// SPEED goes on, if it is the state in `then`, not now: a clock after `lane` is high and the leading bit is known.
function [8:0] f_speed;
    input       now;
    input [8:0] wait_for, then;
    reg   [8:0] known;
    begin
        known   = f_max(then - 9'd1, wait_for);
        f_speed = known + 9'd1 + {8'd0, !f_lane_at(now, known)};
    end
endfunction

localparam [8:0] F_TURN = 9'd26;  // from then on to the end

function [8:0] f_looked;  // to the end, if LOOKED goes on in `then`
    input       now;
    input [8:0] wait_for, then;
    f_looked = f_speed(now, wait_for, then + 9'd2) + F_TURN;
endfunction

function [8:0] f_cut;  // until CUT has gone on, and the next axis is there
    input       now;
    input [8:0] then;
    f_cut = then + {8'd0, f_lane_at(now, then)} + 9'd15;
endfunction

function [8:0] f_axis;  // the same from where the look is asked for
    input       now;
    input [8:0] then;
    f_axis = f_cut(now, then + {3'd0, F_LOOK} + 9'd2);
endfunction

wire       f_l = lane;
wire [8:0] f_clears  = op_clear && !op_bin[3] ? 9'd8 - {5'd0, op_bin} : 9'd0;
wire [8:0] f_read_in = f_read[4] ? 9'd0 : f_read[3] ? 9'd1 : f_read[2] ? 9'd2 : 9'd3;
wire [8:0] f_placed  = f_window[6] ? 9'd0 : f_window[5] ? 9'd1 : f_window[4] ? 9'd2 : f_window[3] ? 9'd3 : f_window[2] ? 9'd4
                     : f_window[1] ? 9'd5 : 9'd6;

function [8:0] f_second;  // if the second axis is asked for in `then`
    input       now;
    input [8:0] wait_for, then;
    f_second = f_looked(now, wait_for, f_axis(now, then));
endfunction

function [8:0] f_both;
    input       now;
    input [8:0] wait_for, then;
    f_both = f_second(now, wait_for, f_axis(now, then));
endfunction

reg [8:0] f_left;    // without a look that has not begun
reg [8:0] f_left_looks;
always @* begin
    f_left = 9'd511;
    f_left_looks = 9'd0;
    case (state)
        SEED:    f_left = f_p + {8'd0, f_lane_at(f_l, f_p)} + 9'd28;
        SEED_1:  f_left = f_p + 9'd24;
        SEED_2:  f_left = f_p + 9'd18;
        LOAD: begin
            f_left       = f_read_in + 9'd36;
            f_left_looks = f_read_in + 9'd174;
        end
        SHRINK: begin
            f_left       = f_speed(f_l, f_wait, f_p + 9'd3) + F_TURN;
            f_left_looks = f_both(f_l, f_wait, f_p + 9'd15);
        end
        OFFSET: begin
            f_left       = f_speed(f_l, f_wait, f_p + 9'd1) + F_TURN;
            f_left_looks = f_both(f_l, f_wait, f_p + 9'd13);
        end
        LOOK:    f_left = f_both(f_l, f_wait, f_p + 9'd12);
        LOOK_AT: f_left = f_both(f_l, f_wait, f_p + 9'd4);
        LOOK_GO: f_left = look_y ? f_second(f_l, f_wait, f_p) : f_both(f_l, f_wait, f_p);
        LOOKING: f_left = look_y ? f_looked(f_l, f_wait, f_cut(f_l, 9'd48 - (look ? 9'd0 : {3'd0, f_look})))
                                   : f_second(f_l, f_wait, f_cut(f_l, 9'd48 - (look ? 9'd0 : {3'd0, f_look})));
        CUT:     f_left = look_y ? f_looked(f_l, f_wait, f_cut(f_l, f_p)) : f_second(f_l, f_wait, f_cut(f_l, f_p));
        ORDER:   f_left = look_y ? f_looked(f_l, f_wait, f_p + 9'd9) : f_second(f_l, f_wait, f_p + 9'd9);
        ORDERED: f_left = look_y ? f_looked(f_l, f_wait, f_p + 9'd7) : f_second(f_l, f_wait, f_p + 9'd7);
        LOOKED:  f_left = f_looked(f_l, f_wait, f_p);
        CLEAR:   f_left = f_seed ? 9'd17 : f_speed(f_l, f_wait, 9'd1) + F_TURN;
        SPEED:   f_left = (may_turn ? 9'd0 : f_speed(f_l, f_wait, 9'd1)) + F_TURN;
        TURN:    f_left = f_p + 9'd18;
        COUNT:   f_left = f_max(f_p + 9'd4, f_clears) + 9'd8;
        SAY:     f_left = f_max(f_p + 9'd1, f_clears) + 9'd8;
        PLACE:   f_left = f_max(f_p, f_clears) + 9'd8;
        WINDOW:  f_left = f_placed + 9'd1;
        KEPT:    f_left = 9'd0;
        default:   f_left = 9'd511;
    endcase
end

wire f_is_look = f_k >= LOOK_AT && f_k <= CLEAR;
wire f_is_seed = f_k >= SEED && f_k <= SEED_2;
wire f_is_read = f_k >= LOAD && f_k <= LOOKED;

// The longest one, by which the cover of a look is found: both axes are looked at, and cut at the low side.
reg f_longest = 1'b1;
always @(posedge clk)
    f_longest <= f_longest && rst == (f_time < 8'd2) && start == (f_time == 8'd2) && !seed && visible && shrinks && !q_meets && look_due && !merged
              && corrections == 6'd8 && !instant && !resting && looks && gap_found && !low_stays && look_done == (f_looking && f_look == F_LOOK)
              && inverse_goes_on == (f_wait != 9'd0) && record_free && !mask_busy;

wire f_is_seed = state >= SEED && state <= SEED_2;
wire f_is_read = state >= LOAD && state <= LOOKED;
wire f_is_look = state >= LOOK_AT && state <= CLEAR;
wire f_waits   = state == LOAD || state == LOOKING || state == CUT || state == CLEAR || state == SPEED || state == WINDOW || state == KEPT;
wire [6:0] f_placing = {c_window, f_window};

always @* if (f_past) begin
    i_begin: assert (f_ok || (f_was_rst && state == REST && rests && goes_on && !reads && f_window == 6'd0));
end

always @* if (f_past && f_ok) begin
    p_seed_ends:  assert (!(f_job && f_seed) || f_clocks <= 9'd31);
    p_plain_ends: assert (!(f_job && !f_seed && !f_looks) || f_clocks <= 9'd40);
    p_look_ends:  assert (!(f_job && !f_seed) || f_clocks <= 9'd178);

    i_job:    assert (f_job == !rests && rests == (state == REST) && (!f_was_rst || rests) && (rests || f_works));
    i_legal:  assert (state != 5'd4 && state <= KEPT && (pause & (pause + 7'd1)) == 7'd0 && (goes_on || (state != REST && !f_waits)));
    i_read:   assert ((f_read & (f_read - 4'd1)) == 4'd0 && (f_read != 4'd0) == (state == LOAD) && reads == (state == LOAD));
    i_place:  assert ((f_placing & (f_placing - 7'd1)) == 7'd0 && (f_placing != 7'd0) == (state == WINDOW));
    i_lane:   assert (!(state == SEED || state == CUT) || lane_next == !lane);
    i_kind:   assert (!f_job || (f_seed == seeds && !(f_seed && f_is_read) && !(!f_seed && f_is_seed) && (f_seed || !f_is_look || f_looks)));
    i_first:  assert (!look_y || (state != LOAD && state != SHRINK && state != OFFSET && state != LOOK && state != LOOK_AT));
    i_look:   assert ((state == LOOKING) == (look || f_looking) && (!f_looking || f_look <= F_LOOK));
    i_seeds:  assert (!f_job || !f_seed || f_clocks + f_left <= 9'd31);
    i_plain:  assert (!f_job || f_seed || f_looks || state == LOOK || f_clocks + f_left <= 9'd40);
    i_looks:  assert (!f_job || f_seed || f_clocks + f_max(f_left, f_left_looks) <= 9'd178);

    c_seed_ends:  cover (f_time == 8'd33 && done && f_seed && f_clocks == 9'd31);
    c_plain_ends: cover (f_time == 8'd42 && done && !f_seed && !f_looks && f_clocks == 9'd40);
    c_look_ends:  cover (f_time == 8'd180 && f_longest && done && f_looks && f_clocks == 9'd178);
end
