// SPDX-License-Identifier: Apache-2.0
// Names the class of each tracked object from its owned events: docs/recognition.md.
//
//   owned events -> classifier_windows -> classifier_cell -> classifier_image -> classifier_evaluator -> verdicts
//                                               ^                 classifier_weights   |
//                                               +------------- fit --------------------+
//
// An owned event is taken in every clock in which s_valid is high. A write of a register waits for the windows in the queue. It
// takes effect before the event of the clock in which it is accepted. Weights can be written and read while `enable` is 0, else
// weight_ready is low. Verdicts wait in a queue. A verdict that finds the queue full is lost, and `lost` is high for a clock.
//
// Latency:    from the event that closes a window to its verdict 790 clocks; 765 more for each verdict that is due before it, and
//             179 more for each first window of a track.
// Throughput: 1 event per clock; windows as rule Q2 says.
// Stall:      verdicts are held until accepted. Owned events are never stalled.
// Reset:      registers get their defaults, windows and queues become empty. Weights stay.
// Combinational paths: none from port to port. m_ is a memory read.
`default_nettype none
`include "evcot_defs.vh"

module classifier #(
    parameter N        = 8,   // slots of the tracker
    parameter RADIX_W  = 8,   // two less than the bits of a relative address
    parameter ID_W     = 16,  // bits of a track id
    parameter SEQ_W    = 32,  // bits of an event's number
    parameter VERDICTS = 1,   // that wait for m_ready
    parameter SLOT_W   = (N > 1) ? $clog2(N) : 1,  // derived: leave it alone
    parameter ROW_W    = (N > 16) ? 11 : 10        // derived: leave it alone
) (
    input  wire               clk,
    input  wire               rst,

    // registers: enable, window_log2, scale_start, shift_1, shift_2, classes, margin_min
    input  wire               cfg_valid,
    output wire               cfg_ready,
    input  wire [2:0]         cfg_addr,
    input  wire [11:0]        cfg_data,

    // weights: four words of 18 bits to a row; read 2 clocks after the address
    input  wire               weight_valid,
    output wire               weight_ready,
    input  wire [ROW_W+1:0]   weight_address,
    input  wire [17:0]        weight_data,
    output wire [17:0]        weight_read,

    // owned events
    input  wire               s_valid,
    output wire               s_ready,    // always high
    input  wire [SLOT_W-1:0]  s_slot,
    input  wire [RADIX_W+1:0] s_dx,       // from the middle of the owner's box, half pixels, signed
    input  wire [RADIX_W+1:0] s_dy,
    input  wire               s_visible,
    input  wire [ID_W-1:0]    s_id,
    input  wire [SEQ_W-1:0]   s_seq,

    // verdicts
    output wire               m_valid,
    input  wire               m_ready,
    output wire [SLOT_W-1:0]  m_slot,
    output wire [ID_W-1:0]    m_id,
    output wire [SEQ_W-1:0]   m_seq,
    output wire [3:0]         m_class,    // 15: none of these
    output wire [14:0]        m_margin,
    output wire [7:0]         m_windows,
    output wire               lost,

    output wire               idle        // no event and no verdict is inside; windows may be open
);

    parameter_check #(.OK(N >= `EVCOT_N_SLOTS_MIN && N <= `EVCOT_N_SLOTS_MAX)) N_must_be_1_to_64 ();
    parameter_check #(.OK(RADIX_W >= `EVCOT_RADIX_W_MIN && RADIX_W <= `EVCOT_RADIX_W_MAX)) RADIX_W_must_be_1_to_12 ();
    parameter_check #(.OK(ID_W >= `EVCOT_ID_W_MIN && ID_W <= `EVCOT_ID_W_MAX)) ID_W_must_be_1_to_32 ();
    parameter_check #(.OK(SEQ_W >= `EVCOT_SEQ_W_MIN && SEQ_W <= `EVCOT_SEQ_W_MAX)) SEQ_W_must_be_8_to_48 ();
    parameter_check #(.OK(VERDICTS >= 1)) VERDICTS_must_be_at_least_1 ();
    parameter_check #(.OK(SLOT_W == ((N > 1) ? $clog2(N) : 1))) SLOT_W_must_be_left_at_its_default ();
    parameter_check #(.OK(ROW_W == ((N > 16) ? 11 : 10))) ROW_W_must_be_left_at_its_default ();

    localparam REL_W = RADIX_W + 2;

    // ---- registers ---------------------------------------------------------------------------------------------------

    wire        enable;
    wire [3:0]  window_log2, shift_1, shift_2, classes;
    wire [11:0] scale_start;
    wire [7:0]  margin_min;
    wire        restart = cfg_valid && cfg_ready;

    assign weight_ready = !enable;
    assign s_ready      = 1'b1;

    classifier_regs u_regs (
        .clk        (clk),
        .rst        (rst),
        .write      (restart),
        .address    (cfg_addr),
        .data       (cfg_data),
        .enable     (enable),
        .window_log2(window_log2),
        .scale_start(scale_start),
        .shift_1    (shift_1),
        .shift_2    (shift_2),
        .classes    (classes),
        .margin_min (margin_min)
    );

    // ---- events ------------------------------------------------------------------------------------------------------

    reg               valid_s1, visible_s1;
    reg  [SLOT_W-1:0] slot_s1;
    reg  [REL_W-1:0]  dx_s1, dy_s1;
    reg  [ID_W-1:0]   id_s1;
    reg  [SEQ_W-1:0]  seq_s1;

    always @(posedge clk) begin
        valid_s1   <= s_valid;
        visible_s1 <= s_visible;
        slot_s1    <= s_slot;
        dx_s1      <= s_dx;
        dy_s1      <= s_dy;
        id_s1      <= s_id;
        seq_s1     <= s_seq;
        if (rst) valid_s1 <= 1'b0;
    end

    wire              counts, first, young;
    wire              window_valid, window_young, window_done;
    wire [SLOT_W-1:0] window_slot;
    wire [ID_W-1:0]   window_id;
    wire [SEQ_W-1:0]  window_seq;

    classifier_windows #(
        .N    (N),
        .ID_W (ID_W),
        .SEQ_W(SEQ_W)
    ) u_windows (
        .clk        (clk),
        .rst        (rst),
        .restart    (restart),
        .enable     (enable),
        .window_log2(window_log2),
        .quiet      (cfg_ready),
        .ahead_valid(s_valid),
        .ahead_slot (s_slot),
        .s_valid    (valid_s1),
        .s_slot     (slot_s1),
        .s_visible  (visible_s1),
        .s_id       (id_s1),
        .s_seq      (seq_s1),
        .counts     (counts),
        .first      (first),
        .young      (young),
        .head_valid (window_valid),
        .head_slot  (window_slot),
        .head_young (window_young),
        .head_id    (window_id),
        .head_seq   (window_seq),
        .head_done  (window_done)
    );

    wire              skew_valid;
    wire [7:0]        skew;
    wire [71:0]       fields;  // of the slot of the event three clocks before
    wire              cell_valid, cell_first;
    wire [SLOT_W-1:0] cell_slot;
    wire [4:0]        cell_word;
    wire [2:0]        cell_lane;

    classifier_cell #(
        .N    (N),
        .REL_W(REL_W)
    ) u_cell (
        .clk        (clk),
        .rst        (rst),
        .s_valid    (counts),
        .s_slot     (slot_s1),
        .s_dx       (dx_s1),
        .s_dy       (dy_s1),
        .s_first    (first),
        .s_young    (young),
        .scale_x    (fields[11:0]),
        .scale_y    (fields[29:18]),
        .off_u      (fields[46:36]),
        .off_v      (fields[64:54]),
        .skew_valid (skew_valid),
        .skew_slot  (window_slot),
        .skew_value (skew),
        .m_valid    (cell_valid),
        .m_slot     (cell_slot),
        .m_first    (cell_first),
        .m_word     (cell_word),
        .m_lane     (cell_lane)
    );

    wire [4:0]  word;
    wire [7:0]  word_bit;
    wire [31:0] cells;
    wire [3:0]  filled;

    classifier_image #(
        .N(N)
    ) u_image (
        .clk      (clk),
        .rst      (rst),
        .s_valid  (cell_valid),
        .s_slot   (cell_slot),
        .s_first  (cell_first),
        .s_word   (cell_word),
        .s_lane   (cell_lane),
        .read_slot(window_slot),
        .read_word(word),
        .read_bit (word_bit),
        .cells    (cells),
        .filled   (filled)
    );

    // ---- evaluation --------------------------------------------------------------------------------------------------

    // Rows that the evaluation writes, classifier_evaluator.v says why, and that events read.
    localparam [ROW_W-1:0] ROW_START  = 767;
    localparam [3:0]       ROW_EVENTS = 4'd11;

    reg  [SLOT_W-1:0] slot_s2;
    reg               young_s2;
    wire [ROW_W-1:0]  slot_row = ((N > 16) ? {1'b1, {(ROW_W - 1) {1'b0}}} : {2'b11, {(ROW_W - 2) {1'b0}}})
        | {{(ROW_W - 4 - SLOT_W) {1'b0}}, slot_s2, ROW_EVENTS};
    reg  [1:0]       bank_1;
    wire [3:0]       this_bank = 4'd1 << weight_address[1:0];
    wire [ROW_W-1:0] row;
    wire [3:0]       row_write;
    wire [14:0]      row_data;
    wire [71:0]      kept;

    // While the host reads, the other banks are 0.
    assign weight_read = fields[17:0] | fields[35:18] | fields[53:36] | fields[71:54];
    wire [63:0]      weights;
    wire [7:0]       ninth;

    always @(posedge clk) begin
        {slot_s2, young_s2} <= {slot_s1, young};
        bank_1              <= weight_address[1:0];
    end

    classifier_weights #(
        .ROW_W(ROW_W)
    ) u_weights (
        .clk      (clk),
        .a_write  ((weight_valid && weight_ready) ? this_bank : 4'd0),
        .a_row    (!enable ? weight_address[ROW_W+1:2] : young_s2 ? ROW_START : slot_row),
        .a_data   (weight_data),
        .a_clears (enable ? 4'd0 : ~(4'd1 << bank_1)),
        .a_banks  (fields),
        .b_write  (row_write),
        .b_row    (row),
        .b_data   ({3'd0, row_data}),
        .b_banks  (kept),
        .b_weights(weights),
        .b_ninth  (ninth)
    );

    wire        verdict_valid, verdict_ready;
    wire [3:0]  verdict_class;
    wire [14:0] verdict_margin;
    wire [7:0]  verdict_windows;

    classifier_evaluator #(
        .N    (N),
        .ROW_W(ROW_W)
    ) u_evaluator (
        .clk        (clk),
        .rst        (rst),
        .window_log2(window_log2),
        .scale_start(scale_start),
        .shift_1    (shift_1),
        .shift_2    (shift_2),
        .classes    (classes),
        .margin_min (margin_min),
        .s_valid    (window_valid),
        .s_slot     (window_slot),
        .s_young    (window_young),
        .s_done     (window_done),
        .word       (word),
        .word_bit   (word_bit),
        .cells      (cells),
        .filled     (filled),
        .row        (row),
        .weights    (weights),
        .ninth      (ninth),
        .kept       (kept[14:0]),
        .row_write  (row_write),
        .row_data   (row_data),
        .skew_valid (skew_valid),
        .skew       (skew),
        .m_valid    (verdict_valid),
        .m_class    (verdict_class),
        .m_margin   (verdict_margin),
        .m_windows  (verdict_windows)
    );

    // ---- verdicts ----------------------------------------------------------------------------------------------------

    wire [$clog2(VERDICTS+1)-1:0] level;

    fifo #(
        .W    (SLOT_W + ID_W + SEQ_W + 27),
        .DEPTH(VERDICTS > 0 ? VERDICTS : 1)
    ) u_verdicts (
        .clk    (clk),
        .rst    (rst),
        .s_valid(verdict_valid),
        .s_ready(verdict_ready),
        .s_data ({window_slot, window_id, window_seq, verdict_class, verdict_margin, verdict_windows}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_slot, m_id, m_seq, m_class, m_margin, m_windows}),
        .level  (level)
    );

    assign lost = verdict_valid && !verdict_ready;
    assign idle = cfg_ready && !valid_s1 && !m_valid;

    wire unused = &{1'b0, level, kept[71:15], fields[17:12], fields[35:30], fields[53:47], fields[71:65]};

endmodule

`default_nettype wire
