// SPDX-License-Identifier: Apache-2.0
/*
[properties]
time = "a word that enters the queue has all ticks that came since the word before, those of dropped events too"
event = "a kept event enters the queue with its fields"
flush = "what enters the queue without an event is no event"
keeps = "an accepted event is dropped exactly if the queue is full, which needs drop_enable"
room = "nothing enters a full queue"
ready = "s_ready is high while drop_enable is, else while the queue has room"
soon = "ticks without event enter the queue at once when it is empty"
counts = "n_in, n_dropped, n_out and held count what came, was dropped, was taken, and was kept and not taken: n_in = n_out + n_dropped + held"
dropped = "dropped is high in the clock after one in which an event was dropped"

[[tasks]]
name = "default"
parameters = { X_W = 9, Y_W = 9, TICK_W = 20, DEPTH = 256, GAP_W = 48, COUNT_W = 32, HELD_W = 16 }
k = 2
covers_within = 10
only = ["time", "event", "flush", "room", "soon"]
quick = true

[[tasks]]
name = "shallow"
parameters = { X_W = 9, Y_W = 9, TICK_W = 20, DEPTH = 2, GAP_W = 48, COUNT_W = 32 }
k = 2
covers_within = 16
quick = true

[[tasks]]
name = "small"
parameters = { X_W = 1, Y_W = 1, TICK_W = 1, DEPTH = 1, GAP_W = 2, COUNT_W = 8 }
k = 2
covers_within = 12
only = ["event", "flush", "keeps", "ready", "soon", "counts", "dropped"]

[[faults]]
task = "shallow"
meaning = "the ticks of a dropped event are lost"
right = "waiting <= ticks;"
wrong = "waiting <= drops ? waiting : ticks;"
breaks = ["time"]
within = 12

[[faults]]
task = "shallow"
meaning = "ticks that go with an event are not cleared"
right = "        if (keeps || flushes) begin\n            waiting <= {GAP_W{1'b0}};"
wrong = "        if (keeps || flushes) begin\n            waiting <= flushes ? {GAP_W{1'b0}} : waiting;"
breaks = ["time"]
within = 12

[[faults]]
task = "shallow"
meaning = "a skipped event is not marked"
right = "keeps && s_skip"
wrong = "keeps && s_skip && s_event"
breaks = ["event"]
within = 12

[[faults]]
task = "shallow"
meaning = "ticks alone go as an event"
right = "keeps && s_event,"
wrong = "s_event,"
breaks = ["flush"]
within = 12

[[faults]]
task = "shallow"
meaning = "an event is dropped although there is room"
right = "wire keeps   = comes && room;"
wrong = "wire keeps   = comes && room && !drop_enable;"
breaks = ["keeps"]
within = 12

[[faults]]
task = "shallow"
meaning = "a full queue is written"
right = "wire keeps   = comes && room;"
wrong = "wire keeps   = comes && s_ready;"
breaks = ["room"]
within = 12

[[faults]]
task = "shallow"
meaning = "the source waits although events may be dropped"
right = "s_ready = drop_enable || room"
wrong = "s_ready = room"
breaks = ["ready"]
within = 12

[[faults]]
task = "shallow"
meaning = "ticks wait for the next event"
right = "flushes = !comes && empty && waits"
wrong = "flushes = !comes && empty && waits && s_valid"
breaks = ["soon"]
within = 12

[[faults]]
task = "shallow"
meaning = "ticks one by one are overlooked"
right = "{GAP_W{1'b0}}) || s_time;"
wrong = "{GAP_W{1'b0}});"
breaks = ["soon"]
within = 12

[[faults]]
task = "shallow"
meaning = "an event that comes as one goes is not counted as held"
right = "if (kept != given) held"
wrong = "if (kept && given) held <= held + 1'b1; else if (kept != given) held"
breaks = ["counts"]
within = 14

[[faults]]
task = "shallow"
meaning = "an event that is kept counts as dropped"
right = "wire drops   = arrives && !room;"
wrong = "wire drops   = arrives && level == DEPTH - 1;"
breaks = ["counts", "dropped"]
within = 12

[[faults]]
task = "shallow"
meaning = "an event is dropped that counts as kept"
right = ".s_valid(keeps || flushes),"
wrong = ".s_valid((keeps && !s_skip) || flushes),"
breaks = ["keeps"]
within = 12
*/
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
