// SPDX-License-Identifier: Apache-2.0
// Holds tokens back while registers change, so that they change between two events: it closes, signals when filters and trackers behind
// it are idle, and opens again when the registers have been written. It also numbers the events that pass.
//
// A valid token at the output is never withdrawn: the gate closes once it has been accepted. After reset it stays closed until
// everything behind it has been idle once, since memories take some time to clear.
//
// Latency:    none, by wire.
// Throughput: a token per clock.
// Stall:      while closed, s_ready is low.
// Reset:      closed; the next event is number 0.
// Combinational paths: s_valid -> m_valid; m_ready -> s_ready; busy, idle -> apply.
`default_nettype none

module token_gate #(
    parameter SEQ_W = 48  // bits of an event's number
) (
    input  wire             clk,
    input  wire             rst,

    input  wire             enable,   // 0: stay closed
    input  wire             busy,     // registers are to be written: close
    input  wire             idle,     // nothing is under way behind the gate
    output wire             apply,    // closed and idle: they may be written
    output reg              cleared,  // it was so, once since reset
    output reg              open,
    output reg  [SEQ_W-1:0] seq,      // number of the next event

    input  wire             s_valid,
    output wire             s_ready,
    input  wire             s_counts, // the token has an event, or had one
    output wire             m_valid,
    input  wire             m_ready
);

    // Clocks from a register write until `idle` tells of its consequences.
    localparam [1:0] SETTLE = 2'd3;

    reg [1:0] settle;

    wire waits = m_valid && !m_ready;

    assign m_valid = s_valid && open;
    assign s_ready = m_ready && open;
    assign apply   = busy && !open && idle;

    always @(posedge clk) begin
        if (busy) settle <= SETTLE;
        else if (settle > 2'd1 || idle) settle <= (settle == 2'd0) ? 2'd0 : settle - 1'b1;
        if (idle) cleared <= 1'b1;
        if (!waits) open <= enable && cleared && !busy && settle == 2'd0;
        if (m_valid && m_ready && s_counts) seq <= seq + 1'b1;
        if (rst) begin
            settle  <= 2'd0;
            cleared <= 1'b0;
            open    <= 1'b0;
            seq     <= {SEQ_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
