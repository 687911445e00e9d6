// SPDX-License-Identifier: Apache-2.0
// What stands before the queue: fifo and tick_splitter have properties of their own. Ticks that came are summed apart from the registers; sums are modulo 2^GAP_W, counts modulo 2^COUNT_W.
localparam F_W = X_W + Y_W + 1;

(* anyconst *) wire f_one_by_one;  // ticks come as s_time
always @* assume (f_one_by_one ? s_tick == {GAP_W{1'b0}} : !s_time);

wire f_taken  = s_valid && s_ready;
wire f_event  = f_taken && (s_event || s_skip);
(* hierconn *) wire \u_queue.s_valid ;
wire f_pushes = u_queue.s_valid && room;  // a word enters the queue
wire f_given  = m_valid && m_ready && (m_event || m_skip);

reg [GAP_W-1:0] f_since;  // ticks since the last word that entered the queue
wire [GAP_W-1:0] f_ticks = f_since + (f_taken ? s_tick : {GAP_W{1'b0}}) + s_time;

reg f_was_event, f_was_dropped, f_was_given, f_was_kept;
reg [COUNT_W-1:0] f_in, f_dropped, f_out;
reg [HELD_W-1:0]  f_held;

(* hierconn *) wire [TOKEN_W-1:0] \u_queue.s_data ;
(* hierconn *) wire \u_queue.g_block.ram_valid ;
(* hierconn *) wire \u_queue.g_block.settling ;
wire [TOKEN_W-1:0] f_word = u_queue.s_data;

always @(posedge clk) begin
    f_since <= f_pushes ? {GAP_W{1'b0}} : f_ticks;
    {f_was_event, f_was_dropped, f_was_given, f_was_kept} <= {f_event, f_event && !f_pushes, f_given, f_event && f_pushes};
    f_in      <= f_in + f_was_event;
    f_dropped <= f_dropped + f_was_dropped;
    f_out     <= f_out + f_was_given;
    f_held    <= f_held + f_was_kept - f_was_given;
    if (rst) begin
        f_since <= {GAP_W{1'b0}};
        {f_was_event, f_was_dropped, f_was_given, f_was_kept} <= 4'd0;
        f_in      <= {COUNT_W{1'b0}};
        f_dropped <= {COUNT_W{1'b0}};
        f_out     <= {COUNT_W{1'b0}};
        f_held    <= {HELD_W{1'b0}};
    end
end

always @* if (f_past) begin
    p_time:   assert (!f_pushes || f_word[TOKEN_W-1-:GAP_W] == f_ticks);
    p_event:  assert (!(f_event && f_pushes) || f_word[F_W+1:0] == {s_event, s_skip, s_x, s_y, s_p});
    p_flush:  assert (!(f_pushes && !f_event) || f_word[F_W+1:F_W] == 2'b00);
    p_keeps:  assert (!f_event || (room ? f_pushes : !f_pushes && drop_enable));
    p_room:   assert (!u_queue.s_valid || room);
    p_ready:  assert (s_ready == (drop_enable || room));
    p_soon:   assert (!(empty && !f_event && f_since != {GAP_W{1'b0}}) || f_pushes);
    p_counts: assert (n_in == f_in && n_dropped == f_dropped && n_out == f_out && held == f_held);
    i_level:  assert (level >= {1'b0, u_queue.g_block.ram_valid} + {1'b0, u_queue.g_block.settling});
    i_full:   assert (room == (level != DEPTH) && level <= DEPTH);
    i_since:  assert (f_since == waiting);
    i_waits:  assert (waits || waiting == {GAP_W{1'b0}});
    i_late:   assert (arrived == f_was_event && given == f_was_given && kept == f_was_kept);
    p_dropped: assert (dropped == f_was_dropped);
    c_time:   cover (keeps && f_since != {GAP_W{1'b0}} && f_word[TOKEN_W-1-:GAP_W] > 3);
    c_event:  cover (keeps && s_skip);
    c_flush:  cover (f_pushes && !f_event);
    c_keeps:  cover (f_event && !f_pushes);
    c_room:   cover (f_pushes && !empty);
    c_ready:  cover (s_ready && !room);
    c_soon:   cover (empty && f_since != {GAP_W{1'b0}} && s_valid && !f_event);
    c_dropped: cover (f_was_dropped);
    c_counts: cover (n_dropped == 2 && n_out == 1 && held == 1);
end
