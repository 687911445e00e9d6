// SPDX-License-Identifier: Apache-2.0
// Events from AXI4-Stream, one per beat of 64 bits: EVCOT_EVENT_* in evcot_regs.vh, docs/registers.md.
//
// The beat has the low 32 bits of the time. If they decrease by half their range or more they have wrapped, and m_t continues, up to
// T_W bits; a smaller decrease is a time that runs backwards, and is passed on unchanged. A beat whose tkeep is not all
// ones, or whose pixel lies beyond WIDTH x HEIGHT, is skipped and counted. tlast is ignored.
//
// Latency:    2 clocks.
// Stall:      an event is held until accepted.
// Reset:      empty, counter 0, time starts at the first event's 32 bits.
// Combinational paths: m_ready -> s_axis_tready.
// Throughput: an event per clock.
`default_nettype none
`include "evcot_regs.vh"

module axis_events_in #(
    parameter T_W    = 48,   // bits of a time, at least 32
    parameter X_W    = 9,    // bits of an x address
    parameter Y_W    = 9,    // bits of a y address
    parameter WIDTH  = 346,  // pixels of the sensor across
    parameter HEIGHT = 260   // pixels of the sensor down
) (
    input  wire           clk,
    input  wire           rst,

    input  wire           s_axis_tvalid,
    output wire           s_axis_tready,
    input  wire [63:0]    s_axis_tdata,
    input  wire [7:0]     s_axis_tkeep,
    input  wire           s_axis_tlast,

    output reg            m_valid,
    input  wire           m_ready,
    output reg  [T_W-1:0] m_t,
    output reg  [X_W-1:0] m_x,
    output reg  [Y_W-1:0] m_y,
    output reg            m_p,

    output reg  [31:0]    n_skipped,
    output wire           idle       // no event inside
);

    parameter_check #(.OK(T_W >= 33)) T_W_must_be_at_least_33 ();
    parameter_check #(.OK(WIDTH >= 1 && WIDTH <= (1 << X_W))) WIDTH_must_be_1_to_2_to_the_X_W ();
    parameter_check #(.OK(HEIGHT >= 1 && HEIGHT <= (1 << Y_W))) HEIGHT_must_be_1_to_2_to_the_Y_W ();

    localparam HIGH_W = T_W - 32;
    localparam [31:0] COLUMNS = WIDTH;
    localparam [31:0] ROWS    = HEIGHT;

    wire        ready;
    wire        whole = &s_axis_tkeep;
    wire [63:0] word  = s_axis_tdata;

    // ---- is it an event? ---------------------------------------------------------------------------------------------

    wire [16:0] x = {{(17 - `EVCOT_EVENT_X_W) {1'b0}}, word[`EVCOT_EVENT_X_LSB +: `EVCOT_EVENT_X_W]};
    wire [16:0] y = {{(17 - `EVCOT_EVENT_Y_W) {1'b0}}, word[`EVCOT_EVENT_Y_LSB +: `EVCOT_EVENT_Y_W]};

    reg           seen, sound, seen_p;
    reg [31:0]    t;
    reg [X_W-1:0] seen_x;
    reg [Y_W-1:0] seen_y;

    assign ready         = m_ready || !m_valid;
    assign s_axis_tready = ready;

    always @(posedge clk) begin
        if (ready) begin
            seen   <= s_axis_tvalid;
            sound  <= whole && x < COLUMNS[16:0] && y < ROWS[16:0];
            t      <= word[`EVCOT_EVENT_T_LSB +: `EVCOT_EVENT_T_W];
            seen_x <= x[X_W-1:0];
            seen_y <= y[Y_W-1:0];
            seen_p <= word[`EVCOT_EVENT_P_LSB];
        end
        if (rst) seen <= 1'b0;
    end

    // ---- its whole time ----------------------------------------------------------------------------------------------

    reg  [31:0]       last;
    reg  [HIGH_W-1:0] turn, turn_next;  // a turn begins in every second clock at most
    wire              wrapped = last[31] && !t[31] && !(last[30:0] < t[30:0]);

    assign idle = !seen && !m_valid;

    always @(posedge clk) begin
        turn_next <= turn + 1'b1;
        if (m_ready) m_valid <= 1'b0;
        if (seen && ready) begin
            if (sound) begin
                m_valid <= 1'b1;
                last    <= t;
                if (wrapped) turn <= turn_next;
                m_t     <= {wrapped ? turn_next : turn, t};
                m_x     <= seen_x;
                m_y     <= seen_y;
                m_p     <= seen_p;
            end else n_skipped <= n_skipped + 1'b1;
        end
        if (rst) begin
            m_valid   <= 1'b0;
            last      <= 32'd0;
            turn      <= {HIGH_W{1'b0}};
            n_skipped <= 32'd0;
        end
    end

    wire unused = &{1'b0, s_axis_tlast, word, x, y};

endmodule

`default_nettype wire
