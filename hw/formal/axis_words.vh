// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "a word of which all bytes came leaves after those before it, lowest lane first, its bytes in order"
all = "each such word leaves once, and nothing else does"
cut = "n_cut is the number of words of which a part is missing"
stall = "a beat waits for the words of the one before and for the receiver, and for nothing else"
stable = "a word that is not taken stays"

[[tasks]]
name = "32_of_32"
parameters = { DATA_W = 32, WORD_W = 32, COUNT_W = 32 }
k = 1
covers_within = 12
quick = true

[[tasks]]
name = "4_of_16"
parameters = { DATA_W = 64, WORD_W = 16, COUNT_W = 32 }
k = 1
covers_within = 14
quick = true

[[tasks]]
name = "2_of_16"
parameters = { DATA_W = 32, WORD_W = 16, COUNT_W = 32 }
k = 1
covers_within = 12

[[tasks]]
name = "1_of_16"
parameters = { DATA_W = 16, WORD_W = 16, COUNT_W = 32 }
k = 1
covers_within = 12

[[tasks]]
name = "2_of_32"
parameters = { DATA_W = 64, WORD_W = 32, COUNT_W = 32 }
k = 1
covers_within = 12

[[tasks]]
name = "64_of_64"
parameters = { DATA_W = 64, WORD_W = 64, COUNT_W = 64 }
k = 1
covers_within = 12

[[tasks]]
name = "halves_of_64"
parameters = { DATA_W = 32, WORD_W = 64, COUNT_W = 32 }
k = 1
covers_within = 12
quick = true

[[tasks]]
name = "halves_of_32"
parameters = { DATA_W = 16, WORD_W = 32, COUNT_W = 8 }
k = 1
covers_within = 12

[[faults]]
task = "4_of_16"
meaning = "the highest lane leaves first"
right = "for (lane = LANES - 1; lane >= 0; lane = lane - 1) if (waiting[lane])"
wrong = "for (lane = 0; lane < LANES; lane = lane + 1) if (waiting[lane])"
breaks = ["order"]
within = 10

[[faults]]
task = "halves_of_64"
meaning = "all eight bytes are reversed, not those of each half"
right = "localparam UNIT_BYTES = (WORD_W == 64) ? 4 : WORD_W / 8"
wrong = "localparam UNIT_BYTES = WORD_W / 8"
breaks = ["order"]
within = 10

[[faults]]
task = "4_of_16"
meaning = "a lane of which one byte is there is a word"
right = "assign whole[i]   = &s_axis_tkeep[i*KEEP_W +: KEEP_W]"
wrong = "assign whole[i]   = |s_axis_tkeep[i*KEEP_W +: KEEP_W]"
breaks = ["all", "cut"]
within = 8

[[faults]]
task = "halves_of_32"
meaning = "tlast without a byte does not end a word"
right = "s_axis_tlast && whole != has_lower"
wrong = "s_axis_tlast && whole && !has_lower"
breaks = ["all", "cut"]
within = 10

[[faults]]
task = "4_of_16"
meaning = "a beat is taken a clock later than it could be"
right = "later == {LANES{1'b0}} && (output_free || waiting == {LANES{1'b0}})"
wrong = "waiting == {LANES{1'b0}}"
breaks = ["stall"]
within = 12

[[faults]]
task = "32_of_32"
meaning = "a word is taken over while it waits"
right = "output_free = m_ready || !m_valid"
wrong = "output_free = 1'b1"
breaks = ["stable", "all"]
within = 8
*/
// One word is marked, any that a beat completes: f_lane of it, with the value f_word. f_ahead counts the words before it. The words
// of a beat, and the half that waits for its other one, are stated here anew, from the comment above the module.
(* anyconst *) wire [WORD_W-1:0] f_word;
(* anyconst *) wire [1:0]        f_lane;
(* anyconst *) wire              f_swap;
(* anyseq *)   wire              f_choose;
always @* assume (f_lane < LANES && swap_bytes == f_swap);

localparam F_BYTES = (DATA_W < WORD_W) ? DATA_W / 8 : WORD_W / 8;  // of a lane

reg              f_has_half, f_waits, f_was_stalled;
reg [DATA_W-1:0] f_half;
reg [2:0]        f_ahead, f_inside, f_stall;
reg [WORD_W-1:0] f_was;
reg [COUNT_W-1:0] f_cut;

function [2:0] f_ones;
    input [LANES-1:0] bits;
    integer i;
    begin
        f_ones = 3'd0;
        for (i = 0; i < LANES; i = i + 1) f_ones = f_ones + {2'd0, bits[i]};
    end
endfunction

function [WORD_W-1:0] f_in_order;
    input [WORD_W-1:0] word;
    integer i;
    for (i = 0; i < WORD_W / 8; i = i + 1)
        f_in_order[8*i +: 8] = word[8*(!f_swap ? i : WORD_W == 16 ? 1 - i : i < 4 ? 3 - i : 11 - i) +: 8];
endfunction

reg  [LANES-1:0]        f_all, f_any;  // lanes of which all bytes are there, or some
always @* begin : f_lanes
    integer i;
    for (i = 0; i < LANES; i = i + 1) begin
        f_all[i] = &s_axis_tkeep[F_BYTES*i +: F_BYTES];
        f_any[i] = |s_axis_tkeep[F_BYTES*i +: F_BYTES];
    end
end
wire                    f_half_ends = (f_any[0] && !f_all[0]) || (s_axis_tlast && (f_all[0] ^ f_has_half));
wire [LANES-1:0]        f_comes  = (DATA_W < WORD_W) ? f_all & f_has_half : f_all;
wire [LANES*WORD_W-1:0] f_values = {s_axis_tdata, f_half};
wire [LANES*WORD_W-1:0] f_lanes_of = (DATA_W < WORD_W) ? f_values : {{LANES * WORD_W{1'b0}}, s_axis_tdata};
wire [2:0]              f_cuts = (DATA_W < WORD_W) ? {2'd0, f_half_ends} : f_ones(f_any & ~f_all);

wire f_in   = s_axis_tvalid && s_axis_tready;
wire f_gone = m_valid && m_ready;
wire [LANES-1:0] f_below = ~({LANES{1'b1}} << f_lane);
wire f_mark = f_in && f_choose && !f_waits && f_comes[f_lane] && f_lanes_of[WORD_W*f_lane +: WORD_W] == f_word;

always @(posedge clk) begin
    f_was_stalled <= m_valid && !m_ready;
    f_was    <= m_word;
    f_inside <= f_inside + (f_in ? f_ones(f_comes) : 3'd0) - {2'd0, f_gone};
    f_stall  <= s_axis_tready ? 3'd0 : f_stall + {2'd0, m_ready};
    if (f_in) begin
        f_cut      <= f_cut + {{(COUNT_W - 1) {1'b0}}, 1'b1} * f_cuts;
        f_has_half <= DATA_W < WORD_W && !f_half_ends && (f_all[0] ^ f_has_half);
        if (f_all[0]) f_half <= s_axis_tdata;
    end
    if (f_mark) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside + f_ones(f_comes & f_below) - {2'd0, f_gone};
    end else if (f_waits && f_gone) begin
        f_ahead <= f_ahead - 3'd1;
        if (f_ahead == 3'd0) f_waits <= 1'b0;
    end
    if (rst) begin
        {f_waits, f_was_stalled, f_has_half} <= 3'b000;
        {f_inside, f_stall} <= 6'd0;
        f_cut <= {COUNT_W{1'b0}};
    end
end

generate
    if (DATA_W < WORD_W) begin : f_halves
        always @* if (f_past) begin
            i_half: assert (g_halves.has_lower == f_has_half && (!f_has_half || g_halves.lower == f_half));
        end
    end
endgenerate

always @* if (f_past) begin
    p_order:  assert (!(f_waits && f_ahead == 3'd0 && m_valid) || m_word == f_in_order(f_word));
    p_all:    assert (f_inside == f_ones(waiting) + {2'd0, m_valid});
    p_cut:    assert (n_cut == f_cut);
    p_stall:  assert (s_axis_tready || !m_ready || f_stall + 3'd1 < LANES);
    p_stable: assert (!f_was_stalled || (m_valid && m_word == f_was));
    i_place:  assert (!f_waits || (f_ahead < f_inside && (f_ahead == 3'd0 ? m_valid || waiting[f_lane] : waiting[f_lane])));
    i_lane:   assert (!f_waits || (m_valid && f_ahead == 3'd0)
                      || (f_ahead == {2'd0, m_valid} + f_ones(waiting & f_below) && words[WORD_W*f_lane +: WORD_W] == f_word));
    i_stall:  assert (s_axis_tready || f_stall + f_ones(waiting) <= LANES);
    c_order:  cover (f_waits && f_ahead == 3'd0 && f_lane == LANES - 1 && f_was_stalled && f_swap);
    c_all:    cover (f_inside == LANES + 1);
    c_cut:    cover (n_cut == 2);
    c_stall:  cover (!s_axis_tready && f_stall == ((LANES > 1) ? LANES - 2 : 0));
    c_stable: cover (f_was_stalled && m_ready);
end
