// SPDX-License-Identifier: Apache-2.0
/*
[properties]
sum = "num = quot * den + rem"
rem = "rem < den"
zero = "by zero, quot is all ones and rem the low bits of num"
clocks = "the result comes NUM_W + 1 clocks after the operands"
once = "a result comes only after operands that have had none"
stable = "a result that is not taken stays"

[[tasks]]
name = "motion"
parameters = { NUM_W = 48, DEN_W = 20 }
k = 2
covers_within = 51
quick = true

[[tasks]]
name = "small"
parameters = { NUM_W = 6, DEN_W = 4 }
k = 2
covers_within = 12
quick = true

[[tasks]]
name = "1"
parameters = { NUM_W = 1, DEN_W = 1 }
k = 2
covers_within = 8
only = ["zero", "clocks", "once", "stable"]

[[faults]]
task = "small"
meaning = "the remainder is not restored"
right = "restored = fits ?"
wrong = "restored = 1'b1 ?"
breaks = ["sum", "rem"]
within = 12

[[faults]]
task = "small"
meaning = "equal does not fit"
right = "fits = !difference[DEN_W+1]"
wrong = "fits = !difference[DEN_W+1] && |difference"
breaks = ["rem", "zero"]
within = 12

[[faults]]
task = "small"
meaning = "a step is missing"
right = "later_steps_reg <= LAST[COUNT_W-1:0];"
wrong = "later_steps_reg <= LAST[COUNT_W-1:0] - 1'b1;"
breaks = ["clocks", "sum"]
within = 12

[[faults]]
task = "small"
meaning = "a result repeats"
right = "if (m_valid_reg && m_ready) m_valid_reg <= 1'b0;"
wrong = "if (m_valid_reg && m_ready && s_valid) m_valid_reg <= 1'b0;"
breaks = ["once"]
within = 14

[[faults]]
task = "small"
meaning = "new operands are taken while a result waits"
right = "s_ready = !busy_reg && !m_valid_reg"
wrong = "s_ready = !busy_reg"
breaks = ["stable"]
within = 14
*/
// Of the numerator the upper f_done bits are divided: f_high is their value, f_quot the quotient so far, and f_product, which is summed
// as f_quot is shifted, f_quot times the denominator. Small dividers are compared with a multiplication.
localparam F_SMALL = NUM_W <= 8;
localparam F_W = $clog2(NUM_W + 2) + 1;

reg [NUM_W-1:0] f_num, f_high, f_quot, f_product;
reg [DEN_W-1:0] f_den;
reg [F_W-1:0]   f_clocks;  // since the operands were taken
reg             f_was_valid, f_open;
reg [NUM_W+DEN_W-1:0] f_was;
wire f_in  = s_valid && s_ready;
wire f_out = m_valid && m_ready;
wire [F_W-1:0] f_done = m_valid ? NUM_W[F_W-1:0] : f_clocks;
wire f_bit = quot_reg[NUM_W-1];

always @(posedge clk) begin
    f_was_valid <= m_valid && !m_ready;
    f_was <= {m_quot, m_rem};
    if (f_in) begin
        {f_num, f_den} <= {s_num, s_den};
        {f_high, f_quot, f_product} <= {3 * NUM_W{1'b0}};
        f_clocks <= {F_W{1'b0}};
        f_open <= 1'b1;
    end else if (f_open && !m_valid) begin
        f_clocks  <= f_clocks + 1'b1;
        f_high    <= (f_high << 1) | {{(NUM_W - 1) {1'b0}}, f_num[NUM_W - 1 - f_clocks]};
        f_quot    <= (f_quot << 1) | {{(NUM_W - 1) {1'b0}}, fits};
        f_product <= (f_product << 1) + (fits ? f_den : {DEN_W{1'b0}});
    end
    if (f_out) f_open <= 1'b0;
    if (rst) {f_open, f_was_valid} <= 2'b00;
end

wire [NUM_W+DEN_W-1:0] f_back = F_SMALL ? m_quot * f_den + m_rem : f_num;

always @* if (f_past) begin
    p_sum:     assert (!m_valid || (f_high == f_num && f_product + m_rem == f_num && m_quot == f_quot && f_back == f_num)
                       || f_den == {DEN_W{1'b0}});
    p_rem:     assert (!m_valid || m_rem < f_den || f_den == {DEN_W{1'b0}});
    p_zero:    assert (!(m_valid && f_den == {DEN_W{1'b0}}) || (m_quot == {NUM_W{1'b1}} && {{NUM_W{1'b0}}, m_rem} == (f_num & {DEN_W{1'b1}})));
    p_clocks:  assert (!f_open || (m_valid ? f_clocks == NUM_W : f_clocks < NUM_W));
    p_once:    assert (m_valid ? f_open : 1'b1);
    p_stable:  assert (!f_was_valid || (m_valid && {m_quot, m_rem} == f_was));
    i_busy:    assert (f_open == (busy_reg || m_valid_reg) && !(busy_reg && m_valid_reg));
    i_steps:   assert (!busy_reg || f_clocks + later_steps_reg == NUM_W - 1);
    i_den:     assert (!f_open || den_reg == f_den);
    i_quot:    assert (!f_open || quot_reg == ((f_done == NUM_W ? {NUM_W{1'b0}} : f_num << f_done) | f_quot));
    i_bits:    assert (!f_open || (f_quot >> f_done == {NUM_W{1'b0}} && f_high == (f_num >> (NUM_W - f_done))));
    i_rem:     assert (!f_open || f_den == {DEN_W{1'b0}} || (rem_reg < f_den && f_product + rem_reg == f_high && f_product <= f_high));
    i_real:    assert (!F_SMALL || !f_open || {{DEN_W{1'b0}}, f_product} == f_quot * f_den + {(NUM_W + DEN_W) {1'b0}});
    i_zero:    assert (!f_open || f_den != {DEN_W{1'b0}} || (f_quot == ~({NUM_W{1'b1}} << f_done) && {{NUM_W{1'b0}}, rem_reg} == (f_high & {DEN_W{1'b1}})));
    c_sum:     cover (m_valid && m_quot > 2 && m_rem > 1);
    c_rem:     cover (m_valid && m_rem == f_den - 1'b1 && m_rem != {DEN_W{1'b0}});
    c_zero:    cover (m_valid && f_den == {DEN_W{1'b0}});
    c_clocks:  cover (m_valid);
    c_once:    cover (m_valid && m_ready);
    c_stable:  cover (f_was_valid && m_ready);
end
