// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*array_match*", "t:*array_lives*", "t:*array_merge*", "t:*array_order*", "t:*array_output*"]

[properties]
order = "a token commits after those before it, with the time, address and polarity that it came with, taken or passed if it is an event"
once = "each token commits once, and at most 16 wait"
decided = "an event leaves the update once, a clock after its commit, with its number"
room = "at most eight events follow the fall of room"

[[tasks]]
name = "8"
parameters = { N = 8 }
k = 2
covers_within = 1
only = []
quick = true

[[tasks]]
name = "1"
parameters = { N = 1 }
k = 2
covers_within = 30
# No slot is restarted after reset, and no life looked at.
shorter = [
    "restart    <= {N{1'b1}};\n            restart_due <= 1'b1;\n            restarting <= 1'b0;\n            restarts   <= 1'b0;\n            stale   <= 1'b1;",
    "restart <= NONE;\n            restart_due <= 1'b0;\n            restarting <= 1'b0;\n            restarts <= 1'b0;\n            stale <= 1'b0;",
]

[[tasks]]
name = "2"
parameters = { N = 2 }
k = 2
covers_within = 1
only = []

[[tasks]]
name = "16"
parameters = { N = 16 }
k = 2
covers_within = 1
only = []

[[tasks]]
name = "32"
parameters = { N = 32 }
k = 2
covers_within = 1
only = []

[[faults]]
task = "1"
file = "array_input.v"
meaning = "after a rewind the first token that is not committed is left out"
right = "issued       <= committed;"
wrong = "issued       <= committed + 5'd1;"
breaks = ["order"]
within = 24

[[faults]]
task = "1"
file = "array_input.v"
meaning = "tokens are taken although none has been committed"
right = "s_ready   <= !level[4] && level[3:0] != 4'd15"
wrong = "s_ready   <= !level[4]"
breaks = ["once"]
within = 24

[[faults]]
task = "1"
meaning = "an event has the polarity of the one behind it"
right = "u_p      <= c_p"
wrong = "u_p      <= d_p"
breaks = ["order"]
within = 14

[[faults]]
task = "1"
meaning = "what is thrown out is decided as well"
right = "v_decided <= commit && (u_takes || u_passes)"
wrong = "v_decided <= u_takes || u_passes"
breaks = ["decided"]
within = 10

[[faults]]
task = "1"
meaning = "a token without an event takes a number"
right = "if (commit && u_counts) next_seq"
wrong = "if (commit) next_seq"
breaks = ["decided"]
within = 20

[[faults]]
task = "1"
meaning = "tokens are issued into a full output"
right = "v_busy || !room || restart_due"
wrong = "v_busy || restart_due"
breaks = ["room"]
within = 34
*/
// Which slot has an event, and when lives end and tracks merge, may be anything. One token is marked, f_index of those that come, and
// followed through the memory and the stages; f_m to f_u say which token each stage has.
localparam F_W = CLOCK_W + X_W + Y_W + 3;
(* anyconst *) wire [F_W-1:0] f_token;  // time, whether it counts, event, x, y, p
(* anyconst *) wire [4:0]     f_index;
(* anyseq *)   wire           f_choose;

(* hierconn *) wire [4:0]     \u_input.written ;
(* hierconn *) wire [4:0]     \u_input.committed ;
(* hierconn *) wire [4:0]     \u_input.issued ;
(* hierconn *) wire [4:0]     \u_input.after_issued ;
(* hierconn *) wire [4:0]     \u_input.f_head ;
(* hierconn *) wire           \u_input.waits ;
(* hierconn *) wire           \u_input.rewound ;
(* hierconn *) wire [3:0]     \u_input.f_address ;
(* hierconn *) wire [CLOCK_W-1:0] \u_input.now ;
(* hierconn *) wire [F_W-1:0] \u_input.f_content ;
(* hierconn *) wire           \u_update.u_last ;
(* hierconn *) wire           \u_update.v_last ;
(* hierconn *) wire           \u_update.v_join ;
(* hierconn *) wire           \u_update.u_join ;
assign u_input.f_address = f_index[3:0];

reg        f_waits, f_was_rewound, f_decides, f_was_room;
reg  [4:0] f_m, f_e, f_c, f_u, f_d_reg;
reg  [3:0] f_since;  // events since room is low
reg  [SEQ_W-1:0] f_counted, f_number;
reg  [X_W+Y_W:0] f_event_was;
wire [4:0] f_d     = (FAR != 0) ? f_d_reg : f_e;
wire [4:0] f_level = u_input.written - u_input.committed;
wire [4:0] f_ahead = f_index - u_input.committed;
wire f_in   = s_valid && s_ready;
wire f_mark = f_in && f_choose && !f_waits && u_input.written == f_index
              && f_token == {u_input.now + {{(CLOCK_W - TICK_W) {1'b0}}, s_tick}, s_event || s_skip, s_event, s_x, s_y, s_p};

always @(posedge clk) begin
    f_m <= u_input.f_head;
    f_e <= f_m;
    f_d_reg <= f_e;
    f_c <= f_d;
    f_u <= f_c;
    f_was_rewound <= rewound;
    f_was_room <= room;
    f_since   <= room ? 4'd0 : f_since + {3'd0, v_decided};
    f_decides <= commit && (u_takes || u_passes);
    f_event_was <= {u_x, u_y, u_p};
    f_number  <= f_counted;
    if (commit && u_counts) f_counted <= f_counted + 1'b1;
    if (f_mark) f_waits <= 1'b1;
    else if (commit && u_input.committed == f_index) f_waits <= 1'b0;
    if (rst) begin
        {f_waits, f_was_rewound, f_decides, f_was_room} <= 4'b0001;
        f_counted <= {SEQ_W{1'b0}};
        f_since   <= 4'd0;
    end
end

// How many tokens are ahead of each stage, between it and the commit; what was thrown out does not count.
wire       f_has_m = m_valid && !rewound, f_has_head = token_valid && !rewound;
wire       f_has_d_reg = FAR != 0 && d_valid;
wire       f_has_u = u_valid || u_ends;
wire [4:0] f_at_c  = u_input.committed + {4'd0, f_has_u};
wire [4:0] f_at_d  = f_at_c + {4'd0, c_valid};
wire [4:0] f_at_e  = f_at_d + {4'd0, f_has_d_reg};
wire [4:0] f_at_m  = f_at_e + {4'd0, e_valid};
wire [4:0] f_at_h  = f_at_m + {4'd0, f_has_m};
wire [4:0] f_at_next = f_at_h + {4'd0, f_has_head};
wire [F_W-1:0] f_in_m = {m_time, m_counts, m_event, m_hi_x[X_W-1:0], m_hi_y[Y_W-1:0], m_p};
wire [F_W-1:0] f_in_e = {e_time, e_counts, e_event, e_x, e_y, e_p};
wire [F_W-1:0] f_in_d = {d_time, d_counts, d_event, d_x, d_y, d_p};
wire [F_W-1:0] f_in_c = {c_time, c_counts, c_takes || c_passes, c_x, c_y, c_p};
wire [F_W-1:0] f_in_u = {u_time, u_counts, u_takes || u_passes, u_x, u_y, u_p};
wire [3:0]     f_flight = {3'd0, v_decided} + {3'd0, u_valid} + {3'd0, c_valid} + {3'd0, f_has_d_reg} + {3'd0, e_valid}
                          + {3'd0, m_valid} + {3'd0, !closed};
wire           f_last = u_input.committed == f_index;

always @* if (f_past) begin
    p_order:   assert (!(commit && f_waits && f_last) || (f_in_u == f_token && !(u_takes && u_passes)));
    p_once:    assert (f_level <= 5'd16 && (!commit || f_level != 5'd0) && (!f_waits || f_ahead < f_level));
    p_decided: assert (v_decided == f_decides && (!v_decided || ({v_x, v_y, v_p} == f_event_was && seq == f_number)));
    p_room:    assert (!(v_decided && !room) || f_since < 4'd8);
    i_since:   assert (f_was_room ? f_since == 4'd0 : closed);
    i_flight:  assert ({1'b0, f_since} + {1'b0, f_flight} <= 5'd8);
    i_number:  assert (next_seq == f_counted);
    i_rewound: assert (u_input.rewound == rewound && !(rewound && (e_valid || c_valid || u_valid || u_ends || f_has_d_reg)));
    i_silent:  assert (!f_was_rewound || (!token_valid && !m_valid));
    i_special: assert (!u_special || u_valid);
    i_ends:    assert (!(u_valid && u_ends));
    i_check:   assert (!(m_check && m_valid));
    i_last:    assert ((!u_update.u_last || u_special) && (!u_update.u_join || u_busy));
    i_moves:   assert ((!u_update.v_last || rewound) && (!u_update.v_join || v_busy) && (!w_checks || closed || f_was_rewound));
    i_ready:   assert (!s_ready || f_level <= 5'd15);
    i_after:   assert (u_input.after_issued == u_input.issued + 5'd1);
    i_next:    assert (rewound || u_input.issued == f_at_next);
    i_written: assert (rewound || f_at_next - u_input.committed <= f_level);
    i_waits:   assert (rewound || !u_input.waits || u_input.issued != u_input.written);
    i_u:       assert (!f_has_u || f_u == u_input.committed);
    i_c:       assert (!c_valid || f_c == f_at_c);
    i_d:       assert (!f_has_d_reg || f_d_reg == f_at_d);
    i_e:       assert (!e_valid || f_e == f_at_e);
    i_m:       assert (!f_has_m || f_m == f_at_m);
    i_head:    assert (!f_has_head || u_input.f_head == f_at_h);
    i_memory:  assert (!f_waits || u_input.f_content == f_token);
    i_in_h:    assert (!(f_waits && f_has_head && u_input.f_head == f_index)
                       || {token_time, token_counts, token_event, token_x, token_y, token_p} == f_token);
    i_in_m:    assert (!(f_waits && f_has_m && f_m == f_index) || f_in_m == f_token);
    i_in_e:    assert (!(f_waits && e_valid && f_e == f_index) || f_in_e == f_token);
    i_in_d:    assert (!(f_waits && f_has_d_reg && f_d_reg == f_index) || f_in_d == f_token);
    i_in_c:    assert (!(f_waits && c_valid && f_c == f_index) || (f_in_c == f_token && !(c_takes && c_passes)));
    i_in_u:    assert (!(f_waits && u_valid && f_u == f_index) || (f_in_u == f_token && !(u_takes && u_passes)));
    c_order:   cover (commit && f_waits && f_last && f_index == 5'd1 && u_takes);
    c_once:    cover (f_level == 5'd16);
    c_decided: cover (v_decided && v_owned && f_number == 1);
    c_room:    cover (v_decided && !room && f_since == 4'd2);
end
