// SPDX-License-Identifier: Apache-2.0
// AXI4-Stream beats as words of one width, the lowest lane first.
//
// A beat may hold several words, or half of one: then the first beat is the lower half, and tlast ends a word that has no
// second one. Lanes without any byte in tkeep hold no word; words of which tkeep or tlast leave out a part are skipped and
// counted. With swap_bytes the bytes of each word, or of each half of 64 bits, are in big-endian order.
//
// Latency:    2 clocks from s_axis_ to m_.
// Throughput: 1 word per clock; a beat without any word takes 1 clock.
// Stall:      a word is held until accepted; s_axis_tready is low until the last word of a beat is being accepted.
// Reset:      becomes empty. Words are not reset.
// Combinational paths: m_ready -> s_axis_tready.
`default_nettype none

module axis_words #(
    // bits of a beat: a multiple of WORD_W, or half of it
    parameter DATA_W = 32,
    // bits of a word: 16, 32 or 64
    parameter WORD_W = 32,
    // bits of the counter
    parameter COUNT_W = 32
) (
    input  wire                clk,
    input  wire                rst,

    input  wire                swap_bytes,

    input  wire                s_axis_tvalid,
    output wire                s_axis_tready,
    input  wire [DATA_W-1:0]   s_axis_tdata,
    input  wire [DATA_W/8-1:0] s_axis_tkeep,
    input  wire                s_axis_tlast,

    output reg                 m_valid,
    input  wire                m_ready,
    output reg  [WORD_W-1:0]   m_word,

    output reg  [COUNT_W-1:0]  n_cut,  // words of which a part is missing
    output wire                idle    // nothing inside
);

    parameter_check #(.OK(WORD_W == 16 || WORD_W == 32 || WORD_W == 64)) WORD_W_must_be_16_32_or_64 ();
    parameter_check #(.OK(DATA_W == 16 || DATA_W == 32 || DATA_W == 64)) DATA_W_must_be_16_32_or_64 ();
    parameter_check #(.OK(DATA_W * 2 >= WORD_W)) DATA_W_must_be_at_least_half_of_WORD_W ();
    parameter_check #(.OK(COUNT_W >= 8 && COUNT_W <= 64)) COUNT_W_must_be_8_to_64 ();

    localparam LANES  = (DATA_W > WORD_W) ? DATA_W / WORD_W : 1;
    localparam LANE_W = DATA_W / LANES;
    localparam KEEP_W = LANE_W / 8;

    wire take = s_axis_tvalid && s_axis_tready;

    // Lanes of the beat on offer that are there, and those that are there in part.
    wire [LANES-1:0] whole, partial;
    genvar i;
    generate
        for (i = 0; i < LANES; i = i + 1) begin : g_lane
            assign whole[i]   = &s_axis_tkeep[i*KEEP_W +: KEEP_W];
            assign partial[i] = |s_axis_tkeep[i*KEEP_W +: KEEP_W] && !whole[i];
        end
    endgenerate

    reg  [LANES-1:0]        waiting;   // lanes whose word has not gone out yet
    reg  [LANES*WORD_W-1:0] words;
    wire [LANES-1:0]        arriving;  // words that the beat on offer completes
    wire [LANES*WORD_W-1:0] arriving_words;
    reg  [COUNT_W-1:0]      cut;       // words that it cuts

    generate
        if (DATA_W >= WORD_W) begin : g_lanes
            assign arriving       = whole;
            assign arriving_words = s_axis_tdata;
            assign idle           = waiting == {LANES{1'b0}} && !m_valid;

            always @* begin : count_cut
                integer lane;
                cut = {COUNT_W{1'b0}};
                for (lane = 0; lane < LANES; lane = lane + 1) cut = cut + {{(COUNT_W - 1) {1'b0}}, partial[lane]};
            end

            wire unused = &{1'b0, s_axis_tlast};
        end else begin : g_halves
            reg              has_lower;
            reg [DATA_W-1:0] lower;

            assign arriving       = whole && has_lower;
            assign arriving_words = {s_axis_tdata, lower};
            assign idle           = !waiting && !m_valid && !has_lower;

            // A beat of nothing but tlast may end a word, too.
            wire ends = partial || (s_axis_tlast && whole != has_lower);
            always @* cut = {{(COUNT_W - 1) {1'b0}}, ends};

            always @(posedge clk) begin
                if (take) begin
                    has_lower <= !ends && whole != has_lower;
                    if (whole) lower <= s_axis_tdata;
                end
                if (rst) has_lower <= 1'b0;
            end
        end
    endgenerate

    wire [LANES-1:0] later = waiting & (waiting - 1'b1);
    wire             output_free = m_ready || !m_valid;
    assign s_axis_tready = later == {LANES{1'b0}} && (output_free || waiting == {LANES{1'b0}});

    // The lowest lane that waits, its bytes in order.
    localparam UNIT_BYTES = (WORD_W == 64) ? 4 : WORD_W / 8;

    reg  [WORD_W-1:0] lowest;
    wire [WORD_W-1:0] swapped;
    always @* begin : choose
        integer lane;
        lowest = {WORD_W{1'b0}};
        for (lane = LANES - 1; lane >= 0; lane = lane - 1) if (waiting[lane]) lowest = words[lane*WORD_W +: WORD_W];
    end
    generate
        for (i = 0; i < WORD_W / 8; i = i + 1) begin : g_swap
            assign swapped[i*8 +: 8] = lowest[(i - i % UNIT_BYTES + UNIT_BYTES - 1 - i % UNIT_BYTES)*8 +: 8];
        end
    endgenerate

    always @(posedge clk) begin
        if (output_free) begin
            m_valid <= |waiting;
            m_word  <= swap_bytes ? swapped : lowest;
            waiting <= later;
        end
        if (take) begin
            waiting <= arriving;
            words   <= arriving_words;
            n_cut   <= n_cut + cut;
        end
        if (rst) begin
            waiting <= {LANES{1'b0}};
            m_valid <= 1'b0;
            n_cut   <= {COUNT_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
