// SPDX-License-Identifier: Apache-2.0
/*
[properties]
write_response = "a write response comes only after an address and data that have had none"
read_response = "a read response comes only after an address that has had none"
begins = "an answer becomes the response of its kind in the next clock, with its data, and SLVERR for an error"
once = "there is one response for each answer"
stable = "a response that is not taken stays"
request = "a request stays until its answer"
fields = "a request has the address, data and strobes of the oldest access of its kind without response"
bound = "an access is answered within 10 clocks, if requests are answered within 4 and no response of its kind waits for the master"

[[tasks]]
name = "default"
k = 2
covers_within = 20
quick = true

[[tasks]]
name = "3"
parameters = { ADDR_W = 3 }
k = 2
covers_within = 20

[[faults]]
meaning = "a write is answered without its data"
right = "can_write  = aw_held && w_held &&"
wrong = "can_write  = aw_held &&"
breaks = ["write_response", "fields"]
within = 10

[[faults]]
meaning = "a read is answered twice"
right = "                ar_held       <= 1'b0;\n"
wrong = ""
breaks = ["read_response", "fields"]
within = 12

[[faults]]
meaning = "an error is answered with OKAY"
right = "s_axil_rresp  <= answer_error ? SLVERR : OKAY"
wrong = "s_axil_rresp  <= OKAY"
breaks = ["begins"]
within = 10

[[faults]]
meaning = "a response repeats"
right = "if (s_axil_bready) s_axil_bvalid <= 1'b0;"
wrong = "if (s_axil_bready && !s_axil_awvalid) s_axil_bvalid <= 1'b0;"
breaks = ["once"]
within = 12

[[faults]]
meaning = "a response vanishes before it is taken"
right = "if (s_axil_rready) s_axil_rvalid <= 1'b0;"
wrong = "s_axil_rvalid <= 1'b0;"
breaks = ["stable"]
within = 10

[[faults]]
meaning = "the data of a write is replaced while it waits"
right = "if (s_axil_wvalid && !w_held)"
wrong = "if (s_axil_wvalid)"
breaks = ["request", "fields"]
within = 10

[[faults]]
meaning = "reads always go first"
right = "assign s_axil_arready = !ar_held;"
wrong = "assign s_axil_arready = !ar_held || (request_valid && answer && !request_write);"
breaks = ["bound"]
within = 20
*/
// Requests are answered within F_ANSWER clocks: this is assumed. Clocks in which the response of an access before waits for its master
// do not count for the bounds.
localparam F_ANSWER = 4;
localparam F_BOUND  = 2 * F_ANSWER + 2;
localparam WORD_W   = ADDR_W - 2;

reg [1:0] f_aw, f_w, f_ar;  // accepted, and not yet answered with a response that was taken
reg [WORD_W-1:0] f_aw_word, f_ar_word;
reg [31:0] f_data;
reg [3:0]  f_strb;
reg [3:0]  f_asks;          // clocks that a request waits for its answer
reg [3:0]  f_write_waits, f_read_waits;
reg        f_b_stalled, f_r_stalled, f_request_waits, f_was_write;
reg [1:0]  f_bresp, f_rresp, f_answer_resp;
reg [31:0] f_rdata, f_answer_data;
reg [WORD_W+36:0] f_request;
wire [WORD_W+36:0] f_now = {request_write, request_word, {36{request_write}} & {request_data, request_strb}};

wire f_aw_in = s_axil_awvalid && s_axil_awready;
wire f_w_in  = s_axil_wvalid && s_axil_wready;
wire f_ar_in = s_axil_arvalid && s_axil_arready;
wire f_b_out = s_axil_bvalid && s_axil_bready;
wire f_r_out = s_axil_rvalid && s_axil_rready;
wire f_write_open = f_aw != {1'b0, s_axil_bvalid} && f_w != {1'b0, s_axil_bvalid};  // a write whose response has not begun
wire f_read_open  = f_ar != {1'b0, s_axil_rvalid};

always @* assume (!(request_valid && f_asks == F_ANSWER - 1) || answer);

always @(posedge clk) begin
    f_aw <= f_aw + {1'b0, f_aw_in} - {1'b0, f_b_out};
    f_w  <= f_w + {1'b0, f_w_in} - {1'b0, f_b_out};
    f_ar <= f_ar + {1'b0, f_ar_in} - {1'b0, f_r_out};
    if (f_aw_in) f_aw_word <= s_axil_awaddr[ADDR_W-1:2];
    if (f_ar_in) f_ar_word <= s_axil_araddr[ADDR_W-1:2];
    if (f_w_in) {f_data, f_strb} <= {s_axil_wdata, s_axil_wstrb};
    f_b_stalled <= s_axil_bvalid && !s_axil_bready;
    f_r_stalled <= s_axil_rvalid && !s_axil_rready;
    f_request_waits <= request_valid && !answer;
    {f_bresp, f_rresp, f_rdata, f_request} <= {s_axil_bresp, s_axil_rresp, s_axil_rdata, f_now};
    f_asks <= (request_valid && !answer) ? f_asks + 4'd1 : 4'd0;
    if (request_valid && answer) begin
        f_was_write <= request_write;
        f_answer_resp <= {answer_error, 1'b0};
        f_answer_data <= answer_data;
    end
    f_write_waits <= !f_write_open || (request_valid && request_write && answer) ? 4'd0 : f_write_waits + {3'd0, !(s_axil_bvalid && !s_axil_bready)};
    f_read_waits  <= !f_read_open || (request_valid && !request_write && answer) ? 4'd0 : f_read_waits + {3'd0, !(s_axil_rvalid && !s_axil_rready)};
    if (rst) begin
        {f_aw, f_w, f_ar} <= 6'd0;
        {f_b_stalled, f_r_stalled, f_request_waits} <= 3'd0;
        f_asks <= 4'd0;
        {f_write_waits, f_read_waits} <= 8'd0;
    end
end

// A response begins in the clock after the answer to its request.
reg f_b_begins, f_r_begins;
always @(posedge clk) {f_b_begins, f_r_begins} <= {2{request_valid && answer && !rst}} & {request_write, !request_write};

wire [4:0] f_rest   = F_ANSWER - f_asks;  // clocks until the answer to the request at the latest
wire [4:0] f_to_write = !request_valid ? (s_axil_arready ? F_ANSWER + 1 : 2 * F_ANSWER + 2) : request_write ? f_rest : f_rest + F_ANSWER + 1;
wire [4:0] f_to_read  = !request_valid ? F_ANSWER + 1 : request_write ? f_rest + F_ANSWER + 1 : f_rest;

always @* if (f_past) begin
    p_write_response: assert (!s_axil_bvalid || (f_aw != 2'd0 && f_w != 2'd0));
    p_read_response:  assert (!s_axil_rvalid || f_ar != 2'd0);
    p_begins:   assert ((!f_b_begins || (s_axil_bvalid && s_axil_bresp == f_answer_resp))
                     && (!f_r_begins || (s_axil_rvalid && s_axil_rresp == f_answer_resp && s_axil_rdata == f_answer_data)));
    p_once:     assert ((!s_axil_bvalid || f_b_stalled || f_b_begins) && (!s_axil_rvalid || f_r_stalled || f_r_begins));
    p_stable:   assert ((!f_b_stalled || (s_axil_bvalid && s_axil_bresp == f_bresp))
                     && (!f_r_stalled || (s_axil_rvalid && s_axil_rresp == f_rresp && s_axil_rdata == f_rdata)));
    p_request:  assert (!f_request_waits || (request_valid && f_now == f_request));
    p_fields:   assert (!request_valid || (request_write ? f_write_open && request_word == f_aw_word && request_data == f_data && request_strb == f_strb
                                                         : f_read_open && request_word == f_ar_word));
    p_bound:    assert (f_write_waits <= F_BOUND && f_read_waits <= F_BOUND);
    i_counts:   assert (f_aw == {1'b0, aw_held} + {1'b0, s_axil_bvalid} && f_w == {1'b0, w_held} + {1'b0, s_axil_bvalid}
                     && f_ar == {1'b0, ar_held} + {1'b0, s_axil_rvalid});
    i_held:     assert (!request_valid || (request_write ? aw_held && w_held && (!s_axil_bvalid) : ar_held && !s_axil_rvalid));
    i_words:    assert ((!aw_held || aw_word == f_aw_word) && (!ar_held || ar_word == f_ar_word) && (!w_held || {data, strb} == {f_data, f_strb}));
    i_asks:     assert (f_asks < F_ANSWER && (request_valid || f_asks == 4'd0));
    i_write:    assert (!f_write_open || (s_axil_bvalid ? f_write_waits == 4'd0 : f_write_waits + f_to_write <= F_BOUND));
    i_read:     assert (!f_read_open || (s_axil_rvalid ? f_read_waits == 4'd0 : f_read_waits + f_to_read <= F_BOUND));
    c_write_response: cover (s_axil_bvalid && f_aw == 2'd2);
    c_read_response:  cover (s_axil_rvalid && f_ar == 2'd2);
    c_begins:   cover (f_b_begins && f_r_stalled);
    c_once:     cover (s_axil_bvalid && s_axil_rvalid);
    c_stable:   cover (f_r_stalled && f_rdata == 32'h12345678);
    c_request:  cover (f_request_waits && request_write);
    c_fields:   cover (request_valid && request_write && s_axil_rvalid);
    c_bound:    cover (f_write_waits == F_BOUND - 1);
end
