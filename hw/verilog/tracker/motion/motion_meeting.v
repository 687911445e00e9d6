// SPDX-License-Identifier: Apache-2.0
// Which boxes and windows of others a slot's box and window touch: docs/motion.md, rules S5, S8 and R3. All others are asked at once.
//
// Latency:    11 clocks from start to done.
// Throughput: one at a time.
// Stall:      the results stay until the next start.
// Reset:      nothing is under way.
// Combinational paths: none.
`default_nettype none

module motion_meeting #(
    parameter N      = 8,
    parameter SLOT_W = 3,
    parameter PX_W   = 13   // bits of a bound in pixels, signed
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              start,
    input  wire              begins,     // with it: of candidates all are asked, else those behind the one that was touched
    input  wire [SLOT_W-1:0] slot,
    input  wire [N-1:0]      visible,
    input  wire [N-1:0]      candidate,
    input  wire [N-1:0]      left,       // lost, but it may return
    input  wire [4*PX_W-1:0] box,        // of the slot: lo and hi on x, lo and hi on y
    input  wire [4*PX_W-1:0] window,

    // see motion_match.v
    output reg               ask,
    output reg  [4*PX_W-1:0] ask_for,
    input  wire [N-1:0]      in_box,     // two clocks later
    input  wire [N-1:0]      in_window,
    input  wire [N-1:0]      in_line,    // a column or a row is shared with the box

    output reg               done,
    output reg  [N-1:0]      nearby,     // boxes that share a column or a row: no other one can be one object with this one (rule M2)
    output reg               meets,      // a visible one's window
    output reg  [3:0]        hidden,     // sides that visible ones hide: hi and lo of y, hi and lo of x
    output reg               held,       // the middle of the box lies in a visible one's window
    output reg               touches,    // the box touches a candidate's
    output reg  [SLOT_W-1:0] touched,    // this one's, the lowest
    output reg               returns,    // the window touches one that has left
    output reg  [SLOT_W-1:0] returned    // this one's, the lowest
);

    reg  [10:0]       step;     // one of them is high
    reg  [1:0]        ask_lo_x, ask_hi_x, ask_lo_y, ask_hi_y;  // the bound that is asked for next
    reg               asks;
    reg  [N-1:0]      others, behind;
    reg               sees;     // a visible one's window
    reg  [N-1:0]      boxes;    // those of candidates; at first the windows of what has left
    wire              any_box;

    localparam [1:0] LOW    = 2'd0;
    localparam [1:0] HIGH   = 2'd1;
    localparam [1:0] MIDDLE = 2'd2;
    localparam [1:0] WINDOW = 2'd3;

    wire [SLOT_W-1:0] lowest;
    wire [PX_W-1:0]   lo_x = box[3*PX_W+:PX_W];
    wire [PX_W-1:0]   hi_x = box[2*PX_W+:PX_W];
    wire [PX_W-1:0]   lo_y = box[PX_W+:PX_W];
    wire [PX_W-1:0]   hi_y = box[0+:PX_W];
    wire [PX_W:0]     sum_x = {lo_x[PX_W-1], lo_x} + {hi_x[PX_W-1], hi_x};
    wire [PX_W:0]     sum_y = {lo_y[PX_W-1], lo_y} + {hi_y[PX_W-1], hi_y};

    function [PX_W-1:0] bound;
        input [1:0]      which;
        input [PX_W-1:0] low, high, middle, outer;
        bound = which[1] ? (which[0] ? outer : middle) : (which[0] ? high : low);
    endfunction

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_lowest (
        .asked (1'b1),
        .among (boxes),
        .any   (any_box),
        .lowest(lowest)
    );

    always @(posedge clk) begin
        step   <= {step[9:0], start};
        done   <= step[10];
        others <= ~({{(N - 1) {1'b0}}, 1'b1} << slot);

        // The window, then each side, the middle, the box: asked in step 1 is answered in step 4. A side's events are hidden where it
        // lies in the window, and the box touches it.
        ask_lo_x <= start ? WINDOW : step[1] ? HIGH : step[4] ? MIDDLE : LOW;
        ask_hi_x <= start ? WINDOW : step[0] ? LOW : step[4] ? MIDDLE : HIGH;
        ask_lo_y <= start ? WINDOW : step[3] ? HIGH : step[4] ? MIDDLE : LOW;
        ask_hi_y <= start ? WINDOW : step[2] ? LOW : step[4] ? MIDDLE : HIGH;
        asks     <= start || |step[5:0];
        ask      <= asks;
        ask_for  <= {
            bound(ask_lo_x, lo_x, hi_x, sum_x[PX_W:1], window[3*PX_W+:PX_W]),
            bound(ask_hi_x, lo_x, hi_x, sum_x[PX_W:1], window[2*PX_W+:PX_W]),
            bound(ask_lo_y, lo_y, hi_y, sum_y[PX_W:1], window[PX_W+:PX_W]),
            bound(ask_hi_y, lo_y, hi_y, sum_y[PX_W:1], window[0+:PX_W])
        };
        sees  <= |(in_window & visible & others);
        boxes <= step[3] ? in_window & left : in_box & candidate & others & behind;
        if (step[4]) begin
            meets    <= sees;
            returns  <= any_box;
            returned <= lowest;
        end
        if (step[5]) hidden[0] <= sees;
        if (step[6]) hidden[1] <= sees;
        if (step[7]) hidden[2] <= sees;
        if (step[8]) hidden[3] <= sees;
        if (step[9]) held <= sees;
        if (step[9]) nearby <= in_line;
        if (step[10]) begin
            touches <= any_box;
            touched <= lowest;
        end
        if (start) behind <= begins ? {N{1'b1}} : ~(({{(N - 1) {1'b0}}, 1'b1} << touched) | (({{(N - 1) {1'b0}}, 1'b1} << touched) - {{(N - 1) {1'b0}}, 1'b1}));
        if (rst) begin
            step <= 11'd0;
            done <= 1'b0;
            asks <= 1'b0;
            ask  <= 1'b0;
        end
    end

    wire unused = &{1'b0, sum_x[0], sum_y[0]};

endmodule

`default_nettype wire
