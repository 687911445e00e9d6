// SPDX-License-Identifier: Apache-2.0
/*
[properties]
seed_ends = "a candidate that begins takes at most 31 clocks, if nothing that it waits for is late"
correction_ends = "a correction without a look for gaps takes at most 40 clocks, if nothing that it waits for is late"
look_ends = "a correction with a look for gaps takes at most 178 clocks, if nothing that it waits for is late"
at_rest = "while nothing is done, no slot is loaded and no bin cleared"

[[tasks]]
name = "default"
k = 181
covers_within = 182

[[faults]]
meaning = "a look at y is followed by one more"
right = "state  <= look_y ? LOOKED : LOOK_GO;\n            end\n            LOOKING:"
wrong = "state  <= look_y && !look ? LOOKED : LOOK_GO; look <= look_y;\n            end\n            LOOKING:"
breaks = ["look_ends"]
within = 182

[[faults]]
meaning = "the bins are waited for to the last one"
right = "(!op_clear || op_bin[3])"
wrong = "!op_clear"
breaks = ["seed_ends"]
within = 60

[[faults]]
meaning = "the velocity is waited for for too long"
right = "pause <= turns ? clocks(3'd5) : clocks(3'd1);"
wrong = "pause <= turns ? clocks(3'd7) : clocks(3'd1);"
breaks = ["correction_ends"]
within = 60

[[faults]]
meaning = "a slot is still read when its job is done"
right = "reads     <= 1'b0;\n                pause     <= clocks(3'd1);"
wrong = "pause     <= clocks(3'd1);"
breaks = ["at_rest"]
within = 60
*/
// The job that starts in the clock after reset is followed. Any other starts from the same state: i_rests. What reset leaves may have any
// value.
//
// Nothing is late: the slot is there three clocks after start, the leading bit of the time seven at most after it is looked for, an
// axis is looked at for at most 47, the window is there after six; masks and records do not wait. `lane` is that of motion_sides.v.
reg [3:1] f_read;
reg       f_lane, f_on_y, f_loads;
reg [2:0] f_inverse;  // clocks in which the leading bit may be looked for
reg [5:0] f_look;     // clocks of a look, at most
reg       f_looking;
reg [5:0] f_window;
reg [7:0] f_clocks;   // since reset: of the job since its start
reg       f_job, f_seeds, f_looks;  // it is not done; it is a seed; it has a look

always @* if (!f_past) assume (f_lane != f_on_y && !f_loads);
always @* assume (!start || rests);
always @* assume (read_done == f_read[3] && lane == f_lane && !mask_busy && record_free && window_done == f_window[5]);
always @* assume (!inverse_goes_on || f_inverse != 3'd0);
always @* assume (!look_done || f_looking);
always @* assume (!f_looking || f_look != 6'd47 || look_done);

always @(posedge clk) begin
    f_read    <= {f_read[2:1], start && !seed};
    f_loads   <= load && read_done;
    f_on_y    <= !f_on_y && !f_loads;
    f_lane    <= f_on_y || f_loads;
    f_inverse <= c_inverse ? 3'd7 : f_inverse == 3'd0 ? 3'd0 : f_inverse - 3'd1;
    f_look    <= look ? 6'd1 : f_look + 6'd1;
    f_looking <= look || (f_looking && !look_done);
    f_window  <= {f_window[4:0], c_window};
    f_clocks  <= f_clocks + {7'd0, f_clocks != 8'd255};
    f_job     <= f_clocks == 8'd0 ? start : f_job && !done;
    f_seeds   <= f_clocks == 8'd0 ? seed : f_seeds;
    f_looks   <= f_clocks != 8'd0 && (f_looks || state == LOOK);
    if (rst) begin
        f_read    <= 3'd0;
        f_inverse <= 3'd0;
        f_window  <= 6'd0;
        f_clocks  <= 8'd0;
        {f_loads, f_looking, f_job} <= 3'b000;
    end
end

always @* if (f_past) begin
    p_seed_ends:       assert (!(f_job && f_seeds && f_clocks == 8'd32));
    p_correction_ends: assert (!(f_job && !f_seeds && !f_looks && f_clocks == 8'd41));
    p_look_ends:       assert (!(f_job && !f_seeds && f_looks && f_clocks == 8'd179));
    p_at_rest:         assert (!rests || (!load && !op_clear));
    i_rests:           assert (rests == (state == REST) && (!rests || pause == 7'd0));
    i_reads:           assert (!reads || state == LOAD);
    c_seed_ends:       cover (f_job && done && f_seeds && f_clocks == 8'd31);
    c_correction_ends: cover (f_job && done && !f_seeds && !f_looks && f_clocks == 8'd40);
    c_look_ends:       cover (f_job && done && f_looks && f_clocks == 8'd178);
    c_at_rest:         cover (rests && f_clocks == 8'd33);
end
