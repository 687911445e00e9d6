// SPDX-License-Identifier: Apache-2.0
// Tokens on their way to the event pipeline: their ticks are added up, and it is seen whether they are within a burst (docs/motion.md,
// rule T4), and whether a motion step is due before them, or something takes effect.
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
    parameter TIME_W = 48,  // bits of a time
    parameter DUE_W  = 24   // bits of it that count between two times: a step is at most 2^20 ticks ahead, a token 2^TICK_W - 1
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              opens,      // low: no token is accepted, from the next clock on
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
    input  wire [DUE_W-1:0]  due_tick,
    input  wire [TIME_W-1:0] now,

    output reg               m_valid,
    input  wire              m_ready,
    output reg               m_due,      // m_valid, and a motion step comes before it
    output reg               m_runs,     // m_valid, and none does
    output reg               m_late,     // due_tick of the clock before is not behind it
    output reg               m_far,      // it is 256 ticks or more behind `now` of the clock before
    output reg  [TIME_W-1:0] m_time,
    output reg               m_event,
    output reg               m_skip,
    output reg  [X_W-1:0]    m_x,
    output reg  [Y_W-1:0]    m_y,
    output reg               m_p,
    output reg               m_burst,    // 16 events or more before it came at its tick
    output wire [X_W-1:0]    next_x,     // of the token behind it
    output wire [Y_W-1:0]    next_y,

    output wire              empty
);

    localparam TOKEN_W = TIME_W + X_W + Y_W + 4;

    reg [TOKEN_W-1:0] tokens[0:15];
    reg               in_valid, in_event, in_skip, in_p;
    reg               in_later;         // time has passed since the token before
    reg [4:0]         same_tick;        // events at the tick of the token before, at most 16
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
    wire [DUE_W-1:0]  until_step = next[X_W+Y_W+4+:DUE_W] - next_step[DUE_W-1:0];
    wire [DUE_W-1:0]  after_step = m_time[DUE_W-1:0] - next_step[DUE_W-1:0];
    wire [DUE_W-1:0]  until_due   = next[X_W+Y_W+4+:DUE_W] - due_tick;
    wire [DUE_W-1:0]  after_due   = m_time[DUE_W-1:0] - due_tick;
    wire [DUE_W-1:0]  behind_next = next[X_W+Y_W+4+:DUE_W] - now[DUE_W-1:0];
    wire [DUE_W-1:0]  behind      = m_time[DUE_W-1:0] - now[DUE_W-1:0];
    wire              before_step = holds ? after_step[DUE_W-1] : until_step[DUE_W-1];

    wire [4:0]        before_it   = in_later ? 5'd0 : same_tick;

    assign {next_x, next_y} = next[X_W+Y_W+1:2];
    assign empty = !in_valid && !in_valid_2 && !any && !next_valid && !m_valid;

    always @(posedge clk) begin
        in_valid <= s_valid && s_ready;
        if (s_valid && s_ready) begin
            in_event <= s_event;
            in_skip  <= s_skip;
            in_x     <= s_x;
            in_y     <= s_y;
            in_p     <= s_p;
            in_later <= |s_tick;
            in_time  <= in_time + {{(TIME_W - TICK_W) {1'b0}}, s_tick};
        end
        in_valid_2 <= in_valid;
        in_2       <= {in_time, in_event, in_skip, in_x, in_y, in_p, before_it[4]};
        if (in_valid) same_tick <= before_it + {4'd0, in_event && !before_it[4]};
        if (in_valid_2) begin
            tokens[written[3:0]] <= in_2;
            written              <= written + 5'd1;
        end
        s_ready <= level < 5'd12 && opens;
        if (reads) begin
            next_valid <= any;
            next       <= tokens[read[3:0]];
            read       <= read + {4'd0, any};
        end
        if (gives) begin
            m_valid <= next_valid;
            {m_time, m_event, m_skip, m_x, m_y, m_p, m_burst} <= next;
        end
        if (gives || holds) begin
            m_due  <= !before_step;
            m_runs <= before_step;
        end
        m_late <= gives ? !until_due[DUE_W-1] : !after_due[DUE_W-1];
        m_far  <= gives ? |behind_next[DUE_W-1:8] : |behind[DUE_W-1:8];
        if (holds ? !m_valid : gives && !next_valid) {m_due, m_runs} <= 2'b00;
        if (rst) begin
            in_valid   <= 1'b0;
            in_time    <= {TIME_W{1'b0}};
            same_tick  <= 5'd0;
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

    wire unused = &{1'b0, until_step, after_step, until_due, after_due, behind, behind_next, next_step, now};

endmodule

`default_nettype wire
