// SPDX-License-Identifier: Apache-2.0
// Tokens from their acceptance until what they do is certain: a ring from which they are issued, and issued again from the oldest one on.
//
// Ticks are added up at the entrance: a token in the ring has its time.
//
// Latency:    3 clocks from the acceptance of a token to its being there to be issued.
// Throughput: a token per clock.
// Stall:      s_ready is low while the ring is full. A token that is not issued stays.
// Reset:      becomes empty; time begins at 0.
// Combinational paths: index -> event_time, is_event, is_skip, x, y, p.
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

    // issue
    output wire              m_valid,
    input  wire              m_ready,
    output wire [3:0]        m_index,
    output wire [X_W-1:0]    m_x,
    output wire [Y_W-1:0]    m_y,

    // a token by its index
    input  wire [3:0]        index,
    output wire [TIME_W-1:0] event_time,
    output wire              is_event,
    output wire              is_skip,
    output wire [X_W-1:0]    x,
    output wire [Y_W-1:0]    y,
    output wire              p,

    input  wire              done,       // the oldest token leaves
    input  wire              again,      // a clock ago: the others are issued again
    output wire              empty
);

    reg [X_W+Y_W-1:0]          places[0:15];
    reg [TIME_W+X_W+Y_W+2:0]   tokens[0:15];
    reg                        in_valid, in_event, in_skip, in_p;
    reg [X_W-1:0]              in_x;
    reg [Y_W-1:0]              in_y;
    reg [TIME_W-1:0]           in_time;
    reg [3:0]                  tail, head, next;   // where the next token goes, the oldest one, the next to be issued
    reg [4:0]                  count;


    assign m_valid = next != tail;
    assign m_index = next;
    assign {m_x, m_y} = places[next];
    assign {event_time, is_event, is_skip, x, y, p} = tokens[index];
    assign empty = head == tail && !in_valid;

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
        if (in_valid) begin
            places[tail] <= {in_x, in_y};
            tokens[tail] <= {in_time, in_event, in_skip, in_x, in_y, in_p};
            tail         <= tail + 4'd1;
        end
        head    <= head + {3'd0, done};
        next    <= again ? head : m_valid && m_ready ? next + 4'd1 : next;
        count   <= count + {4'd0, in_valid} - {4'd0, done};
        s_ready <= count < 5'd12;
        if (rst) begin
            in_valid <= 1'b0;
            in_time  <= {TIME_W{1'b0}};
            tail     <= 4'd0;
            head     <= 4'd0;
            next     <= 4'd0;
            count    <= 5'd0;
            s_ready  <= 1'b0;
        end
    end

endmodule

`default_nettype wire
