// SPDX-License-Identifier: Apache-2.0
// Stores the windows of all slots and finds the owner of an event: stages M (compare), E (encode) and, if FAR, D (choose) of the array.
//
// A probe is a rectangle. That of an event is its pixel: the active slot that holds it owns it, else the lowest candidate
// that does, else the lowest free slot. That of a check is a window: is there another active slot that shares a pixel
// with it, and which is the lowest? No two active windows overlap, so an event has at most one active owner.
//
// Lower bounds are passed and stored as complements (_not): a comparison is then an addition without an inverter.
//
// Latency:    1 clock from the probe to the result, 1 + FAR to the owner. A window that is written in one clock is
//             used in the next, a change of the free slots two clocks later for an event in E.
// Throughput: 1 probe per clock.
// Reset:      no slot has a window or is free.
// Stall:      none.
// Combinational paths: none.
`default_nettype none

module array_match #(
    parameter N      = 8,  // slots
    parameter FAR    = 0,  // 1: whose an event is comes a clock later
    parameter X_W    = 11, // bits of a bound, see cot_window.v
    parameter Y_W    = 11,
    parameter SLOT_W = 3   // bits of a slot number
) (
    input  wire              clk,
    input  wire              rst,

    // M: the probe
    input  wire              m_valid,
    input  wire              m_check,
    input  wire [SLOT_W-1:0] m_self,    // CHECK: whose window it is
    input  wire [X_W-1:0]    m_lo_x_not, m_hi_x,
    input  wire [Y_W-1:0]    m_lo_y_not, m_hi_y,

    // E: the answer; the slot where none is held is a free one, or `slot` where `names` asked for that the clock before
    input  wire              names,
    input  wire [SLOT_W-1:0] slot,
    output wire              e_other,   // a candidate holds the event; CHECK: an active slot overlaps
    output wire [SLOT_W-1:0] e_lowest,  // the lowest such slot

    // D if FAR, else E: whose the event is
    output reg               d_active,  // an active slot holds the event
    output reg               d_other,   // a candidate does
    output reg               d_free,    // some slot is free
    output wire [SLOT_W-1:0] d_slot,    // the first of these that holds

    // W: a slot's new window and state
    input  wire              w_places,
    input  wire              w_changes,
    input  wire [SLOT_W-1:0] w_slot,
    input  wire [X_W-1:0]    w_lo_x_not, w_hi_x,
    input  wire [Y_W-1:0]    w_lo_y_not, w_hi_y,
    input  wire              w_free,
    input  wire              w_window,
    input  wire              w_active,

    output reg  [N-1:0]      active     // visible
);

    (* mem2reg *) reg [X_W-1:0] lo_x_not [0:N-1];
    (* mem2reg *) reg [X_W-1:0] hi_x     [0:N-1];
    (* mem2reg *) reg [Y_W-1:0] lo_y_not [0:N-1];
    (* mem2reg *) reg [Y_W-1:0] hi_y     [0:N-1];

    localparam [N-1:0] FIRST = 1;

    reg [N-1:0] free;       // seeded, and no life has started
    reg [N-1:0] candidate;  // has a window, is not active

    // ---- M ---------------------------------------------------------------------------------------------------------

    reg [N-1:0] hit_active_reg, hit_other_reg;

    reg  [N-1:0] not_left, not_right, not_above, not_below;  // where the probe is not; anything where there is none
    wire [N-1:0] hit_active, hit_other;

    // Whose windows count.
    wire [N-1:0] myself = FIRST << m_self;
    wire [N-1:0] owners = active & {N{m_valid && !m_check}};
    wire [N-1:0] others = (m_check ? active & ~myself : candidate) & {N{m_valid}};

    always @* begin : compare
        integer i;
        reg [X_W:0] from_lo_x, to_hi_x;
        reg [Y_W:0] from_lo_y, to_hi_y;
        i = 0;
        {not_left, not_right, not_above, not_below} = {(4 * N) {1'bx}};
        {from_lo_x, to_hi_x, from_lo_y, to_hi_y} = {(2 * X_W + 2 * Y_W + 4) {1'bx}};
        if (m_valid)
            for (i = 0; i < N; i = i + 1) begin
                from_lo_x = {1'b0, m_hi_x} + {1'b0, lo_x_not[i]} + 1'b1;
                to_hi_x   = {1'b0, hi_x[i]} + {1'b0, m_lo_x_not} + 1'b1;
                from_lo_y = {1'b0, m_hi_y} + {1'b0, lo_y_not[i]} + 1'b1;
                to_hi_y   = {1'b0, hi_y[i]} + {1'b0, m_lo_y_not} + 1'b1;
                not_left[i]  = from_lo_x[X_W];
                not_right[i] = to_hi_x[X_W];
                not_above[i] = from_lo_y[Y_W];
                not_below[i] = to_hi_y[Y_W];
            end
    end

    array_hits #(
        .N(N)
    ) u_active (
        .not_left (not_left),
        .not_right(not_right),
        .not_above(not_above),
        .not_below(not_below),
        .counts   (owners),
        .hits     (hit_active)
    );
    array_hits #(
        .N(N)
    ) u_others (
        .not_left (not_left),
        .not_right(not_right),
        .not_above(not_above),
        .not_below(not_below),
        .counts   (others),
        .hits     (hit_other)
    );

    always @(posedge clk) begin
        hit_active_reg <= hit_active;
        hit_other_reg  <= hit_other;
    end

    // ---- E ---------------------------------------------------------------------------------------------------------

    reg               any_free_reg, refreshes;
    reg  [SLOT_W-1:0] else_slot;
    wire [SLOT_W-1:0] active_slot, free_slot;
    wire              any_free;

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_other (
        .asked (1'b1),
        .among (hit_other_reg),
        .any   (e_other),
        .lowest(e_lowest)
    );
    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_free (
        .asked (refreshes && !names),
        .among (free),
        .any   (any_free),
        .lowest(free_slot)
    );

    reg [SLOT_W-1:0] d_active_slot, d_other_slot, d_else_slot;

    generate
        if (FAR != 0) begin : g_far
            always @(posedge clk) begin
                d_active      <= |hit_active_reg;
                d_other       <= e_other;
                d_free        <= any_free_reg;
                d_active_slot <= active_slot;
                d_other_slot  <= e_lowest;
                d_else_slot   <= else_slot;
            end
        end else begin : g_near
            always @* begin
                d_active      = |hit_active_reg;
                d_other       = e_other;
                d_free        = any_free_reg;
                d_active_slot = active_slot;
                d_other_slot  = e_lowest;
                d_else_slot   = else_slot;
            end
        end
    endgenerate

    assign d_slot = d_active ? d_active_slot : d_other ? d_other_slot : d_else_slot;

    // Bit i of each number from 0 to 63.
    localparam [6*64-1:0] BITS = {
        64'hFFFF_FFFF_0000_0000, 64'hFFFF_0000_FFFF_0000, 64'hFF00_FF00_FF00_FF00,
        64'hF0F0_F0F0_F0F0_F0F0, 64'hCCCC_CCCC_CCCC_CCCC, 64'hAAAA_AAAA_AAAA_AAAA
    };

    genvar g;
    generate
        for (g = 0; g < SLOT_W; g = g + 1) begin : g_encode
            assign active_slot[g] = |(hit_active_reg & BITS[64*g+:N]);
        end
    endgenerate

    // ---- W ---------------------------------------------------------------------------------------------------------

    // Masks, since synthesis makes more of a bit with a variable number.
    wire [N-1:0] here = FIRST << w_slot;

    always @(posedge clk) begin
        if (w_places) begin
            lo_x_not[w_slot] <= w_lo_x_not;
            hi_x[w_slot]     <= w_hi_x;
            lo_y_not[w_slot] <= w_lo_y_not;
            hi_y[w_slot]     <= w_hi_y;
        end
        if (w_changes) begin
            free      <= w_free ? free | here : free & ~here;
            candidate <= (w_window && !w_active) ? candidate | here : candidate & ~here;
            active    <= w_active ? active | here : active & ~here;
        end
        refreshes    <= w_changes || names;
        if (names) else_slot <= slot;
        else if (refreshes) else_slot <= free_slot;
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
