// SPDX-License-Identifier: Apache-2.0
// The input buffer of the array: tokens are stamped with their time and kept until committed, so that they can be issued more than
// once.
//
// Latency:    3 clocks from s_ to m_ when all before is issued.
// Throughput: 1 token per clock.
// Stall:      s_ready is low while 15 tokens are not committed yet.
// Rewind:     in the clock after `rewind` nothing on m_ may be accepted; 3 clocks after it the first token that is not committed is
//             the next on m_ (one that commits in the same clock is committed).
// Reset:      becomes empty, time 0.
// Combinational paths: none from port to port; m_ is a register.
`default_nettype none

module array_input #(
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter TICK_W  = 20,  // bits of the tick input
    parameter CLOCK_W = 48   // bits of the time, at least TICK_W
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               s_valid,
    output reg                s_ready,
    input  wire [TICK_W-1:0]  s_tick,
    input  wire               s_event,
    input  wire               s_skip,
    input  wire [X_W-1:0]     s_x,
    input  wire [Y_W-1:0]     s_y,
    input  wire               s_p,

    output reg                m_valid,
    input  wire               m_take,    // issued, if it is there and no rewind was asked for a clock ago
    output wire [CLOCK_W-1:0] m_time,    // ticks since reset, with its own
    output wire               m_counts,  // takes a sequence number
    output wire               m_event,
    output wire [X_W-1:0]     m_x,
    output wire [Y_W-1:0]     m_y,
    output wire               m_p,

    input  wire               commit,
    input  wire               rewind,
    output wire               empty      // all are committed
);

    localparam TOKEN_W = X_W + Y_W + 3;

    reg [CLOCK_W-1:0] time_mem  [0:15];
    reg [TOKEN_W-1:0] token_mem [0:15];
    reg [CLOCK_W-1:0] head_time;
    reg [TOKEN_W-1:0] head;

    reg [4:0] written, issued, after_issued, committed;  // tokens, modulo twice the depth
    reg       waits, rewound;              // the token at `issued` is in the memory

    reg [CLOCK_W-1:0] now;

    wire               accept = s_valid && s_ready;
    wire               fetch  = !m_valid || m_take;
    wire [CLOCK_W-1:0] then   = now + {{(CLOCK_W - TICK_W) {1'b0}}, s_tick};
    wire [4:0] level          = written - committed;

    // The three tokens that may be next: is it there?
    wire waits_again = committed != written;
    wire waits_still = issued != written;
    wire waits_after = after_issued != written;

    assign m_time = head_time;
    assign {m_counts, m_event, m_x, m_y, m_p} = head;
    assign empty = written == committed;

    always @(posedge clk) begin
        if (accept) begin
            time_mem[written[3:0]]  <= then;
            token_mem[written[3:0]] <= {s_event || s_skip, s_event, s_x, s_y, s_p};
            now                     <= then;
            written                 <= written + 5'd1;
        end
        if (commit) committed <= committed + 5'd1;
        s_ready   <= !level[4] && level[3:0] != 4'd15;  // one more may come before this is seen

        if (fetch) begin
            head_time <= time_mem[issued[3:0]];
            head      <= token_mem[issued[3:0]];
            m_valid   <= waits;
        end
        if (rewound) begin
            issued       <= committed;
            after_issued <= committed + 5'd1;
            waits        <= waits_again;
        end else if (fetch && waits) begin
            issued       <= after_issued;
            after_issued <= after_issued + 5'd1;
            waits        <= waits_after;
        end else waits <= waits_still;
        rewound <= rewind;
        if (rewound) m_valid <= 1'b0;

        if (rst) begin
            written   <= 5'd0;
            issued    <= 5'd0;
            after_issued <= 5'd1;
            committed <= 5'd0;
            s_ready   <= 1'b0;
            waits     <= 1'b0;
            m_valid   <= 1'b0;
            rewound   <= 1'b0;
            now       <= {CLOCK_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
