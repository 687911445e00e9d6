// SPDX-License-Identifier: Apache-2.0
// The complement of the state steps as the linear register of the polynomial x^WIDTH + sum of x^(WIDTH - tap): the bit that enters is the
// sum of those at the taps. Its only cycle of one is 0, that is, all ones here. tests/hw/math/test_lfsr.py shows that all polynomials
// are primitive, so that the other states are one cycle.
reg [WIDTH-1:0] f_was, f_seed, f_start;
reg f_stepped, f_loaded, f_began, f_done;
wire [WIDTH-1:0] f_complement = ~f_was;

always @(posedge clk) begin
    f_was     <= state;
    f_seed    <= seed;
    f_loaded  <= load && seed != {WIDTH{1'b1}};
    f_stepped <= enable && !load;
    f_began   <= rst;
    if (load && seed != {WIDTH{1'b1}}) f_start <= seed;
    if (rst) f_start <= {WIDTH{1'b0}};
end
// Whether the last step ended a period, until the next step or seed.
always @(posedge clk) begin
    if (load && seed != {WIDTH{1'b1}}) f_done <= 1'b0;
    else if (enable && !load) f_done <= ~{~state[WIDTH-2:0], ^(~state & TAPS)} == f_start;
    if (rst) f_done <= 1'b0;
end

always @* if (f_past) begin
    p_step:  assert (f_began || f_loaded || state == (f_stepped ? ~{f_complement[WIDTH-2:0], ^(f_complement & TAPS)} : f_was));
    p_seed:  assert (!f_loaded || f_began || state == f_seed);
    p_reset: assert (!f_began || state == {WIDTH{1'b0}});
    p_locks: assert (state != {WIDTH{1'b1}});
    p_error: assert (seed_error == (load && seed == {WIDTH{1'b1}}));
    p_done:  assert (done == f_done);
    i_start: assert (start_reg == f_start && f_start != {WIDTH{1'b1}});
    i_taps:  assert (^TAPS == 1'b0 && TAPS[WIDTH-1]);
    c_step:  cover (f_stepped && f_was == f_seed && !f_began);
    c_seed:  cover (f_loaded && state != f_was && !f_began);
    c_reset: cover (f_began && f_was != {WIDTH{1'b0}});
    c_locks: cover (state == ~{{(WIDTH - 1) {1'b0}}, 1'b1});
    c_error: cover (seed_error);
    c_done:  cover (done);
end
