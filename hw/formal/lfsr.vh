// SPDX-License-Identifier: Apache-2.0
/*
[properties]
step = "a step is one of the linear register of the polynomial, in the complement"
seed = "a seed other than all ones is loaded"
reset = "reset makes the state 0"
locks = "the state is never all ones"
error = "seed_error is high for the seed of all ones, which is not loaded"
done = "done is high once a step has brought the state to the start of its period, until the next step or seed"

[[tasks]]
name = "2"
parameters = { WIDTH = 2 }
k = 2
covers_within = 8

[[tasks]]
name = "3"
parameters = { WIDTH = 3 }
k = 2
covers_within = 10

[[tasks]]
name = "16"
parameters = { WIDTH = 16 }
k = 2
covers_within = 8
only = ["step", "seed", "reset", "locks", "error"]
quick = true

[[tasks]]
name = "32"
parameters = { WIDTH = 32 }
k = 2
covers_within = 8
only = ["step", "seed", "reset", "locks", "error"]

[[tasks]]
name = "63"
parameters = { WIDTH = 63 }
k = 2
covers_within = 8
only = ["step", "seed", "reset", "locks", "error"]

[[tasks]]
name = "64"
parameters = { WIDTH = 64 }
k = 2
covers_within = 8
only = ["step", "seed", "reset", "locks", "error"]
quick = true

[[faults]]
meaning = "a tap is missing"
right = "feedback = ~^(state & TAPS)"
wrong = "feedback = ~^(state & (TAPS - 1'b1))"
breaks = ["step"]
within = 8
task = "3"

[[faults]]
meaning = "it shifts the other way"
right = "{state[WIDTH-2:0], feedback}"
wrong = "{feedback, state[WIDTH-1:1]}"
breaks = ["step"]
within = 8
task = "3"

[[faults]]
meaning = "a step wins over a seed"
right = "load_seed ? seed : step ? {state[WIDTH-2:0], feedback} : state"
wrong = "step || enable ? {state[WIDTH-2:0], feedback} : load_seed ? seed : state"
breaks = ["seed"]
within = 8
task = "3"

[[faults]]
meaning = "reset does nothing"
right = ".rst(rst),"
wrong = ".rst(1'b0),"
breaks = ["reset"]
within = 8
task = "3"

[[faults]]
meaning = "the seed of all ones is loaded"
right = "load_seed = load && !seed_error"
wrong = "load_seed = load"
breaks = ["locks"]
within = 8
task = "3"

[[faults]]
meaning = "the refused seed is not reported"
right = "seed_error = load && (&seed)"
wrong = "seed_error = load && (seed == {WIDTH{1'b0}})"
breaks = ["error", "locks"]
within = 8
task = "3"

[[faults]]
meaning = "a seed leaves done as it was"
right = "if (load_seed) done_reg <= 1'b0;"
wrong = "if (load_seed && rst) done_reg <= 1'b0;"
breaks = ["done"]
within = 14
task = "3"
*/
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
