// SPDX-License-Identifier: Apache-2.0
// Words come as axis_words gives them: one that is not taken stays. What they mean is stated here anew, as the format has it, and
// compared with what time_mark and event_vector are given; their own properties say what becomes of that.
(* hierconn *) wire              \u_mark.set ;
(* hierconn *) wire [MARK_W-1:0] \u_mark.mark ;
(* hierconn *) wire              \u_mark.wrapped ;
(* hierconn *) wire              \u_events.s_valid ;
(* hierconn *) wire [T_W-1:0]    \u_events.s_t ;
(* hierconn *) wire [11:0]       \u_events.s_x ;
(* hierconn *) wire [10:0]       \u_events.s_y ;
(* hierconn *) wire              \u_events.s_p ;
(* hierconn *) wire [31:0]       \u_events.s_mask ;
(* hierconn *) wire              \u_events.s_known ;

reg                f_was_stalled;
reg [63:0]         f_was;
reg [COUNT_W-1:0]  f_reserved;
wire [63:0] f_word  = (DATA_W == 32 && swap_halves) ? {both[31:0], both[63:32]} : both;  // at 64 bits they came exchanged
wire [3:0]  f_type  = f_word[63:60];
wire        f_event = f_type < 4'd2;
wire        f_in    = word_valid && word_ready;

always @* assume (!f_was_stalled || (word_valid && both == f_was));

always @(posedge clk) begin
    f_was_stalled <= word_valid && !word_ready;
    f_was <= both;
    if (f_in && (f_type >= 4'd2 && f_type <= 4'd7 || f_type == 4'd9 || f_type >= 4'd11 && f_type <= 4'd13))
        f_reserved <= f_reserved + 1'b1;
    if (rst) begin
        f_was_stalled <= 1'b0;
        f_reserved    <= {COUNT_W{1'b0}};
    end
end

always @* if (f_past) begin
    p_once:     assert (u_events.s_valid == (word_valid && f_event) && word_ready == (!f_event || events_ready));
    p_mark:     assert (u_mark.set == (f_in && f_type == 4'd8) && (!u_mark.set || u_mark.mark == f_word[59:32]));
    p_fields:   assert (!u_events.s_valid
                        || (u_events.s_known == timed && u_events.s_t == {high, f_word[59:54]} && u_events.s_x == {1'b0, f_word[53:43]}
                            && u_events.s_y == f_word[42:32] && u_events.s_p == (f_type == 4'd1) && u_events.s_mask == f_word[31:0]));
    p_reserved: assert (n_reserved == f_reserved);
    c_once:     cover (f_was_stalled && f_in && f_event);
    c_mark:     cover (u_mark.wrapped);
    c_fields:   cover (f_in && f_type == 4'd1 && timed);
    c_reserved: cover (n_reserved == 2);
end
