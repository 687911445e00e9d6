// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*block_memory*"]

[properties]
read_alone = "a read is answered within 36 clocks of its handshake, if no write is open meanwhile"
write_alone = "a write is answered within 38 clocks of its last handshake, with TRACKER = 2 within 46, if no read is open meanwhile"
read = "a read is answered within 73 clocks of its handshake, with TRACKER = 2 within 81, whatever writes there are"
write = "a write is answered within 73 clocks of its last handshake, with TRACKER = 2 within 81, whatever reads there are"

[[tasks]]
name = "array"
parameters = { N = 8, TRACKER = 0 }
k = 2
covers_within = 60
only = ["read_alone", "write_alone"]
shorter = ["LAST_FILL = (BANKS << REG_W) - 1", "LAST_FILL = 3"]
quick = true

[[tasks]]
name = "chain"
parameters = { N = 8, TRACKER = 1 }
k = 2
covers_within = 60
only = ["read_alone", "write_alone"]
shorter = ["LAST_FILL = (BANKS << REG_W) - 1", "LAST_FILL = 3"]

[[tasks]]
name = "motion"
parameters = { N = 8, TRACKER = 2 }
k = 2
covers_within = 60
only = ["read_alone", "write_alone"]
shorter = ["LAST_FILL = (BANKS << REG_W) - 1", "LAST_FILL = 3"]
quick = true

[[tasks]]
name = "classifier"
parameters = { N = 8, TRACKER = 2, CLASSIFY = 1 }
k = 2
covers_within = 60
only = ["read_alone", "write_alone"]
shorter = ["LAST_FILL = (BANKS << REG_W) - 1", "LAST_FILL = 3"]

[[tasks]]
name = "motion_64"
parameters = { N = 64, TRACKER = 2 }
k = 2
covers_within = 60
only = []
shorter = ["LAST_FILL = (BANKS << REG_W) - 1", "LAST_FILL = 3"]

[[tasks]]
name = "1"
parameters = { N = 1, TRACKER = 0 }
k = 2
covers_within = 60
shorter = ["LAST_FILL = (BANKS << REG_W) - 1", "LAST_FILL = 3"]

[[faults]]
meaning = "a read that is merged waits for the next access"
task = "1"
right = "state  <= !request_write ? ANSWER :"
wrong = "state  <= !request_write ? IDLE :"
breaks = ["read_alone", "read"]
since = 95
within = 95

[[faults]]
meaning = "the access after a copy waits for all banks that are pending"
task = "1"
right = "turns      <= 1'b1;"
wrong = "turns      <= 1'b0; pending <= pending;"
breaks = ["read_alone"]
since = 100
within = 100

[[faults]]
meaning = "a write without strobes is not answered"
task = "1"
right = "                state <= ANSWER;\n            end\n            COPY"
wrong = "                state <= acts ? ANSWER : WEIGH;\n            end\n            COPY"
breaks = ["write_alone", "write"]
since = 95
within = 95
*/
// How long an access waits: the clocks from the handshake that completes it to its response, without those in which the shadow is filled
// after reset or a response of its kind waits for the master. An access is alone if no access of the other kind is open meanwhile.
// The reset of what lies behind follows soft_reset as in evcot_top. f_rest bounds the clocks that are left.
localparam F_WRITE = (MOTION != 0) ? 15 : 7;  // clocks from IDLE to the response
localparam F_READ  = 5;
localparam F_COPY  = `EVCOT_BANK_LAST + 3;
localparam F_READ_ALONE  = F_READ + F_COPY + 2;
localparam F_WRITE_ALONE = F_WRITE + F_COPY + 2;
localparam F_BOTH        = F_WRITE + F_READ + 2 * F_COPY + 4;

reg [1:0] f_resetting;
reg       f_core_rst;
always @(posedge clk) begin
    f_resetting <= (rst || soft_reset) ? 2'd3 : (f_resetting == 2'd0) ? 2'd0 : f_resetting - 1'b1;
    f_core_rst  <= rst || soft_reset || f_resetting != 2'd0;
end
always @* assume (core_rst == (f_core_rst || soft_reset || rst));
wire [3:0] f_core_left = !f_core_rst ? 4'd0 : {2'b00, f_resetting} + 4'd1;

(* hierconn *) wire \u_slave.aw_held ;
(* hierconn *) wire \u_slave.w_held ;
(* hierconn *) wire \u_slave.ar_held ;
wire f_write_open = u_slave.aw_held && u_slave.w_held;
wire f_read_open  = u_slave.ar_held;
wire f_reads  = request_valid && !request_write;
wire f_writes = request_valid && request_write;

reg [7:0] f_read_waits, f_write_waits;
reg       f_read_alone, f_write_alone;
always @(posedge clk) begin
    f_read_waits  <= (!f_read_open || s_axil_rvalid || fills || (f_reads && state == ANSWER)) ? 8'd0 : f_read_waits + 8'd1;
    f_write_waits <= (!f_write_open || s_axil_bvalid || fills || (f_writes && state == ANSWER)) ? 8'd0 : f_write_waits + 8'd1;
    f_read_alone  <= f_read_waits == 8'd0 ? !f_write_open : f_read_alone && !f_write_open;
    f_write_alone <= f_write_waits == 8'd0 ? !f_read_open : f_write_alone && !f_read_open;
    if (rst) {f_read_waits, f_write_waits} <= 16'd0;
end

wire [7:0] f_copy_left = ends ? 8'd1 : (late && late_word == `EVCOT_REG_MODE) ? 8'd2
                       : (step == {REG_W{1'b0}}) ? 8'd3 : F_COPY + 8'd1 - {3'd0, step};
// Clocks until IDLE, or while a request is valid until IDLE hands over to FETCH.
wire [7:0] f_to_idle  = (state == COPY) ? f_copy_left : (f_core_left != 0) ? {4'd0, f_core_left} : F_COPY + 8'd2;
wire [7:0] f_to_fetch = (state != COPY && f_core_left == 0 && (turns || !busy)) ? 8'd0 : (state == COPY || f_core_left != 0) ? f_to_idle : F_COPY + 8'd1;
function [7:0] f_after;  // clocks from a state to the response
    input write;
    case (state)
        ANSWER: f_after = 8'd1;
        CHECK:  f_after = 8'd2;
        WEIGH:  f_after = 8'd3;
        RULES:  f_after = 8'd11 - {4'd0, compares};
        MERGE:  f_after = write ? F_WRITE - 8'd3 : 8'd2;
        LOOK:   f_after = write ? F_WRITE - 8'd2 : 8'd3;
        FETCH:  f_after = write ? F_WRITE - 8'd1 : 8'd4;
        default: f_after = (write ? F_WRITE : F_READ) + f_to_fetch;
    endcase
endfunction
wire f_serves = state != IDLE && state != COPY && state != FILL;

// The clocks left for each kind, at most: of its own request, or after the one of the other kind.
wire [7:0] f_first      = f_after(request_write);
wire [7:0] f_then_read  = F_COPY + 8'd2 + F_READ;
wire [7:0] f_then_write = F_COPY + 8'd2 + F_WRITE;
wire [7:0] f_read_left  = f_reads ? f_first : f_writes ? f_first + f_then_read : f_to_idle + F_READ;
wire [7:0] f_write_left = f_writes ? f_first : f_reads ? f_first + f_then_write : f_read_open ? f_to_idle + F_READ + f_then_write : f_to_idle + F_WRITE;

always @* if (f_past) begin
    p_read:  assert (!(f_read_open && !s_axil_rvalid) || f_read_waits < F_BOTH);
    p_write: assert (!(f_write_open && !s_axil_bvalid) || f_write_waits < F_BOTH);
    p_read_alone:  assert (!(f_read_open && !s_axil_rvalid && f_read_alone) || f_read_waits < F_READ_ALONE);
    p_write_alone: assert (!(f_write_open && !s_axil_bvalid && f_write_alone) || f_write_waits < F_WRITE_ALONE);
    c_read:  cover (f_read_waits == F_READ + F_COPY && !f_read_alone);
    c_write: cover (f_write_waits == F_WRITE + F_COPY && !f_write_alone);
    c_read_alone:  cover (f_read_alone && f_read_waits == F_READ - 1);
    c_write_alone: cover (f_write_alone && f_write_waits == F_WRITE - 1);
    i_copy: assert (state != COPY || (!late ? step == 1 && !ends && !later : late_word == 0 ? step == 1 && !ends
                  : late_word == 1 && ends ? step == 2 : !ends && ((step == 0) ? late_word == `EVCOT_BANK_LAST : step <= `EVCOT_BANK_LAST && late_word == step - 1'b1)));
    i_rules: assert (state == RULES ? MOTION != 0 && compares <= (is_tracks ? TRACKS_COMPARED : MOTION_COMPARED) + 4'd2
                  : !(state == LOOK || state == MERGE) || compares == 4'd0);
    i_serves: assert (!f_serves || (request_valid && (f_writes || state == FETCH || state == LOOK || state == MERGE || state == ANSWER)));
    i_read:  assert (!(f_read_open && !fills && !s_axil_rvalid) || f_read_waits + f_read_left <= F_BOTH);
    i_write: assert (!(f_write_open && !fills && !s_axil_bvalid) || f_write_waits + f_write_left <= F_BOTH);
    i_core:  assert (f_core_rst ? !busy && state != COPY : f_resetting == 0);
    i_fill:  assert (!fills || (!busy && !turns));
    i_soft:  assert (!soft_reset || (state == ANSWER && f_writes));
    i_state: assert (state <= RULES && (MOTION != 0 || state != RULES));
    i_open:  assert (!request_valid || (request_write ? f_write_open && !s_axil_bvalid : f_read_open && !s_axil_rvalid));
    i_read_alone:  assert (!(f_read_open && !fills && !s_axil_rvalid && f_read_alone && f_read_waits != 0) || (!f_writes && f_read_waits + f_read_left <= F_READ_ALONE));
    i_write_alone: assert (!(f_write_open && !fills && !s_axil_bvalid && f_write_alone && f_write_waits != 0) || (!f_reads && f_write_waits + f_write_left <= F_WRITE_ALONE));
    i_stall: assert ((!s_axil_rvalid || f_read_waits == 0) && (!s_axil_bvalid || f_write_waits == 0));
end
