// SPDX-License-Identifier: Apache-2.0
/*
[properties]
order = "a word that was accepted leaves after those before it, unchanged"
count = "level is the number of words that went in and have not left, without one in the output register; at most DEPTH"
ready = "s_ready is low exactly while DEPTH words are held"
dry = "m_valid is high from the clock after a word was accepted, with BLOCK = 1 from the fourth"
stable = "a word that is not taken stays"

[[tasks]]
name = "through"
parameters = { W = 80, DEPTH = 256, BLOCK = 0 }
k = 2
covers_within = 8
quick = true
only = ["order", "dry", "stable"]

[[tasks]]
name = "block"
parameters = { W = 80, DEPTH = 256, BLOCK = 1 }
k = 2
covers_within = 10
quick = true
only = ["order", "dry", "stable"]

[[tasks]]
name = "through_5"
parameters = { W = 3, DEPTH = 5, BLOCK = 0 }
k = 2
covers_within = 12
quick = true

[[tasks]]
name = "block_5"
parameters = { W = 3, DEPTH = 5, BLOCK = 1 }
k = 2
covers_within = 14
quick = true

[[tasks]]
name = "through_1"
parameters = { W = 1, DEPTH = 1, BLOCK = 0 }
k = 2
covers_within = 8
only = ["order", "count", "ready", "dry"]

[[tasks]]
name = "block_1"
parameters = { W = 1, DEPTH = 1, BLOCK = 1 }
k = 2
covers_within = 12

[[faults]]
meaning = "the write address does not wrap"
task = "through_5"
right = "write_reg <= (write_reg == LAST[ADDR_W-1:0]) ? {ADDR_W{1'b0}} : write_reg + 1'b1"
wrong = "write_reg <= write_reg + 1'b1"
breaks = ["order"]
within = 14

[[faults]]
meaning = "a word is read in the clock of its writing"
task = "block_5"
right = "ram_valid && settling, ram_valid ^ settling};"
wrong = "1'b0, ram_valid};"
breaks = ["order"]
within = 10

[[faults]]
meaning = "the first register is read over while it waits"
task = "block_5"
right = ".read_enable  (reads)"
wrong = ".read_enable  (1'b1)"
breaks = ["order"]
within = 14

[[faults]]
meaning = "full a word too late"
task = "through_5"
right = "full_reg <= push && level_reg == LAST[LEVEL_W-1:0]"
wrong = "full_reg <= push && level_reg == LAST[LEVEL_W-1:0] + 1'b1"
breaks = ["count", "ready"]
within = 14

[[faults]]
meaning = "full a word too early"
task = "block_5"
right = "full_reg <= push && level_reg == LAST[LEVEL_W-1:0]"
wrong = "full_reg <= push && level_reg == LAST[LEVEL_W-1:0] - 1'b1"
breaks = ["ready"]
within = 14

[[faults]]
meaning = "a clock is lost before the first word"
task = "block_5"
right = "if (reads) ram_valid <= unread;"
wrong = "if (reads) ram_valid <= unread && !ram_valid && write_reg == read_reg;"
breaks = ["dry"]
within = 16

[[faults]]
meaning = "the output register is read over while it waits"
task = "block_5"
right = ".out_enable   (moves)"
wrong = ".out_enable   (1'b1)"
breaks = ["stable"]
within = 14
*/
// A word that is accepted is marked, any one of them, with the place f_place where it is written. f_ahead counts the words before it.
// Where it must be follows from f_ahead: in the output register, in the one before, or in its place in the memory.
(* anyconst *) wire [W-1:0]      f_word;
(* anyconst *) wire [ADDR_W-1:0] f_place;
(* anyseq *)   wire              f_choose;

localparam [31:0] F_DEPTH = DEPTH;
localparam F_W = LEVEL_W + 2;

reg            f_waits, f_was_stalled;
reg  [F_W-1:0] f_ahead, f_inside;
reg  [W-1:0]   f_was;
reg  [2:0]     f_dry;  // clocks in a row in which words are inside and none is at the output
wire           f_in   = s_valid && s_ready;
wire           f_out  = m_valid && m_ready;
wire           f_mark = f_in && f_choose && !f_waits && s_data == f_word && write_reg == f_place;

always @(posedge clk) begin
    f_was_stalled <= m_valid && !m_ready;
    f_was    <= m_data;
    f_inside <= f_inside + {{(F_W - 1) {1'b0}}, f_in} - {{(F_W - 1) {1'b0}}, f_out};
    f_dry    <= (f_inside == {F_W{1'b0}} || m_valid) ? 3'd0 : (f_dry == 3'd7) ? 3'd7 : f_dry + 3'd1;
    if (f_mark) begin
        f_waits <= 1'b1;
        f_ahead <= f_inside - {{(F_W - 1) {1'b0}}, f_out};
    end else if (f_waits && f_out) begin
        f_ahead <= f_ahead - 1'b1;
        if (f_ahead == {F_W{1'b0}}) f_waits <= 1'b0;
    end
    if (rst) begin
        {f_waits, f_was_stalled} <= 2'b00;
        f_inside <= {F_W{1'b0}};
        f_dry    <= 3'd0;
    end
end

// A place so many words after another, around the end.
function [F_W-1:0] f_around;
    input [F_W-1:0] sum;
    f_around = (sum >= F_DEPTH[F_W-1:0]) ? sum - F_DEPTH[F_W-1:0] : sum;
endfunction

wire [F_W-1:0] f_level = {2'b00, level_reg};
wire [F_W-1:0] f_read  = {{(F_W - ADDR_W) {1'b0}}, read_reg};
wire [F_W-1:0] f_write = {{(F_W - ADDR_W) {1'b0}}, write_reg};
wire [F_W-1:0] f_outer;     // words in the registers behind the memory
wire           f_in_memory = f_waits && f_ahead >= f_outer;
wire [F_W-1:0] f_register;  // words in the register at the output

(* hierconn *) wire [W-1:0]      \g_block.u_memory.ram_reg ;
(* hierconn *) wire [W-1:0]      \g_block.u_memory.f_content ;
(* hierconn *) wire [ADDR_W-1:0] \g_block.u_memory.f_address ;

generate
    if (BLOCK != 0) begin : f_registers
        wire [F_W-1:0] f_ram    = {{(F_W - 1) {1'b0}}, g_block.ram_valid};
        wire [F_W-1:0] f_to     = {{(F_W - ADDR_W) {1'b0}}, g_block.to_reg};
        wire           f_newest = f_in_memory && g_block.settling && f_ahead == f_inside - 1'b1;
        assign f_register = {{(F_W - 1) {1'b0}}, g_block.m_valid_reg};
        assign f_outer    = f_register + f_ram;
        assign g_block.u_memory.f_address = f_place;
        always @* if (f_past) begin
            i_memory:   assert (!f_in_memory || f_newest || g_block.u_memory.f_content == f_word);
            i_newest:   assert (!f_newest || g_block.data_reg == f_word);
            i_ram:      assert (!(f_waits && f_ahead == f_register && g_block.ram_valid) || g_block.u_memory.ram_reg == f_word);
            i_settles:  assert (!g_block.settling || (f_level > f_ram && f_around(f_to + 1'b1) == f_write && f_to < F_DEPTH[F_W-1:0]));
            i_write:    assert (f_write == f_around(f_read + f_level - f_ram) && f_level >= f_ram);
            i_dry:      assert (m_valid || f_dry <= (g_block.ram_valid ? 3'd2 : (f_level > {{(F_W - 1) {1'b0}}, g_block.settling}) ? 3'd1 : 3'd0));
        end
    end else begin : f_registers
        assign f_register = {F_W{1'b0}};
        assign f_outer    = {F_W{1'b0}};
        always @* if (f_past) begin
            i_memory: assert (!f_in_memory || g_through.memory[f_place] == f_word);
            i_write:  assert (f_write == f_around(f_read + f_level));
        end
    end
endgenerate

always @* if (f_past) begin
    p_order:  assert (!(f_waits && f_ahead == {F_W{1'b0}} && m_valid) || m_data == f_word);
    p_count:  assert (f_inside == f_level + f_register && f_level <= F_DEPTH[F_W-1:0]);
    p_ready:  assert (s_ready == (f_level != F_DEPTH[F_W-1:0]));
    p_dry:    assert (m_valid == (f_inside != {F_W{1'b0}}) || (BLOCK != 0 && !m_valid && f_dry < 3'd3));
    p_stable: assert (!f_was_stalled || (m_valid && m_data == f_was));
    i_place:  assert (!f_waits || f_ahead < f_inside);
    i_where:  assert (!f_in_memory || f_around(f_read + f_ahead - f_outer) == {{(F_W - ADDR_W) {1'b0}}, f_place});
    i_ends:   assert (f_read < F_DEPTH[F_W-1:0] && f_write < F_DEPTH[F_W-1:0]);
    c_order:  cover (f_waits && f_ahead == {F_W{1'b0}} && m_valid && f_was_stalled);
    c_count:  cover (f_inside == F_DEPTH[F_W-1:0]);
    c_ready:  cover (!s_ready);
    c_dry:    cover (m_valid && f_dry == ((BLOCK != 0) ? 3'd3 : 3'd0));
    c_stable: cover (f_was_stalled && m_ready && f_inside > 1);
end
