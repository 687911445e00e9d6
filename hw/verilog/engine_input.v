// SPDX-License-Identifier: Apache-2.0
// The engine's tokens on their way in: numbered, stamped with their time, and kept until committed, so that they can be issued
// more than once.
//
// Latency:    1 clock from s_ to m_ when all before is issued.
// Throughput: 1 token per clock.
// Stall:      s_ready is low while DEPTH tokens are not committed yet.
// Rewind:     the token after the committed ones is the next on m_, the one that commits in the same clock included in them, after a clock
//             without one.
// Reset:      becomes empty, time and sequence number 0.
// Combinational paths: none from port to port; m_ is a memory read.
`default_nettype none

module engine_input #(
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter TICK_W  = 20,  // bits of the tick input
    parameter SEQ_W   = 48,  // bits of an event's sequence number
    parameter CLOCK_W = 48   // bits of the time, at least TICK_W
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               s_valid,
    output wire               s_ready,
    input  wire [TICK_W-1:0]  s_tick,
    input  wire               s_event,
    input  wire               s_skip,
    input  wire [X_W-1:0]     s_x,
    input  wire [Y_W-1:0]     s_y,
    input  wire               s_p,

    output wire               m_valid,
    input  wire               m_take,    // issued
    output wire [CLOCK_W-1:0] m_time,    // ticks since reset, with its own
    output wire [SEQ_W-1:0]   m_seq,     // of the next event: its own, if it has one; there without a token, too
    output wire               m_event,
    output wire [X_W-1:0]     m_x,
    output wire [Y_W-1:0]     m_y,
    output wire               m_p,

    input  wire               commit,
    input  wire               rewind,
    output wire               empty      // all are committed
);

    localparam [4:0] DEPTH = 5'd16;

    reg [CLOCK_W-1:0] time_mem   [0:15];
    reg [SEQ_W-1:0]   seq_mem    [0:15];
    reg               event_mem  [0:15];
    reg [X_W-1:0]     x_mem      [0:15];
    reg [Y_W-1:0]     y_mem      [0:15];
    reg               p_mem      [0:15];

    reg [4:0] written, issued, committed;  // tokens, modulo twice the depth
    reg       ready_reg, valid_reg;

    reg [CLOCK_W-1:0] now;
    reg [SEQ_W-1:0]   seq;

    wire               accept = s_valid && ready_reg;
    wire [CLOCK_W-1:0] then   = now + {{(CLOCK_W - TICK_W) {1'b0}}, s_tick};
    wire [4:0] next_written   = written + {4'd0, accept};
    wire [4:0] next_committed = committed + {4'd0, commit};
    wire [4:0] after_issued   = issued + 5'd1;

    assign s_ready  = ready_reg;
    assign m_valid  = valid_reg;
    assign m_time   = time_mem[issued[3:0]];
    assign m_seq    = seq_mem[issued[3:0]];
    assign m_event  = event_mem[issued[3:0]];
    assign m_x      = x_mem[issued[3:0]];
    assign m_y      = y_mem[issued[3:0]];
    assign m_p      = p_mem[issued[3:0]];
    assign empty    = written == committed;

    always @(posedge clk) begin
        if (ready_reg) seq_mem[written[3:0]] <= seq;
        if (accept) begin
            time_mem[written[3:0]]   <= then;
            event_mem[written[3:0]]  <= s_event;
            x_mem[written[3:0]]      <= s_x;
            y_mem[written[3:0]]      <= s_y;
            p_mem[written[3:0]]      <= s_p;
            now                 <= then;
            if (s_event || s_skip) seq <= seq + 1'b1;
        end
        written   <= next_written;
        issued    <= rewind ? next_committed : m_take ? after_issued : issued;
        committed <= next_committed;
        ready_reg <= next_written != next_committed + DEPTH;
        valid_reg <= !rewind && (m_take ? after_issued : issued) != next_written;
        if (rst) begin
            written   <= 5'd0;
            issued    <= 5'd0;
            committed <= 5'd0;
            ready_reg <= 1'b0;
            valid_reg <= 1'b0;
            now       <= {CLOCK_W{1'b0}};
            seq       <= {SEQ_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
