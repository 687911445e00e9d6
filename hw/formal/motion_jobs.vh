// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "each job is computed after those before it, with all that came with it"
all = "no job is lost or repeated, and at most 125 are inside, if at most 12 come while room is low"
stable = "a job stays until it is done"
soon = "where a job is inside, one is there to be computed after 2 clocks without one at most"

[[tasks]]
name = "default"
k = 2
covers_within = 12
quick = true

[[tasks]]
name = "64 slots"
parameters = { N = 64, SLOT_W = 6, X_W = 16, Y_W = 16, SIDE_W = 32, SUP_W = 32 }
k = 2
covers_within = 12
only = ["order", "stable", "soon"]

[[faults]]
meaning = "a job is written over the one before it"
right = ".write_address(tail[DEPTH_W-1:0])"
wrong = ".write_address(head[DEPTH_W-1:0])"
breaks = ["order"]
within = 12

[[faults]]
meaning = "a job that is done is read again"
right = "reads   = any_job && (!fetched || gives)"
wrong = "reads   = (any_job || job_done) && (!fetched || gives)"
breaks = ["all"]
within = 12

[[faults]]
meaning = "the next job comes before this one is done"
right = "gives   = fetched && (!job_valid || job_done)"
wrong = "gives   = fetched"
breaks = ["stable"]
within = 12

[[faults]]
meaning = "a job is read only when the one before is done"
right = "reads   = any_job && (!fetched || gives)"
wrong = "reads   = any_job && job_done"
breaks = ["soon"]
within = 12
*/
// Jobs come while there is room, and at most 12 later; a job is done in its second clock at the earliest.
(* anyseq *) wire f_choose;

localparam F_W = JOB_W - SEQ_LOW - TIME_LOW;

reg             f_waits, f_was_there, f_new;
reg [3:0]       f_late;     // jobs that came while room was low
reg [DEPTH_W:0] f_ahead, f_inside;
reg [DEPTH_W-1:0] f_place;
reg [F_W-1:0]   f_job, f_was;
reg [2:0]       f_clocks;   // in which a job was inside and none there

always @* assume (!job_done || (job_valid && !f_new));
always @* assume (!(j_valid && !room && f_late == 4'd12));

wire [F_W-1:0] f_given = {j_real, j_flag, j_kind, j_slot, waits[j_slot], j_x, j_y, j_sides, j_marks, j_owned};
wire [F_W-1:0] f_out   = {job_real, job_flag, job_kind, job_slot, job_waits, job_x, job_y, job_sides, job_marks, job_owned};

always @(posedge clk) begin
    f_was_there <= job_valid && !job_done;
    f_was       <= f_out;
    f_new       <= gives;
    f_late      <= room ? 4'd0 : f_late + {3'd0, j_valid};
    f_inside    <= f_inside + {{DEPTH_W{1'b0}}, j_valid} - {{DEPTH_W{1'b0}}, job_done};
    f_clocks    <= (f_inside == {(DEPTH_W + 1) {1'b0}} || job_valid) ? 3'd0 : (f_clocks == 3'd7) ? 3'd7 : f_clocks + 3'd1;
    if (j_valid && f_choose && !f_waits) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside - {{DEPTH_W{1'b0}}, job_done};
        f_place <= tail[DEPTH_W-1:0];
        f_job   <= f_given;
    end else if (f_waits && job_done) begin
        f_ahead <= f_ahead - {{DEPTH_W{1'b0}}, 1'b1};
        if (f_ahead == {(DEPTH_W + 1) {1'b0}}) f_waits <= 1'b0;
    end
    if (rst) begin
        {f_waits, f_was_there, f_new} <= 3'b000;
        f_late   <= 4'd0;
        f_inside <= {(DEPTH_W + 1) {1'b0}};
        f_clocks <= 3'd0;
    end
end

(* hierconn *) wire [JOB_W-1:0] \u_jobs.ram_reg ;
(* hierconn *) wire [JOB_W-1:0] \u_jobs.f_content ;
(* hierconn *) wire [DEPTH_W-1:0] \u_jobs.f_address ;
assign u_jobs.f_address = f_place;

wire [DEPTH_W:0] f_there   = {{DEPTH_W{1'b0}}, job_valid};
wire [DEPTH_W:0] f_fetched = f_there + {{DEPTH_W{1'b0}}, fetched};
wire [JOB_W-1:0] f_read    = u_jobs.ram_reg, f_stored = u_jobs.f_content;
wire [F_W-1:0]   f_found   = (f_ahead < f_there) ? f_out : (f_ahead < f_fetched) ? f_read[JOB_W-1-:F_W] : f_stored[JOB_W-1-:F_W];

always @* if (f_past) begin
    p_order:  assert (!(f_waits && f_ahead == {(DEPTH_W + 1) {1'b0}} && job_valid) || f_out == f_job);
    p_all:    assert (f_inside == tail - head && f_inside <= 8'd125 && f_fetched <= f_inside);
    p_stable: assert (!f_was_there || (job_valid && f_out == f_was));
    p_soon:   assert (f_clocks <= 3'd2);
    i_where:  assert (!f_waits || (f_ahead < f_inside && f_found == f_job && head[DEPTH_W-1:0] + f_ahead[DEPTH_W-1:0] == f_place));
    i_level:  assert (room ? f_inside <= 8'd112 : f_inside <= 8'd113 + {4'd0, f_late} && f_late <= 4'd12);
    i_read:   assert (following == head + f_fetched);
    i_soon:   assert (f_inside == {(DEPTH_W + 1) {1'b0}} || job_valid || f_clocks + (fetched ? 3'd1 : 3'd2) <= 3'd2);
    c_order:  cover (f_waits && f_ahead == {(DEPTH_W + 1) {1'b0}} && job_done && f_job[F_W-2-:3] == 3'b101);
    c_all:    cover (f_inside == 8'd4 && job_done);
    c_stable: cover (f_was_there && job_done);
    c_soon:   cover (f_clocks == 3'd2);
end
