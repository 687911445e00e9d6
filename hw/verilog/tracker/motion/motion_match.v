// SPDX-License-Identifier: Apache-2.0
// Whose an event is: docs/motion.md, rule O1. Boxes and windows are masks in block RAM, motion_mask.v, one per axis.
//
// The owner is the lowest visible slot whose box holds the event, else the lowest visible one by its window, else the lowest candidate by
// its window, else the lowest free slot that may begin. Box and window of a slot are written beside events, into the plane of the masks
// that is not in effect; `place` puts that plane in effect.
//
// Latency:    4 clocks from an event to its owner. The event that comes a clock before `place`, and those behind it, have the new box and
//             window. For `update` see motion_mask.v: an event may have
//             what it wrote three clocks behind `busy`.
// Throughput: an event per clock, an update at a time.
// Stall:      none, but for an event that `collides`.
// Reset:      masks are cleared, then `ready` is high: see motion_mask.v.
// Combinational paths: x, y, next_x, next_y -> collides.
`default_nettype none

module motion_match #(
    parameter N      = 8,   // slots
    parameter X_W    = 9,   // bits of an address
    parameter Y_W    = 9,
    parameter PX_W   = 13,  // bits of a bound in pixels, signed
    parameter SLOT_W = 3    // bits of a slot number
) (
    input  wire              clk,
    input  wire              rst,
    output wire              ready,       // for events and updates

    input  wire [X_W-1:0]    x,           // an event
    input  wire [Y_W-1:0]    y,
    input  wire [X_W-1:0]    next_x,      // one that may come in the next clock, beside it
    input  wire [Y_W-1:0]    next_y,
    output wire              collides,    // neither may come in the next clock: the word of one is being written then

    // two clocks later
    input  wire [N-1:0]      visible,
    input  wire [N-1:0]      candidate,
    input  wire [N-1:0]      fresh,       // free, and without a track that may return: a candidate begins in one of these
    input  wire [N-1:0]      empty,       // free: or in one of these, if none is fresh

    // three clocks later
    input  wire              asked,       // low: the owner does not count, and a simulator need not find it
    input  wire              is_op,       // the owner is this one
    input  wire [SLOT_W-1:0] op_slot,

    // four clocks later
    output reg               owned,       // else it is nobody's
    output reg               begins,      // in this slot a candidate does
    output reg               shared,      // among several visible ones
    output reg  [SLOT_W-1:0] owner,

    // box and window of a slot, each: low and high on x, low and high on y
    input  wire              update,      // they are written, while not `busy`
    input  wire [SLOT_W-1:0] update_slot, // then, and in the clock before
    input  wire [4*PX_W-1:0] box,         // until `busy` is low
    input  wire [4*PX_W-1:0] window,      // from two clocks later on
    output wire              busy,
    input  wire              place,       // what was written last is in effect
    input  wire [SLOT_W-1:0] place_slot
);

    localparam LEAVES = 1 << SLOT_W;

    wire [N-1:0] one = {{(N - 1) {1'b0}}, 1'b1};
    reg  [N-1:0] plane;   // that is in effect, of each slot
    reg  [N-1:0] chosen;  // the slot that is updated; all, until the first is
    wire         writes_x, writes_y;
    wire [X_W-1:0] word_x;
    wire [Y_W-1:0] word_y;
    wire         ready_x, ready_y, busy_x, busy_y;
    wire [N-1:0] box_x, box_y, window_x, window_y;

    assign ready = ready_x && ready_y;
    assign busy  = busy_x || busy_y;
    assign collides = (writes_x && (word_x == x || word_x == next_x)) || (writes_y && (word_y == y || word_y == next_y));

    always @(posedge clk) begin
        if (place) plane <= plane ^ (one << place_slot);
        if (update) chosen <= one << update_slot;
        if (rst) begin
            plane  <= {N{1'b0}};
            chosen <= {N{1'b1}};
        end
    end

    motion_mask #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .AT_W  (X_W),
        .PX_W  (PX_W)
    ) u_x (
        .clk      (clk),
        .rst      (rst),
        .ready    (ready_x),
        .place    (x),
        .in_box   (box_x),
        .in_window(window_x),
        .plane    (plane),
        .start    (update),
        .slot     (update_slot),
        .target   (!plane[update_slot]),
        .chosen   (chosen),
        .box_lo   (box[3*PX_W+:PX_W]),
        .box_hi   (box[2*PX_W+:PX_W]),
        .window_lo(window[3*PX_W+:PX_W]),
        .window_hi(window[2*PX_W+:PX_W]),
        .busy     (busy_x),
        .writes_next(writes_x),
        .next_word(word_x)
    );

    motion_mask #(
        .N     (N),
        .SLOT_W(SLOT_W),
        .AT_W  (Y_W),
        .PX_W  (PX_W)
    ) u_y (
        .clk      (clk),
        .rst      (rst),
        .ready    (ready_y),
        .place    (y),
        .in_box   (box_y),
        .in_window(window_y),
        .plane    (plane),
        .start    (update),
        .slot     (update_slot),
        .target   (!plane[update_slot]),
        .chosen   (chosen),
        .box_lo   (box[PX_W+:PX_W]),
        .box_hi   (box[0+:PX_W]),
        .window_lo(window[PX_W+:PX_W]),
        .window_hi(window[0+:PX_W]),
        .busy     (busy_y),
        .writes_next(writes_y),
        .next_word(word_y)
    );

    // Slots whose box or window holds the event, by kinds. Of each kind the lowest is found; then the first kind with one decides.
    reg  [N-1:0]      by_box, by_window, by_candidate;
    reg               any_free;
    reg  [SLOT_W-1:0] free;
    wire              any_box, any_window, any_candidate, any_empty;
    wire [SLOT_W-1:0] of_box, of_window, of_candidate, of_free;

    // Two or more: within a half of the slots, or one in each.
    function several;
        input [N-1:0] among;
        integer k;
        reg [4*LEAVES-1:0] node;  // any and several, of each node of a tree
        begin
            node = {(4 * LEAVES) {1'b0}};
            for (k = 0; k < N; k = k + 1) node[2*(LEAVES+k)] = among[k];
            for (k = LEAVES - 1; k > 0; k = k - 1) begin
                node[2*k]   = node[4*k] || node[4*k+2];
                node[2*k+1] = node[4*k+1] || node[4*k+3] || (node[4*k] && node[4*k+2]);
            end
            several = node[3];
        end
    endfunction

    always @(posedge clk) begin
        by_box       <= visible & box_x & box_y;
        by_window    <= visible & window_x & window_y;
        by_candidate <= candidate & window_x & window_y;
        any_free     <= any_empty;  // the fresh ones are among them
        free         <= of_free;

        owned  <= any_window || any_candidate || any_free;  // a box lies within its window
        begins <= !any_window && !any_candidate;
        shared <= any_box ? several(by_box) : several(by_window);
        owner  <= is_op ? op_slot : any_box ? of_box : any_window ? of_window : any_candidate ? of_candidate : free;
    end

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_box (
        .asked (asked),
        .among (by_box),
        .any   (any_box),
        .lowest(of_box)
    );

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_window (
        .asked (asked),
        .among (by_window),
        .any   (any_window),
        .lowest(of_window)
    );

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_candidate (
        .asked (asked),
        .among (by_candidate),
        .any   (any_candidate),
        .lowest(of_candidate)
    );

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_free (
        .asked (1'b1),
        .among (|fresh ? fresh : empty),
        .any   (any_empty),
        .lowest(of_free)
    );

`ifndef SYNTHESIS
    // For waveforms: box and window of each slot, as they are in effect; before, as they were written last.
    reg signed [PX_W-1:0] box_lo_x [0:N-1], box_hi_x [0:N-1], box_lo_y [0:N-1], box_hi_y [0:N-1];
    reg signed [PX_W-1:0] win_lo_x [0:N-1], win_hi_x [0:N-1], win_lo_y [0:N-1], win_hi_y [0:N-1];
    reg [8*PX_W-1:0]      written [0:N-1];
    reg [SLOT_W-1:0]      written_slot;

    always @(posedge clk) begin
        if (update) written_slot <= update_slot;
        if (busy) written[written_slot] <= {box, window};
        if (place)
            {
                box_lo_x[place_slot], box_hi_x[place_slot], box_lo_y[place_slot], box_hi_y[place_slot],
                win_lo_x[place_slot], win_hi_x[place_slot], win_lo_y[place_slot], win_hi_y[place_slot]
            } <= written[place_slot];
    end

    wire unused = &{1'b0, box_lo_x[0], box_hi_x[0], box_lo_y[0], box_hi_y[0], win_lo_x[0], win_hi_x[0], win_lo_y[0], win_hi_y[0]};
`endif

endmodule

`default_nettype wire
