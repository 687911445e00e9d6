// SPDX-License-Identifier: Apache-2.0
/*
[properties]
stable = "a beat that is not taken stays"
packet = "each beat is a packet of eight bytes"

[[tasks]]
name = "defaults"
k = 2
covers_within = 6
quick = true

[[faults]]
file = "skid_buffer.v"
meaning = "a beat is replaced while it waits"
right = "output_free = m_ready || !m_valid_reg"
wrong = "output_free = 1'b1"
breaks = ["stable"]
within = 8

[[faults]]
meaning = "packets do not end"
right = "m_axis_tlast = 1'b1"
wrong = "m_axis_tlast = 1'b0"
breaks = ["packet"]
within = 4
*/
// skid_buffer.vh says that words leave in order and once.
(* hierconn *) wire \u_output.s_ready_reg ;
(* hierconn *) wire \u_output.skid_valid_reg ;
reg        f_was_stalled;
reg [63:0] f_was;
always @(posedge clk) begin
    f_was_stalled <= m_axis_tvalid && !m_axis_tready && !rst;
    f_was         <= m_axis_tdata;
end

always @* if (f_past) begin
    p_stable: assert (!f_was_stalled || (m_axis_tvalid && m_axis_tdata == f_was));
    p_packet: assert (m_axis_tkeep == 8'hff && m_axis_tlast);
    i_skid:   assert (!(u_output.s_ready_reg && u_output.skid_valid_reg));
    c_stable: cover (f_was_stalled && m_axis_tready);
    c_packet: cover (m_axis_tvalid && s_own_valid);
end
