// SPDX-License-Identifier: Apache-2.0
// The output buffer of the array for decided events: one FIFO in the order of the events, and behind it one register, shared by the
// outputs for owned and passed events.
//
// Latency:    3 clocks from s_ to m_.
// Throughput: 1 event per clock.
// Stall:      an event is held until accepted; those behind it wait, including those of the other output.
//             `room` is low while fewer than eight entries are free, delayed by a clock: at most eight events may follow.
// Reset:      becomes empty.
// Combinational paths: none from port to port.
`default_nettype none

module array_output #(
    parameter X_W    = 9,   // bits of an x address
    parameter Y_W    = 9,   // bits of a y address
    parameter REL_W  = 10,  // bits of a recentred address
    parameter SEQ_W  = 48,  // bits of an event's sequence number
    parameter SLOT_W = 3    // bits of a slot number
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              s_valid,
    input  wire              s_owned,
    input  wire [SLOT_W-1:0] s_slot,
    input  wire [REL_W-1:0]  s_rel_x,
    input  wire [REL_W-1:0]  s_rel_y,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    input  wire              s_p,
    input  wire [SEQ_W-1:0]  s_seq,

    output wire              m_own_valid,
    input  wire              m_own_ready,
    output wire [SLOT_W-1:0] m_own_slot,
    output wire [REL_W-1:0]  m_own_x,
    output wire [REL_W-1:0]  m_own_y,
    output wire              m_own_p,
    output wire [SEQ_W-1:0]  m_own_seq,

    output wire              m_pass_valid,
    input  wire              m_pass_ready,
    output wire [X_W-1:0]    m_pass_x,
    output wire [Y_W-1:0]    m_pass_y,
    output wire              m_pass_p,
    output wire [SEQ_W-1:0]  m_pass_seq,

    output wire              room,
    output wire              empty
);

    // An owned event goes with its recentred address, a passed one with its own.
    localparam AT_X_W  = (X_W > REL_W) ? X_W : REL_W;
    localparam AT_Y_W  = (Y_W > REL_W) ? Y_W : REL_W;
    localparam EVENT_W = SLOT_W + AT_X_W + AT_Y_W + 1;

    reg [EVENT_W+1:0] event_mem [0:15];
    reg [SEQ_W-1:0]   seq_mem   [0:15];
    reg [EVENT_W-1:0] head;
    reg [SEQ_W-1:0]   head_seq;
    reg               own, pass;  // head is valid, and whose

    reg [4:0] written, read, after_read;  // events, modulo twice the depth
    reg       waiting;

    wire [AT_X_W-1:0] in_x = s_owned ? {{(AT_X_W - REL_W) {1'b0}}, s_rel_x} : {{(AT_X_W - X_W) {1'b0}}, s_x};
    wire [AT_Y_W-1:0] in_y = s_owned ? {{(AT_Y_W - REL_W) {1'b0}}, s_rel_y} : {{(AT_Y_W - Y_W) {1'b0}}, s_y};
    wire [AT_X_W-1:0] x;
    wire [AT_Y_W-1:0] y;

    wire       held       = (own && !m_own_ready) || (pass && !m_pass_ready);
    wire       gives      = waiting && !held;
    wire [4:0] level      = written - read;

    assign {m_own_slot, x, y, m_own_p} = head;
    assign m_own_seq    = head_seq;
    assign m_own_valid  = own;
    assign m_own_x      = x[REL_W-1:0];
    assign m_own_y      = y[REL_W-1:0];
    assign m_pass_valid = pass;
    assign m_pass_x     = x[X_W-1:0];
    assign m_pass_y     = y[Y_W-1:0];
    assign m_pass_p     = m_own_p;
    assign m_pass_seq   = m_own_seq;

    assign room  = level <= 5'd7;
    assign empty = written == read && !own && !pass;

    always @(posedge clk) begin
        if (s_valid) begin
            event_mem[written[3:0]] <= {s_owned, !s_owned, s_slot, in_x, in_y, s_p};
            seq_mem[written[3:0]]   <= s_seq;
            written                 <= written + 5'd1;
        end
        if (!held) begin
            {own, pass, head} <= event_mem[read[3:0]];
            head_seq          <= seq_mem[read[3:0]];
            if (!waiting) {own, pass} <= 2'b00;
        end
        if (gives) begin
            read       <= after_read;
            after_read <= after_read + 5'd1;
        end
        waiting <= gives ? after_read != written : read != written;

        if (rst) begin
            written <= 5'd0;
            read    <= 5'd0;
            after_read <= 5'd1;
            waiting <= 1'b0;
            own     <= 1'b0;
            pass    <= 1'b0;
        end
    end

endmodule

`default_nettype wire
