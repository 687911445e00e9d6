// SPDX-License-Identifier: Apache-2.0
// Which slots' boxes and windows hold a column, or a row: a word for each in block RAM, with two bits per slot in each of two planes.
//
// `plane` says in which plane a slot's bits are in effect. An update writes the other one, while events are looked up. It visits only
// words that differ between the new interval and the one that the plane has, whose edges are in a memory of their own.
//
// Latency:    2 clocks from `place` to in_box and in_window. 9 to 11 clocks from `start` until `busy` is low, and one more for each word that
//             changes; the last words are written in the two clocks behind that.
// Throughput: a lookup per clock, an update at a time.
// Stall:      none. What is looked up of a word in the clock of its write is not defined: `writes_next` and `next_word` tell of it.
// Reset:      clears all words, then `ready` is high: 2^C_W + 3 clocks.
// Combinational paths: plane -> in_box, in_window.
`default_nettype none

module motion_mask #(
    parameter N      = 8,   // slots
    parameter SLOT_W = 3,   // bits of a slot number
    parameter AT_W   = 9,   // bits of an address
    parameter PX_W   = 13   // bits of a bound in pixels, signed, more than of an address
) (
    input  wire              clk,
    input  wire              rst,
    output reg               ready,      // the memories are cleared

    // an event
    input  wire [AT_W-1:0]   place,
    output wire [N-1:0]      in_box,     // two clocks later
    output wire [N-1:0]      in_window,
    input  wire [N-1:0]      plane,      // with them: the one in effect, of each slot

    // an update of a slot
    input  wire              start,
    input  wire [SLOT_W-1:0] slot,       // with start, and in the clock before
    input  wire              target,     // the plane that is written
    input  wire [N-1:0]      chosen,     // from the next clock on until it is done: a one for the slot, after reset for all slots
    input  wire signed [PX_W-1:0] box_lo,     // from then on until it is done
    input  wire signed [PX_W-1:0] box_hi,
    input  wire signed [PX_W-1:0] window_lo,  // from two clocks later on
    input  wire signed [PX_W-1:0] window_hi,
    output wire              busy,
    output wire              writes_next, // in the next clock this word is written
    output wire [AT_W-1:0]   next_word
);

    localparam COLUMN_W = AT_W + 1;                                        // of an edge: 0 to 2^AT_W
    localparam EDGES_W  = SLOT_W + 3;                                      // slot, plane, box or window, low or high
    localparam C_W      = COLUMN_W > EDGES_W ? COLUMN_W : EDGES_W;
    localparam ADDR_W   = EDGES_W > 7 ? EDGES_W : 7;                       // more than 64 words, for block RAM on every device

    localparam [2:0] CLEAR   = 3'd0;  // all words, after reset
    localparam [2:0] REST    = 3'd1;  // the first edge of `slot` is read
    localparam [2:0] LOW     = 3'd2;  // both low edges are there
    localparam [2:0] HIGH    = 3'd3;  // they are compared; both high edges are there
    localparam [2:0] PICK    = 3'd6;  // these are compared: does a low edge change?
    localparam [2:0] UP      = 3'd4;  // from the lower low edge up to the next edge
    localparam [2:0] DOWN    = 3'd5;  // from the upper high edge down to the next edge

    reg  [2:0]        state;
    reg  [SLOT_W-1:0] to_slot;
    reg               to_plane;
    reg               on_window;             // of box and window, the second interval
    reg  [1:0]        edge_next, edge_1;     // that is read next; that comes to the output register
    wire [1:0]        edge_0    = state == REST ? {1'b0, start} : edge_next;
    reg  [AT_W:0]     fresh;                 // the edge as it will be,
    wire [AT_W:0]     old;                   // as it is
    reg  [C_W-1:0]    column;
    reg  [AT_W:0]     low_end, high_end;     // the inner ones of four edges: a walk ends at the first that it meets
    reg  [AT_W:0]     top;                   // the upper high edge
    reg               up_value, down_value;  // what words of each walk will have

    // Stages of a write: 0 reads the word, 2 writes it.
    reg               valid_1, valid_2, box_1, box_2, window_1, window_2, value_1, value_2, plane_1, plane_2;
    reg  [AT_W-1:0]   column_1, column_2;

    wire              clears    = state == CLEAR;
    wire              less      = fresh < old;
    wire [AT_W:0]     lesser    = less ? fresh : old;
    wire [AT_W:0]     greater   = less ? old : fresh;
    reg               less_1;                // a clock later
    reg  [AT_W:0]     lesser_1, greater_1;
    wire              low_stays = column[AT_W:0] == low_end;  // in PICK
    wire              ends      = low_stays || column[AT_W:0] == high_end;
    wire [C_W-1:0]    next      = column + {{(C_W - 1) {state == DOWN}}, 1'b1};
    wire [AT_W-1:0]   column_0  = state == DOWN ? next[AT_W-1:0] : column[AT_W-1:0];
    wire              plane_0   = clears ? column[AT_W] : to_plane;
    wire              advances  = state == REST || state == LOW || state == HIGH;

    assign busy        = state != REST;
    assign writes_next = valid_1;
    assign next_word   = column_1;

    // An edge on the sensor: the low one is the first column, the high one that behind the last.
    wire signed [PX_W-1:0] bound  = edge_1[1] ? (edge_1[0] ? window_hi : window_lo) : (edge_1[0] ? box_hi : box_lo);
    wire signed [PX_W:0]   behind = {bound[PX_W-1], bound} + {{PX_W{1'b0}}, edge_1[0]};
    wire                   beyond = !behind[PX_W] && |behind[PX_W-1:AT_W];

    always @(posedge clk) begin
        if (advances) begin
            edge_next <= state == REST ? 2'd2 : edge_next + 2'd1;
            edge_1    <= edge_0;
            fresh     <= {beyond, behind[PX_W] || beyond ? {AT_W{1'b0}} : behind[AT_W-1:0]};
        end
        less_1    <= less;
        lesser_1  <= lesser;
        greater_1 <= greater;
        valid_1  <= clears || ((state == UP || state == DOWN) && !ends);
        box_1    <= clears || !on_window;
        window_1 <= clears || on_window;
        value_1  <= !clears && (state == UP ? up_value : down_value);
        plane_1  <= plane_0;
        column_1 <= column_0;
        valid_2  <= valid_1;
        box_2    <= box_1;
        window_2 <= window_1;
        value_2  <= value_1;
        plane_2  <= plane_1;
        column_2 <= column_1;
        case (state)
            CLEAR: begin
                column <= next;
                if (&column) state <= REST;
            end
            LOW: state <= HIGH;
            HIGH: begin
                column[AT_W:0] <= lesser_1;
                low_end        <= greater_1;
                up_value       <= less_1;
                state          <= PICK;
            end
            PICK: begin
                high_end   <= lesser_1;
                top        <= greater_1;
                down_value <= !less_1;
                state      <= UP;
                if (low_stays) begin
                    column[AT_W:0] <= greater_1;
                    state          <= DOWN;
                end
            end
            UP: begin
                column <= next;
                if (ends) begin
                    column[AT_W:0] <= top;
                    state          <= DOWN;
                end
            end
            DOWN: begin
                column <= next;
                if (ends) begin
                    on_window <= 1'b1;
                    state     <= on_window ? REST : LOW;
                end
            end
            default: ;
        endcase
        if (state == REST) begin
            on_window <= 1'b0;
            to_slot   <= slot;
            to_plane  <= target;
            if (start) state <= LOW;
        end
        ready <= ready || (!clears && !valid_1 && !valid_2);
        if (rst) begin
            state   <= CLEAR;
            column  <= {C_W{1'b0}};
            fresh   <= {COLUMN_W{1'b0}};  // of all slots, until the first is updated
            valid_1 <= 1'b0;
            valid_2 <= 1'b0;
            ready   <= 1'b0;
        end
    end

    // Edges that each plane has, of each slot.
    wire [EDGES_W-1:0] edge_read  = {state == REST ? {slot, target} : {to_slot, to_plane}, edge_0};
    wire [EDGES_W-1:0] edge_write = clears ? column[EDGES_W-1:0] : {to_slot, to_plane, on_window, state == HIGH};

    block_memory #(
        .W    (COLUMN_W),
        .DEPTH(1 << ADDR_W)
    ) u_edges (
        .clk          (clk),
        .write        (clears || state == LOW || state == HIGH),
        .write_address({{(ADDR_W - EDGES_W) {1'b0}}, edge_write}),
        .write_data   (fresh),
        .read_enable  (advances),
        .read_address ({{(ADDR_W - EDGES_W) {1'b0}}, edge_read}),
        .out_enable   (advances),
        .read_data    (old)
    );

    // The words, of windows and boxes: of both planes for the update, of each plane for events.
    wire [2*N-1:0] word, word_a, word_b;
    wire [2*N-1:0] changes = {chosen & {N{window_2}}, chosen & {N{box_2}}};
    wire [2*N-1:0] written = (word & ~changes) | (changes & {(2 * N) {value_2}});

    block_memory #(
        .W    (2 * N),
        .DEPTH(2 << AT_W)
    ) u_words (
        .clk          (clk),
        .write        (valid_2),
        .write_address({plane_2, column_2}),
        .write_data   (written),
        .read_enable  (1'b1),
        .read_address ({plane_0, column_0}),
        .out_enable   (1'b1),
        .read_data    (word)
    );

    block_memory #(
        .W    (2 * N),
        .DEPTH(1 << AT_W)
    ) u_plane_a (
        .clk          (clk),
        .write        (valid_2 && !plane_2),
        .write_address(column_2),
        .write_data   (written),
        .read_enable  (1'b1),
        .read_address (place),
        .out_enable   (1'b1),
        .read_data    (word_a)
    );

    block_memory #(
        .W    (2 * N),
        .DEPTH(1 << AT_W)
    ) u_plane_b (
        .clk          (clk),
        .write        (valid_2 && plane_2),
        .write_address(column_2),
        .write_data   (written),
        .read_enable  (1'b1),
        .read_address (place),
        .out_enable   (1'b1),
        .read_data    (word_b)
    );

    assign in_box    = (plane & word_b[N-1:0]) | (~plane & word_a[N-1:0]);
    assign in_window = (plane & word_b[2*N-1:N]) | (~plane & word_a[2*N-1:N]);

endmodule

`default_nettype wire
