// SPDX-License-Identifier: Apache-2.0
// What has been computed of a slot: block RAMs that are read at one slot, all at once, and written in groups.
//
// Of sides, offsets and moves, axes have words of their own: one is read at once, and both are written one after the other, in the clock
// of their command and in the next one.
//
// Latency:    2 clocks from `at` to what that slot has, from `from` to box and window, and from e_slot to what takes effect.
// Throughput: a slot per clock. What is read in the clock of its own write is not defined.
// Stall:      none.
// Reset:      none, nothing is used before it was written.
// Combinational paths: none.
`default_nettype none

module motion_context #(
    parameter SLOT_W = 3,
    parameter SIDE_W = 25,
    parameter PX_W   = 13,
    parameter REL_W  = 10,  // bits of a recentred address
    parameter SUP_W  = 16,
    parameter ID_W   = 32
) (
    input  wire                clk,
    input  wire [SLOT_W-1:0]   at,
    input  wire [SLOT_W-1:0]   from,         // slot whose box and window are read
    input  wire [SLOT_W-1:0]   e_slot,       // slot that takes effect

    input  wire                keep,         // the state is written,
    input  wire                keep_window,
    input  wire                keep_id,
    input  wire                ask_start,    // the start is read, else the id
    input  wire                on_y,         // the start of which axis is read, or written
    input  wire                read_y,       // of which axis sides, refs and moves are read
    input  wire                keep_start,   // the place at the fourth correction; not with keep_id
    input  wire                finish,       // what takes effect

    input  wire                sides_y,      // these are of y: low and high in turn
    input  wire [2*SIDE_W-1:0] sides,        // lo and hi
    input  wire [2*SIDE_W-1:0] refs,
    input  wire                moves_y,      // these are
    input  wire [2*SIDE_W-1:0] moves,        // how far sides move as they take effect
    input  wire [SUP_W-1:0]    support,
    input  wire                merged,       // since its last correction
    input  wire [3:0]          marks,        // sides that a merge has marked
    input  wire [1:0]          state,
    input  wire [31:0]         v,            // y, x
    input  wire [5:0]          corrections,
    input  wire [7:0]          looked,
    input  wire [4:0]          meets,        // hidden sides, and whether it does
    input  wire [7:0]          runs,
    input  wire [9:0]          n_ev,
    input  wire                has_partner,
    input  wire [SLOT_W-1:0]   partner,
    input  wire [15:0]         together,
    input  wire [23:0]         usual,
    input  wire [4*PX_W-1:0]   box,
    input  wire [4*PX_W-1:0]   window,
    input  wire [2*REL_W-1:0]  middle,       // of the box, half pixels, y and x
    input  wire [ID_W-1:0]     id,
    input  wire [SIDE_W:0]     start,        // sum of both sides
    input  wire [9:0]          log2,

    output wire [2*SIDE_W-1:0] q_sides,
    output wire [2*SIDE_W-1:0] q_refs,
    output wire [2*SIDE_W-1:0] q_moves,
    output wire [SUP_W-1:0]    q_support,
    output wire                q_merged,
    output wire [31:0]         q_v,
    output wire [5:0]          q_corrections,
    output wire [7:0]          q_looked,
    output wire [4:0]          q_meets,
    output wire [7:0]          q_runs,
    output wire [9:0]          q_n_ev,
    output wire                q_has_partner,
    output wire [SLOT_W-1:0]   q_partner,
    output wire [15:0]         q_together,
    output wire [23:0]         q_usual,
    output wire [9:0]          q_log2,
    output wire [ID_W-1:0]     q_id,
    output wire [SIDE_W:0]     q_start,
    output wire [4*PX_W-1:0]   p_box,
    output wire [4*PX_W-1:0]   p_window,

    output wire [1:0]          e_state,
    output wire [4*SIDE_W-1:0] e_moves,      // lo and hi of x, lo and hi of y
    output wire [3:0]          e_marks,
    output wire [3:0]          e_hidden,
    output wire [2*REL_W-1:0]  e_middle,
    output wire [9:0]          e_n_ev
);

    localparam STATE_W  = SUP_W + SLOT_W + 121;
    localparam EFFECT_W = 2 * REL_W + 20;
    localparam ADDR_W  = SLOT_W > 7 ? SLOT_W : 7;  // more than 64 words, for block RAM on every device
    localparam DEPTH   = 1 << ADDR_W;
    localparam AXES_W  = SLOT_W > 6 ? SLOT_W + 1 : 7;

    localparam PLACE_W  = (ID_W > SIDE_W + 1 ? ID_W : SIDE_W + 1) + 1;  // more than either
    localparam PLACES_W = SLOT_W > 5 ? SLOT_W + 2 : 7;

    wire [PLACE_W-1:0]  place;
    wire [PLACES_W-1:0] of_start = {{(PLACES_W - SLOT_W - 1) {1'b0}}, at, on_y};
    wire [PLACES_W-1:0] of_id    = {{(PLACES_W - SLOT_W - 1) {1'b0}}, at, 1'b0} | ({{(PLACES_W - 1) {1'b0}}, 1'b1} << SLOT_W + 1);

    assign q_id    = place[ID_W-1:0];
    assign q_start = place[SIDE_W:0];

    wire unused = &{1'b0, place};

    wire [ADDR_W-1:0] of_at    = {{(ADDR_W - SLOT_W) {1'b0}}, at};
    wire [ADDR_W-1:0] of_place = {{(ADDR_W - SLOT_W) {1'b0}}, from};
    wire [ADDR_W-1:0] of_effect = {{(ADDR_W - SLOT_W) {1'b0}}, e_slot};

    reg  keeps, finishes;  // in the clock before
    wire [AXES_W-1:0] of_read  = {{(AXES_W - SLOT_W - 1) {1'b0}}, at, read_y};
    wire [AXES_W-1:0] of_sides = {{(AXES_W - SLOT_W - 1) {1'b0}}, at, sides_y};
    wire [AXES_W-1:0] of_moves = {{(AXES_W - SLOT_W - 1) {1'b0}}, at, moves_y};

    always @(posedge clk) {keeps, finishes} <= {keep, finish};

    block_memory #(
        .W    (4 * SIDE_W),
        .DEPTH(1 << AXES_W)
    ) u_sides (
        .clk          (clk),
        .write        (keep || keeps),
        .write_address(of_sides),
        .write_data   ({sides, refs}),
        .read_enable  (1'b1),
        .read_address (of_read),
        .out_enable   (1'b1),
        .read_data    ({q_sides, q_refs})
    );

    block_memory #(
        .W    (STATE_W),
        .DEPTH(DEPTH)
    ) u_states (
        .clk          (clk),
        .write        (keep),
        .write_address(of_at),
        .write_data   ({
            support, merged, v, corrections, looked, meets, runs, n_ev, has_partner, partner, together, usual, log2
        }),
        .read_enable  (1'b1),
        .read_address (of_at),
        .out_enable   (1'b1),
        .read_data    ({
            q_support, q_merged, q_v, q_corrections, q_looked, q_meets, q_runs, q_n_ev, q_has_partner, q_partner, q_together, q_usual,
            q_log2
        })
    );

    // The id and, of each axis, the start.
    block_memory #(
        .W    (PLACE_W),
        .DEPTH(1 << PLACES_W)
    ) u_places (
        .clk          (clk),
        .write        (keep_start || keep_id),
        .write_address(keep_id ? of_id : of_start),
        .write_data   (keep_id ? {{(PLACE_W - ID_W) {1'b0}}, id} : {{(PLACE_W - SIDE_W - 1) {1'b0}}, start}),
        .read_enable  (1'b1),
        .read_address (ask_start ? of_start : of_id),
        .out_enable   (1'b1),
        .read_data    (place)
    );

    block_memory #(
        .W    (8 * PX_W),
        .DEPTH(DEPTH)
    ) u_windows (
        .clk          (clk),
        .write        (keep_window),
        .write_address(of_at),
        .write_data   ({box, window}),
        .read_enable  (1'b1),
        .read_address (of_place),
        .out_enable   (1'b1),
        .read_data    ({p_box, p_window})
    );

    block_memory #(
        .W    (2 * SIDE_W),
        .DEPTH(1 << AXES_W)
    ) u_moves (
        .clk          (clk),
        .write        (finish || finishes),
        .write_address(of_moves),
        .write_data   (moves),
        .read_enable  (1'b1),
        .read_address (of_read),
        .out_enable   (1'b1),
        .read_data    (q_moves)
    );

    // What takes effect, and the moves of each axis.
    block_memory #(
        .W    (EFFECT_W),
        .DEPTH(DEPTH)
    ) u_effects (
        .clk          (clk),
        .write        (finish),
        .write_address(of_at),
        .write_data   ({state, marks, meets[4:1], middle, n_ev}),
        .read_enable  (1'b1),
        .read_address (of_effect),
        .out_enable   (1'b1),
        .read_data    ({e_state, e_marks, e_hidden, e_middle, e_n_ev})
    );

    genvar i;
    generate
        for (i = 0; i < 2; i = i + 1) begin : g_effect
            block_memory #(
                .W    (2 * SIDE_W),
                .DEPTH(DEPTH)
            ) u_moves (
                .clk          (clk),
                .write        ((finish || finishes) && moves_y == (i == 0)),
                .write_address(of_at),
                .write_data   (moves),
                .read_enable  (1'b1),
                .read_address (of_effect),
                .out_enable   (1'b1),
                .read_data    (e_moves[2*i*SIDE_W+:2*SIDE_W])
            );
        end
    endgenerate

endmodule

`default_nettype wire
