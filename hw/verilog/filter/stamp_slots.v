// SPDX-License-Identifier: Apache-2.0
// The slots of a memory of time stamps on their way: each carries a token, or a visit of the walk (stamp_walk.v), through seven
// stages, so that stamp_bank.v can read at the second and write at the last one, in order.
//
// Stage 0 `ask`, 1 `read`: the RAM reads, 2 `found`, 3 `held`: its output registers, 4 `taken`, 5 `then`: what was read, corrected,
// 6 `age`: what is written, is written now.
// Stage s of a vector with one field per stage is [s*W +: W]. A visit never has to be repeated: what it has read is corrected like
// that of a token, and it writes in its turn.
//
// Latency:    8 clocks from s_ to stage 6, the first of them in front of stage 0.
// Throughput: 1 token per clock; for stalls by the walk, which are rare, see stamp_walk.v.
// Stall:      while advance is low all slots stand still.
// Reset:      becomes empty, then a first walk, during which `clearing` is high: ROWS + 8 clocks with idle and s_ready low.
// Combinational paths: advance -> s_ready.
`default_nettype none

module stamp_slots #(
    parameter STAMP_W   = 20,  // bits of a stamp
    parameter SEGMENT_W = 18,  // log2 of the steps between two visits: see stamp_walk.v
    parameter STEP_W    = 20,  // bits of a token's steps
    parameter ROWS      = 16,  // rows of cells
    parameter ROW_W     = 4,   // bits of a row's number
    parameter DATA_W    = 1    // bits that travel with a token
) (
    input  wire                 clk,
    input  wire                 rst,
    input  wire                 advance,

    // tokens: s_step steps have passed, then an event that needs row s_row of the memory, if s_access
    input  wire                 s_valid,
    output wire                 s_ready,
    input  wire [STEP_W-1:0]    s_step,
    input  wire                 s_access,
    input  wire [ROW_W-1:0]     s_row,
    input  wire [DATA_W-1:0]    s_data,

    // by stage
    output reg  [6:0]           access,    // a token whose event needs the memory
    output reg  [6:0]           visits,
    output wire [7*ROW_W-1:0]   row,       // of the event, or of the visit
    output reg  [7*STAMP_W-1:0] now,
    output wire [7*DATA_W-1:0]  data,      // of the token

    output wire                 m_valid,   // a token is in stage 6
    output wire                 clearing,  // visits are to empty their rows
    output wire                 idle       // nothing inside, first walk done
);

    reg  [6:0]         valid;  // a token
    reg  [ROW_W-1:0]   token_row;
    reg  [DATA_W-1:0]  token;
    wire               enters, accesses, goes_round, waits;
    wire [ROW_W-1:0]   walk_row;
    wire [STAMP_W-1:0] time_now;

    stamp_walk #(
        .W        (STAMP_W),
        .SEGMENT_W(SEGMENT_W),
        .STEP_W   (STEP_W),
        .ROWS     (ROWS),
        .ROW_W    (ROW_W)
    ) u_walk (
        .clk        (clk),
        .rst        (rst),
        .advance    (advance),
        .s_valid    (s_valid),
        .s_ready    (s_ready),
        .s_step     (s_step),
        .s_access   (s_access),
        .enters     (enters),
        .access     (accesses),
        .visits     (goes_round),
        .row        (walk_row),
        .now        (time_now),
        .visited    (visits[6]),
        .missed     (1'b0),
        .visited_row(row[6*ROW_W +: ROW_W]),
        .clearing   (clearing),
        .waits      (waits)
    );

    always @(posedge clk) begin
        if (s_ready) begin
            token     <= s_data;
            token_row <= s_row;
        end
        if (advance) begin
            valid  <= {valid[5:0], enters};
            access <= {access[5:0], accesses};
            visits <= {visits[5:0], goes_round};
            now    <= {now[6*STAMP_W-1:0], time_now};
        end
        if (rst) begin
            valid  <= 7'd0;
            access <= 7'd0;
            visits <= 7'd0;
        end
    end

    // A register for each stage: a simulator moves those faster than one wide vector.
    wire [ROW_W-1:0] ask_row = goes_round ? walk_row : token_row;

    genvar s;
    generate
        for (s = 0; s < 7; s = s + 1) begin : g_stage
            reg [ROW_W-1:0]  row_reg;
            reg [DATA_W-1:0] data_reg;

            if (s == 0) begin : g_ask
                always @(posedge clk)
                    if (advance) begin
                        row_reg  <= ask_row;
                        data_reg <= token;
                    end
            end else begin : g_later
                always @(posedge clk)
                    if (advance) begin
                        row_reg  <= g_stage[s-1].row_reg;
                        data_reg <= g_stage[s-1].data_reg;
                    end
            end

            assign row[s*ROW_W +: ROW_W]    = row_reg;
            assign data[s*DATA_W +: DATA_W] = data_reg;
        end
    endgenerate

    assign m_valid = valid[6];
    assign idle    = !clearing && !waits && valid == 7'd0;

endmodule

`default_nettype wire
