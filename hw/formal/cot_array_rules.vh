// SPDX-License-Identifier: Apache-2.0
// Included at the end of cot_array.v under `ifdef FORMAL: properties of every reachable state, for all inputs, register values
// and stalls. Proven by k-induction with cot_array.sby.
//
// 1  While events are decided, no two active windows share a pixel.
// 2  While a merge is under way, at most one window may overlap others: the one that moved, later the one that stays.
// 3  A slot is free, or has a window, or is off; an active one has a window and a deadline.
// 4  An output that waits keeps its value.
// 5  Every slot appears exactly once in the list in order of birth.

reg f_past = 1'b0;
always @(posedge clk) f_past <= 1'b1;
always @* if (!f_past) assume (rst);

function f_shared(input integer a, input integer b);
    f_shared = active[a] && active[b]
            && lo_x[a*X_W +: X_W] <= hi_x[b*X_W +: X_W] && lo_x[b*X_W +: X_W] <= hi_x[a*X_W +: X_W]
            && lo_y[a*Y_W +: Y_W] <= hi_y[b*Y_W +: Y_W] && lo_y[b*Y_W +: Y_W] <= hi_y[a*Y_W +: Y_W];
endfunction

genvar f_i, f_j;
generate
    for (f_i = 0; f_i < N; f_i = f_i + 1) begin : f_slot
        always @* if (f_past && !rst) assert (order[f_i*SLOT_W +: SLOT_W] < N);  // rule 5
        always @* if (f_past) begin
            assert (!(free[f_i] && window[f_i]));                                // rule 3
            assert (!active[f_i] || (window[f_i] && timed[f_i]));
            assert (!timed[f_i] || window[f_i]);
        end
        for (f_j = 0; f_j < f_i; f_j = f_j + 1) begin : f_pair
            always @* if (f_past && !rst) assert (order[f_i*SLOT_W +: SLOT_W] != order[f_j*SLOT_W +: SLOT_W]);
            wire f_excused = (phase != RUN) && (phase == DIVIDE ? (stays == f_i || stays == f_j) : (moved == f_i || moved == f_j));
            always @* if (f_past && !rst) assert (f_excused || !f_shared(f_i, f_j));  // rules 1 and 2
        end
    end
endgenerate

always @* if (f_past && !rst) begin
    assert (phase <= REPORT);
    assert (phase != CHECK && phase != REPORT || active[moved]);
    assert (phase != ABSORB || (stays != goes && (moved == stays || moved == goes) && active[stays] && active[goes]));
    assert (phase != DIVIDE || (active[stays] && !active[goes] && (moved == stays || moved == goes)));
end

// rule 4
always @(posedge clk) if (f_past && !rst && !$past(rst)) begin
    if ($past(m_cm_valid && !m_cm_ready)) begin
        assert (m_cm_valid);
        assert ($stable({m_cm_kind, m_cm_slot, m_cm_id, m_cm_other, m_cm_x, m_cm_y}));
        assert ($stable({m_cm_radius, m_cm_n_ev, m_cm_support, m_cm_seq, m_cm_time}));
    end
    if ($past(m_own_valid && !m_own_ready)) begin
        assert (m_own_valid);
        assert ($stable({m_own_slot, m_own_x, m_own_y, m_own_p, m_own_seq}));
    end
    if ($past(m_pass_valid && !m_pass_ready)) begin
        assert (m_pass_valid);
        assert ($stable({m_pass_x, m_pass_y, m_pass_p, m_pass_seq}));
    end
end

// Every kind of record, and two merges after one event, can happen.
always @(posedge clk) if (f_past && !rst) begin
    cover (m_cm_valid && m_cm_kind == `EVCOT_KIND_LOST);
    cover (m_cm_valid && m_cm_kind == `EVCOT_KIND_MERGED);
end
