// SPDX-License-Identifier: Apache-2.0
// Tokens on their way to the event pipeline: their ticks are added up, and it is seen whether a motion step is due before them.
//
// Latency:    5 clocks from the acceptance of a token to m_valid.
// Throughput: a token per clock.
// Stall:      a token is held until accepted; s_ready is low a clock after twelve or more are in the memory, so at most 17 are inside.
//             Of a token at the output m_due follows next_step only while it `holds`, a clock later. Nothing comes there in that time.
// Reset:      becomes empty; time begins at 0.
// Combinational paths: none.
`default_nettype none

module motion_queue #(
    parameter X_W    = 9,   // bits of an x address
    parameter Y_W    = 9,   // bits of a y address
    parameter TICK_W = 20,  // bits of the tick input
    parameter TIME_W = 48   // bits of a time
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              s_valid,
    output reg               s_ready,
    input  wire [TICK_W-1:0] s_tick,
    input  wire              s_event,
    input  wire              s_skip,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    input  wire              s_p,

    input  wire [TIME_W-1:0] next_step,
    input  wire              holds,      // a motion step is under way: next_step changes, and no token is taken

    output reg               m_valid,
    input  wire              m_ready,
    output reg               m_due,      // m_valid, and a motion step comes before it
    output reg               m_runs,     // m_valid, and none does
    output reg  [TIME_W-1:0] m_time,
    output reg               m_event,
    output reg               m_skip,
    output reg  [X_W-1:0]    m_x,
    output reg  [Y_W-1:0]    m_y,
    output reg               m_p,

    output wire              empty
);

    localparam TOKEN_W = TIME_W + X_W + Y_W + 3;

    // A step is at most 2^20 ticks after the token before, a token at most 2^TICK_W - 1: more bits do not count between them.
    localparam AHEAD_W = (TICK_W > 20 ? TICK_W : 20) + 2;
    localparam DUE_W   = AHEAD_W < TIME_W ? AHEAD_W : TIME_W;

    reg [TOKEN_W-1:0] tokens[0:15];
    reg               in_valid, in_event, in_skip, in_p;
    reg [X_W-1:0]     in_x;
    reg [Y_W-1:0]     in_y;
    reg [TIME_W-1:0]  in_time;
    reg               in_valid_2;
    reg [TOKEN_W-1:0] in_2;
    reg [4:0]         written, read;  // tokens, modulo twice the depth

    reg               next_valid;       // the token behind the one at the output
    reg [TOKEN_W-1:0] next;

    wire              gives = (!m_valid && !holds) || m_ready;
    wire              reads = gives || !next_valid;
    wire              any   = written != read;
    wire [4:0]        level = written - read;
    // Negative before a step: of the token that comes to the output, and of the one that is there.
    wire [DUE_W-1:0]  until_step = next[X_W+Y_W+3+:DUE_W] - next_step[DUE_W-1:0];
    wire [DUE_W-1:0]  after_step = m_time[DUE_W-1:0] - next_step[DUE_W-1:0];
    wire              before_step = holds ? after_step[DUE_W-1] : until_step[DUE_W-1];

    assign empty = !in_valid && !in_valid_2 && !any && !next_valid && !m_valid;

    always @(posedge clk) begin
        in_valid <= s_valid && s_ready;
        if (s_valid && s_ready) begin
            in_event <= s_event;
            in_skip  <= s_skip;
            in_x     <= s_x;
            in_y     <= s_y;
            in_p     <= s_p;
            in_time  <= in_time + {{(TIME_W - TICK_W) {1'b0}}, s_tick};
        end
        in_valid_2 <= in_valid;
        in_2       <= {in_time, in_event, in_skip, in_x, in_y, in_p};
        if (in_valid_2) begin
            tokens[written[3:0]] <= in_2;
            written              <= written + 5'd1;
        end
        s_ready <= level < 5'd12;
        if (reads) begin
            next_valid <= any;
            next       <= tokens[read[3:0]];
            read       <= read + {4'd0, any};
        end
        if (gives) begin
            m_valid <= next_valid;
            {m_time, m_event, m_skip, m_x, m_y, m_p} <= next;
        end
        if (gives || holds) begin
            m_due  <= !before_step;
            m_runs <= before_step;
        end
        if (holds ? !m_valid : gives && !next_valid) {m_due, m_runs} <= 2'b00;
        if (rst) begin
            in_valid   <= 1'b0;
            in_time    <= {TIME_W{1'b0}};
            written    <= 5'd0;
            read       <= 5'd0;
            s_ready    <= 1'b0;
            in_valid_2 <= 1'b0;
            next_valid <= 1'b0;
            m_valid    <= 1'b0;
            m_due      <= 1'b0;
            m_runs     <= 1'b0;
        end
    end

    wire unused = &{1'b0, until_step, after_step, next_step};

endmodule

`default_nettype wire
