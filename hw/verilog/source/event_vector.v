// SPDX-License-Identifier: Apache-2.0
// Unpacks a vector of events of one row and time, given as the set bits of a mask, the lowest to the left: outputs them one by one.
//
// An event without time or address (s_known low), or one that lies beyond the sensor, is dropped and counted.
//
// Latency:    4 clocks from s_ to the first event on m_.
// Throughput: 1 event per clock, including dropped ones; a vector without events takes 1 clock.
// Stall:      an event is held until accepted.
// Reset:      becomes empty, counts from 0.
// Combinational paths: none; s_ready comes from registers, m_ are registers.
`default_nettype none

module event_vector #(
    parameter L       = 32,    // bits of the mask, 1..32
    parameter T_W     = 48,    // bits of a time
    parameter X_W     = 11,    // bits of an x address
    parameter Y_W     = 11,    // bits of a y address
    parameter WIDTH   = 1280,  // pixels of the sensor
    parameter HEIGHT  = 720,
    parameter COUNT_W = 32     // bits of a counter
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               s_valid,
    output wire               s_ready,
    input  wire [T_W-1:0]     s_t,
    input  wire [11:0]        s_x,      // of bit 0
    input  wire [10:0]        s_y,
    input  wire               s_p,
    input  wire [L-1:0]       s_mask,
    input  wire               s_known,

    output wire               m_valid,
    input  wire               m_ready,
    output wire [T_W-1:0]     m_t,
    output wire [X_W-1:0]     m_x,
    output wire [Y_W-1:0]     m_y,
    output wire               m_p,

    output reg  [COUNT_W-1:0] n_events,   // taken from m_
    output reg  [COUNT_W-1:0] n_untimed,  // left out: not known
    output reg  [COUNT_W-1:0] n_outside,  // left out: beyond the sensor
    output wire               idle        // nothing inside
);

    parameter_check #(.OK(L >= 1 && L <= 32)) L_must_be_1_to_32 ();
    parameter_check #(.OK(X_W >= 1 && X_W <= 11)) X_W_must_be_1_to_11 ();
    parameter_check #(.OK(Y_W >= 1 && Y_W <= 11)) Y_W_must_be_1_to_11 ();
    parameter_check #(.OK(WIDTH >= 1 && WIDTH <= (1 << X_W))) WIDTH_must_be_1_to_2_to_the_X_W ();
    parameter_check #(.OK(HEIGHT >= 1 && HEIGHT <= (1 << Y_W))) HEIGHT_must_be_1_to_2_to_the_Y_W ();
    parameter_check #(.OK(COUNT_W >= 8 && COUNT_W <= 64)) COUNT_W_must_be_8_to_64 ();

    localparam [31:0] COLUMNS = WIDTH;
    localparam [31:0] ROWS = HEIGHT;

    wire output_ready;  // a register; whatever it lets go ahead, all stages move at once

    // ---- the vector that comes ---------------------------------------------------------------------------------------

    reg            in_valid, in_p, in_known;
    reg  [T_W-1:0] in_t;
    reg  [11:0]    in_x;
    reg  [10:0]    in_y;
    reg  [L-1:0]   in_mask;
    reg            in_several;  // of its bits are set
    wire           in_leaves;

    assign s_ready = !in_valid || in_leaves;

    always @(posedge clk) begin
        if (s_ready) begin
            in_valid <= s_valid;
            in_t     <= s_t;
            in_x     <= s_x;
            in_y     <= s_y;
            in_p     <= s_p;
            in_mask  <= s_mask;
            in_several <= several(s_mask);
            in_known <= s_known;
        end
        if (rst) in_valid <= 1'b0;
    end

    // ---- the vector under way: its lowest bit leaves at every clock --------------------------------------------------

    reg  [T_W-1:0] t;
    reg  [11:0]    left;
    reg  [4:0]     room;    // columns from `left` to the edge of the sensor
    reg            wide;    // they are more
    reg  [10:0]    y;
    reg            p, known;
    reg  [L-1:0]   lowest;  // the bit that leaves next, alone
    reg  [L-1:0]   rest;    // the others
    reg            ending;  // there are none

    assign in_leaves = in_valid && ending && output_ready;

    wire [12:0]  in_room   = COLUMNS[12:0] - {1'b0, in_x};
    wire         beyond    = in_room[12] || {21'd0, in_y} >= ROWS;
    wire [L-1:0] in_rest   = in_mask & (in_mask - 1'b1);
    wire [L-1:0] next_rest = rest & (rest - 1'b1);

    // Whether more than one bit is set: a tree, faster than to look at what a subtraction leaves.
    function several;
        input [L-1:0] bits;
        integer width, i;
        reg [31:0] any, two;
        begin
            any = 32'd0;
            two = 32'd0;
            for (i = 0; i < L; i = i + 1) any[i] = bits[i];
            for (width = 1; width < 32; width = 2 * width)
                for (i = 0; i < 32; i = i + 2 * width) begin
                    two[i] = two[i] || two[i+width] || (any[i] && any[i+width]);
                    any[i] = any[i] || any[i+width];
                end
            several = two[0];
        end
    endfunction

    reg  [4:0] index;
    always @* begin : find_index
        integer i;
        index = 5'd0;
        for (i = 0; i < L; i = i + 1) if (lowest[i]) index = index | i[4:0];
    end

    always @(posedge clk) begin
        if (output_ready) begin
            lowest <= in_leaves ? in_mask & ~in_rest : rest & ~next_rest;
            rest   <= in_leaves ? in_rest : next_rest;
            ending <= in_leaves ? !in_several : !several(rest);
        end
        if (in_leaves) begin
            t     <= in_t;
            left  <= in_x;
            room  <= beyond ? 5'd0 : in_room[4:0];
            wide  <= !beyond && |in_room[11:5];
            y     <= in_y;
            p     <= in_p;
            known <= in_known;
        end
        if (rst) begin
            lowest <= {L{1'b0}};
            rest   <= {L{1'b0}};
            ending <= 1'b1;
        end
    end

    // ---- the event: is it on the sensor? -----------------------------------------------------------------------------

    reg            event_valid, event_p, event_known, event_inside;
    reg  [T_W-1:0] event_t;
    reg  [X_W-1:0] event_x;
    reg  [Y_W-1:0] event_y;
    wire [11:0]    next_x = left + {7'd0, index};

    wire leaves = event_valid && output_ready;

    skid_buffer #(
        .W(T_W + X_W + Y_W + 1)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(event_valid && event_known && event_inside),
        .s_ready(output_ready),
        .s_data ({event_t, event_x, event_y, event_p}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_t, m_x, m_y, m_p})
    );

    assign idle = !in_valid && lowest == {L{1'b0}} && !event_valid && !m_valid;

    always @(posedge clk) begin
        if (output_ready) begin
            event_valid  <= |lowest;
            event_t      <= t;
            event_x      <= next_x[X_W-1:0];
            event_y      <= y[Y_W-1:0];
            event_p      <= p;
            event_known  <= known;
            event_inside <= wide || index < room;
        end
        if (m_valid && m_ready) n_events <= n_events + 1'b1;
        if (leaves && !event_known) n_untimed <= n_untimed + 1'b1;
        if (leaves && event_known && !event_inside) n_outside <= n_outside + 1'b1;
        if (rst) begin
            event_valid <= 1'b0;
            n_events    <= {COUNT_W{1'b0}};
            n_untimed   <= {COUNT_W{1'b0}};
            n_outside   <= {COUNT_W{1'b0}};
        end
    end

    wire unused = &{1'b0, COLUMNS, next_x, y};

endmodule

`default_nettype wire
