// SPDX-License-Identifier: Apache-2.0
// Included at the end of cot_array.v under `ifdef FORMAL: properties of every reachable state, for all inputs, register values
// and stalls. Rule 4 is proven for owned and passed events by k-induction with cot_array.sby. The others, and rule 4 for records, hold for
// the first 14 clocks (task `owners`, which tries the induction too), but are not inductive yet: an invariant of operations and merges
// is missing. Tests replay them on every record.
//
// 1  While an event is decided, no two active windows share a pixel.
// 2  An event goes to the active slot whose window holds it at that moment, and passes only where there is none.
// 3  Between a window's change and the check that finds no other in it, every pair that overlaps has that slot, f_slot, in it.
// 4  An output that waits keeps its value.

reg f_past = 1'b0;
always @(posedge clk) f_past <= 1'b1;
always @* if (!f_past) assume (rst);

`ifdef FORMAL_OWNERS
// The window that may overlap others: the one that moved, then the one that stays.
reg              f_dirty;
reg [SLOT_W-1:0] f_slot;
reg [SLOT_W-1:0] f_u_slot;

always @(posedge clk) begin
    f_u_slot <= c_slots[SLOT_W-1:0];
    if (e_check && !e_other) f_dirty <= 1'b0;
    if (w_checks) begin
        f_dirty <= 1'b1;
        f_slot  <= w_slot;
    end
    if (rst) f_dirty <= 1'b0;
end

wire f_merges = why == MERGE && (phase == REPORT || phase == CLEAR || phase == SETTLE || phase == JOIN);

genvar f_i, f_j;
generate
    for (f_i = 0; f_i < N; f_i = f_i + 1) begin : f_each
        for (f_j = 0; f_j < f_i; f_j = f_j + 1) begin : f_pair
            always @* if (f_past && !rst) assert (!f_shared[N*f_i+f_j] || (f_dirty && (f_slot == f_i || f_slot == f_j)));  // rule 3
        end
    end
endgenerate

always @* if (f_past && !rst) begin
    if (u_valid && (u_takes || u_passes)) begin
        assert (f_shared == {(N * N) {1'b0}});                                                     // rule 1
        assert (!(|(f_holds & active)) || (u_takes && f_holds[f_u_slot] && active[f_u_slot]));      // rule 2
    end
    // What the merge knows of the two.
    assert (phase <= JOIN);
    assert (phase != FETCH || (step <= FETCHED[STEP_W-1:0] && f_dirty && f_slot == moved && moved != found_slot
                               && active[moved] && active[found_slot]));
    assert (!found || (f_dirty && f_slot == moved && moved != found_slot && active[moved] && active[found_slot]));
    assert (!f_merges || (f_dirty && stays != goes && (f_slot == stays || f_slot == goes) && active[stays]));
    assert (!(f_merges && (phase == REPORT || phase == CLEAR)) || (active[goes] && slow_slot == goes));
    assert (!(f_merges && phase == JOIN) || (!active[goes] && slow_slot == stays));
end
`endif

// rule 4
always @(posedge clk) if (f_past && !rst && !$past(rst)) begin
`ifdef FORMAL_OWNERS
    if ($past(m_cm_valid && !m_cm_ready)) begin
        assert (m_cm_valid);
        assert ($stable({m_cm_kind, m_cm_slot, m_cm_id, m_cm_other, m_cm_x, m_cm_y}));
        assert ($stable({m_cm_radius, m_cm_n_ev, m_cm_support, m_cm_seq, m_cm_time}));
    end
`endif
    if ($past(m_own_valid && !m_own_ready)) begin
        assert (m_own_valid);
        assert ($stable({m_own_slot, m_own_x, m_own_y, m_own_p, m_own_seq}));
    end
    if ($past(m_pass_valid && !m_pass_ready)) begin
        assert (m_pass_valid);
        assert ($stable({m_pass_x, m_pass_y, m_pass_p, m_pass_seq}));
    end
end
