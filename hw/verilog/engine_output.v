// SPDX-License-Identifier: Apache-2.0
// The engine's decided events on their way out: one FIFO in the order of the events, then a register for the owned and one for
// the passed ones.
//
// Latency:    2 clocks from s_ to m_.
// Throughput: 1 event per clock.
// Stall:      an output's register holds its event until taken; the events behind it wait, those of the other output too.
//             `room` is low while fewer than eight places are free, two clocks late: no more than eight events may follow.
// Reset:      becomes empty.
// Combinational paths: none from port to port.
`default_nettype none

module engine_output #(
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

    output reg               m_own_valid,
    input  wire              m_own_ready,
    output reg  [SLOT_W-1:0] m_own_slot,
    output reg  [REL_W-1:0]  m_own_x,
    output reg  [REL_W-1:0]  m_own_y,
    output reg               m_own_p,
    output reg  [SEQ_W-1:0]  m_own_seq,

    output reg               m_pass_valid,
    input  wire              m_pass_ready,
    output reg  [X_W-1:0]    m_pass_x,
    output reg  [Y_W-1:0]    m_pass_y,
    output reg               m_pass_p,
    output reg  [SEQ_W-1:0]  m_pass_seq,

    output reg               room,
    output wire              empty
);

    // An owned event goes with its recentred address, a passed one with its own.
    localparam AT_X_W = (X_W > REL_W) ? X_W : REL_W;
    localparam AT_Y_W = (Y_W > REL_W) ? Y_W : REL_W;

    reg               owned_mem [0:15];
    reg [SLOT_W-1:0]  slot_mem  [0:15];
    reg [AT_X_W-1:0]  x_mem     [0:15];
    reg [AT_Y_W-1:0]  y_mem     [0:15];
    reg               p_mem     [0:15];
    reg [SEQ_W-1:0]   seq_mem   [0:15];

    reg [4:0] written, read;  // events, modulo twice the depth
    reg       waiting;

    wire [AT_X_W-1:0] in_x = s_owned ? {{(AT_X_W - REL_W) {1'b0}}, s_rel_x} : {{(AT_X_W - X_W) {1'b0}}, s_x};
    wire [AT_Y_W-1:0] in_y = s_owned ? {{(AT_Y_W - REL_W) {1'b0}}, s_rel_y} : {{(AT_Y_W - Y_W) {1'b0}}, s_y};
    wire [AT_X_W-1:0] x    = x_mem[read[3:0]];
    wire [AT_Y_W-1:0] y    = y_mem[read[3:0]];

    wire owned     = owned_mem[read[3:0]];
    wire gives     = waiting && (owned ? !m_own_valid || m_own_ready : !m_pass_valid || m_pass_ready);
    wire [4:0] next_written = written + {4'd0, s_valid};
    wire [4:0] next_read    = read + {4'd0, gives};
    wire [4:0] level        = written - read;

    assign empty = !waiting && !m_own_valid && !m_pass_valid;

    always @(posedge clk) begin
        if (s_valid) begin
            owned_mem[written[3:0]] <= s_owned;
            slot_mem[written[3:0]]  <= s_slot;
            x_mem[written[3:0]]     <= in_x;
            y_mem[written[3:0]]     <= in_y;
            p_mem[written[3:0]]     <= s_p;
            seq_mem[written[3:0]]   <= s_seq;
        end
        written <= next_written;
        read    <= next_read;
        waiting <= next_written != next_read;
        room    <= level <= 5'd7;

        if (m_own_ready) m_own_valid <= 1'b0;
        if (m_pass_ready) m_pass_valid <= 1'b0;
        if (gives && owned) begin
            m_own_valid <= 1'b1;
            m_own_slot  <= slot_mem[read[3:0]];
            m_own_x     <= x[REL_W-1:0];
            m_own_y     <= y[REL_W-1:0];
            m_own_p     <= p_mem[read[3:0]];
            m_own_seq   <= seq_mem[read[3:0]];
        end
        if (gives && !owned) begin
            m_pass_valid <= 1'b1;
            m_pass_x     <= x[X_W-1:0];
            m_pass_y     <= y[Y_W-1:0];
            m_pass_p     <= p_mem[read[3:0]];
            m_pass_seq   <= seq_mem[read[3:0]];
        end
        if (rst) begin
            written      <= 5'd0;
            read         <= 5'd0;
            waiting      <= 1'b0;
            room         <= 1'b0;
            m_own_valid  <= 1'b0;
            m_pass_valid <= 1'b0;
        end
    end

endmodule

`default_nettype wire
