// SPDX-License-Identifier: Apache-2.0
// The classifier as evcot_top.v has it: its registers come from a bank (EVCOT_CREG_*), its weights by address and word.
//
// `weight_address` goes on by a word with each write of weight_data_new. weight_ready is low while `enable` is 1, and after the last
// word. weight_data is the word at weight_address, from the third clock on; while `enable` is 1, 0. `loaded` counts the words that were
// written in order from word 0.
//
// Latency:    that of classifier.v.
// Throughput: 1 event per clock; a write of a register or of a word per clock, registers while `quiet`.
// Stall:      as many verdicts as slots wait until accepted. Owned events are never stalled.
// Reset:      rst: no weight is loaded. core_rst: as the reset of classifier.v; weights stay.
// Combinational paths: none from port to port. m_ is a memory read.
`default_nettype none
`include "evcot_defs.vh"
`include "evcot_regs.vh"

module classifier_bus #(
    parameter N       = 8,   // slots of the tracker
    parameter RADIX_W = 8,   // two less than the bits of a relative address
    parameter ID_W    = 32,  // bits of a track id
    parameter SEQ_W   = 48,  // bits of an event's number
    parameter SLOT_W  = (N > 1) ? $clog2(N) : 1  // derived: leave it alone
) (
    input  wire               clk,
    input  wire               rst,
    input  wire               core_rst,   // high with rst, too

    // registers, written while `quiet`
    output wire               quiet,      // no closed window is left to evaluate
    input  wire               cfg_valid,
    input  wire [`EVCOT_CREG_W-1:0] cfg_addr,
    input  wire [11:0]        cfg_data,

    // weights
    input  wire               weight_address_write,
    input  wire [11:0]        weight_address_new,
    output reg  [11:0]        weight_address,
    output wire               weight_ready,
    input  wire               weight_data_write,  // while weight_ready
    input  wire [17:0]        weight_data_new,
    output wire [17:0]        weight_data,
    output reg  [11:0]        loaded,

    // owned events
    input  wire               s_valid,
    input  wire [SLOT_W-1:0]  s_slot,
    input  wire [RADIX_W+1:0] s_dx,
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
    output wire [3:0]         m_class,
    output wire [14:0]        m_margin,
    output wire [7:0]         m_windows,
    output wire               lost,       // for a clock: a verdict

    output wire               idle        // no event and no verdict is inside
);

    localparam ROW_W = (N > 16) ? 11 : 10;

    wire                   off;  // `enable` is 0
    wire [17:0]            word;
    wire                   s_ready;
    wire [`EVCOT_CREG_W-1:0] number = cfg_addr - `EVCOT_CREG_ENABLE;
    wire [ROW_W+1:0]       address;

    generate
        if (ROW_W > 10) begin : g_wide
            assign address = {1'b0, weight_address};
        end else begin : g_narrow
            assign address = weight_address;
        end
    endgenerate

    assign weight_ready = off && weight_address != `EVCOT_WEIGHT_WORDS;
    assign weight_data  = word & {18{off}};

    always @(posedge clk) begin
        if (weight_address_write) weight_address <= weight_address_new;
        if (weight_data_write) begin
            weight_address <= weight_address + 1'b1;
            if (weight_address == loaded) loaded <= loaded + 1'b1;
        end
        if (rst) begin
            weight_address <= 12'd0;
            loaded         <= 12'd0;
        end
    end

    classifier #(
        .N       (N),
        .RADIX_W (RADIX_W),
        .ID_W    (ID_W),
        .SEQ_W   (SEQ_W),
        .VERDICTS(N)
    ) u_classifier (
        .clk           (clk),
        .rst           (core_rst),
        .cfg_valid     (cfg_valid),
        .cfg_ready     (quiet),
        .cfg_addr      (number[2:0]),
        .cfg_data      (cfg_data),
        .weight_valid  (weight_data_write),
        .weight_ready  (off),
        .weight_address(address),
        .weight_data   (weight_data_new),
        .weight_read   (word),
        .s_valid       (s_valid),
        .s_ready       (s_ready),
        .s_slot        (s_slot),
        .s_dx          (s_dx),
        .s_dy          (s_dy),
        .s_visible     (s_visible),
        .s_id          (s_id),
        .s_seq         (s_seq),
        .m_valid       (m_valid),
        .m_ready       (m_ready),
        .m_slot        (m_slot),
        .m_id          (m_id),
        .m_seq         (m_seq),
        .m_class       (m_class),
        .m_margin      (m_margin),
        .m_windows     (m_windows),
        .lost          (lost),
        .idle          (idle)
    );

    wire unused = &{1'b0, s_ready, number[`EVCOT_CREG_W-1:3]};

endmodule

`default_nettype wire
