// SPDX-License-Identifier: Apache-2.0
// The windows of all slots and whose an event is: stages M (compare) and E (encode) of the engine.
//
// A probe is a rectangle. That of an event is its pixel: the active slot that holds it owns it, else the lowest candidate
// that does, else the lowest free slot. That of a check is a window: is there another active slot that shares a pixel
// with it, and which is the lowest? No two active windows overlap, so an event has at most one active owner.
//
// Latency:    1 clock from the probe to the answer. A window that is written in one clock is there in the next, a change of
//             which slots are free two clocks later for an event in E.
// Throughput: 1 probe per clock.
// Reset:      no slot has a window or is free.
`default_nettype none

module engine_match #(
    parameter N      = 8,  // slots
    parameter X_W    = 11, // bits of a bound, see engine_window.v
    parameter Y_W    = 11,
    parameter SLOT_W = 3   // bits of a slot number
) (
    input  wire              clk,
    input  wire              rst,

    // M: the probe
    input  wire              m_valid,
    input  wire              m_check,
    input  wire [SLOT_W-1:0] m_self,    // CHECK: whose window it is
    input  wire [X_W-1:0]    m_lo_x, m_hi_x,
    input  wire [Y_W-1:0]    m_lo_y, m_hi_y,

    // E: the answer, and the slot where none is held: a free one, or `slot` where `names` asked for that the clock before
    input  wire              names,
    input  wire [SLOT_W-1:0] slot,
    output wire              e_active,  // an active slot holds the event
    output wire              e_other,   // a candidate does; CHECK: an active slot overlaps
    output wire              e_free,    // some slot is free
    output wire [SLOT_W-1:0] e_slot,    // the first of these that holds
    output wire [SLOT_W-1:0] e_lowest,  // the slot of e_other

    // W: a slot's new window and state
    input  wire              w_places,
    input  wire              w_changes,
    input  wire [SLOT_W-1:0] w_slot,
    input  wire [X_W-1:0]    w_lo_x, w_hi_x,
    input  wire [Y_W-1:0]    w_lo_y, w_hi_y,
    input  wire              w_free,
    input  wire              w_window,
    input  wire              w_active,

    output reg  [N-1:0]      active     // visible
);

    (* mem2reg *) reg [X_W-1:0] lo_x [0:N-1];
    (* mem2reg *) reg [X_W-1:0] hi_x [0:N-1];
    (* mem2reg *) reg [Y_W-1:0] lo_y [0:N-1];
    (* mem2reg *) reg [Y_W-1:0] hi_y [0:N-1];

    reg [N-1:0] free;       // seeded, and no life has started
    reg [N-1:0] candidate;  // has a window, is not active

    // ---- M ---------------------------------------------------------------------------------------------------------

    reg [N-1:0] hit_active_reg, hit_other_reg;

    always @(posedge clk) begin : compare
        integer i;
        reg is_self;
        reg [X_W:0] from_lo_x, to_hi_x;
        reg [Y_W:0] from_lo_y, to_hi_y;
        reg [N-1:0] hit_active, hit_other;
        hit_active = {N{1'b0}};
        hit_other  = {N{1'b0}};
        if (m_valid)
            for (i = 0; i < N; i = i + 1) begin
                is_self   = i[SLOT_W-1:0] == m_self;
                from_lo_x = {1'b0, m_hi_x} - {1'b0, lo_x[i]};
                to_hi_x   = {1'b0, hi_x[i]} - {1'b0, m_lo_x};
                from_lo_y = {1'b0, m_hi_y} - {1'b0, lo_y[i]};
                to_hi_y   = {1'b0, hi_y[i]} - {1'b0, m_lo_y};
                if (!from_lo_x[X_W] && !to_hi_x[X_W] && !from_lo_y[Y_W] && !to_hi_y[Y_W]) begin
                    hit_active[i] = active[i] && !m_check;
                    hit_other[i]  = m_check ? active[i] && !is_self : candidate[i];
                end
            end
        hit_active_reg <= hit_active;
        hit_other_reg  <= hit_other;
    end

    // ---- E ---------------------------------------------------------------------------------------------------------

    reg               any_free_reg;
    reg  [SLOT_W-1:0] else_slot, active_slot;
    wire [SLOT_W-1:0] free_slot;
    wire              any_free;

    engine_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_other (
        .among (hit_other_reg),
        .any   (e_other),
        .lowest(e_lowest)
    );
    engine_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_free (
        .among (free),
        .any   (any_free),
        .lowest(free_slot)
    );

    assign e_free   = any_free_reg;
    assign e_active = |hit_active_reg;
    assign e_slot   = e_active ? active_slot : e_other ? e_lowest : else_slot;

    always @* begin : encode
        integer i;
        i           = 0;  // on every path, or it would be a latch
        active_slot = {SLOT_W{1'b0}};
        if (e_active) for (i = 0; i < N; i = i + 1) active_slot = active_slot | ({SLOT_W{hit_active_reg[i]}} & i[SLOT_W-1:0]);
    end

    // ---- W ---------------------------------------------------------------------------------------------------------

    always @(posedge clk) begin
        if (w_places) begin
            lo_x[w_slot] <= w_lo_x;
            hi_x[w_slot] <= w_hi_x;
            lo_y[w_slot] <= w_lo_y;
            hi_y[w_slot] <= w_hi_y;
        end
        if (w_changes) begin
            free[w_slot]      <= w_free;
            candidate[w_slot] <= w_window && !w_active;
            active[w_slot]    <= w_active;
        end
        else_slot    <= names ? slot : free_slot;
        any_free_reg <= any_free;
        if (rst) begin
            free         <= {N{1'b0}};
            candidate    <= {N{1'b0}};
            active       <= {N{1'b0}};
            any_free_reg <= 1'b0;
        end
    end

endmodule

`default_nettype wire
