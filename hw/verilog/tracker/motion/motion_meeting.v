// SPDX-License-Identifier: Apache-2.0
// Which boxes and windows of others a slot's box and window touch: docs/motion.md, rules S5, S8 and R3; and which of them may be one
// object with it (rule M2). One other slot per clock, from the lowest on.
//
// Latency:    10 clocks from start to done, and one for each other slot that is not free.
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
    input  wire [2*PX_W+1:0] middle,     // of the box, half pixels, y and x
    input  wire [3:0]        join_reach,
    input  wire [7:0]        join_px,

    // the others
    output reg               asks,
    output reg  [SLOT_W-1:0] asked,
    input  wire [4*PX_W-1:0] other_box,  // two clocks later
    input  wire [4*PX_W-1:0] other_window,

    output reg               done,
    output reg  [N-1:0]      nearby,     // only with these can it be one object, whichever way they move; not with all of them
    output reg               meets,      // a visible one's window
    output reg  [3:0]        hidden,     // sides that visible ones hide: hi and lo of y, hi and lo of x
    output reg               held,       // the middle of the box lies in a visible one's window
    output reg               touches,    // the box touches a candidate's
    output reg  [SLOT_W-1:0] touched,    // this one's, the lowest
    output reg               returns,    // the window touches one that has left
    output reg  [SLOT_W-1:0] returned    // this one's, the lowest
);

    reg  [N-1:0]      ahead;               // that were not asked
    reg               starts;
    reg               busy;
    reg  [6:1]        asks_then;           // one to six clocks before
    reg  [6:0]        ends;
    reg  [SLOT_W-1:0] asked_1, asked_2, asked_3, asked_4, asked_5, asked_6;
    reg  [N-1:0]      asked_7;             // a one for this slot, if any
    reg               follows;             // behind the one that was touched
    reg  [SLOT_W-1:0] behind;
    wire [1:0]        box_on;              // y, x: the box shares a pixel with the other's box,
    reg  [1:0]        window_on;           // with its window;
    reg  [1:0]        both_on;             // the window does with its window
    reg  [1:0]        low_in, high_in, middle_in;  // an end or the middle of the box is within its window
    reg               is_visible, is_candidate, is_left;
    wire              any_ahead;
    wire [SLOT_W-1:0] lowest;
    wire [N-1:0]      one = {{(N - 1) {1'b0}}, 1'b1};

    wire [PX_W-1:0] lo_x = box[3*PX_W+:PX_W];
    wire [PX_W-1:0] hi_x = box[2*PX_W+:PX_W];
    wire [PX_W-1:0] lo_y = box[PX_W+:PX_W];
    wire [PX_W-1:0] hi_y = box[0+:PX_W];
    wire [PX_W-1:0] middle_x = middle[PX_W:1];
    wire [PX_W-1:0] middle_y = middle[2*PX_W+1:PX_W+2];

    array_lowest #(
        .N     (N),
        .SLOT_W(SLOT_W)
    ) u_lowest (
        .asked (busy),
        .among (ahead),
        .any   (any_ahead),
        .lowest(lowest)
    );

    function at_most;
        input signed [PX_W-1:0] low, high;
        at_most = !(high < low);  // smaller than low <= high
    endfunction

    // Intervals of one axis: lo and hi of each.
    function share;
        input [2*PX_W-1:0] some, others;
        share = at_most(some[PX_W+:PX_W], others[0+:PX_W]) && at_most(others[PX_W+:PX_W], some[0+:PX_W]);
    endfunction

    function lies_in;
        input [PX_W-1:0]   pixel;
        input [2*PX_W-1:0] others;
        lies_in = at_most(pixel, others[0+:PX_W]) && at_most(others[PX_W+:PX_W], pixel);
    endfunction

    // A gap on one axis: at most as wide as the wider box on the other, or half of it if join_reach is not 0, and join_px. Of both
    // differences of a high and a low bound at most one is negative: then it is the gap.
    reg               some_reach;
    reg  [PX_W-1:0]   width, height, other_width, other_height;    // hi - lo
    reg  [PX_W-1:0]   wider, higher;
    reg  [PX_W:0]     below_x, above_x, below_y, above_y;          // from a low bound to the other's high one, and from its low one
    reg  [4*PX_W+3:0] apart_4, apart_5;                            // all of these, a clock later, and two
    reg  [PX_W:0]     reach_x, reach_y;
    reg               near_x, near_y;
    reg  [1:0]        box_on_4, box_on_5, box_on_6;
    reg               nearby_7;
    wire [PX_W:0]     least = {{(PX_W - 7) {1'b0}}, join_px};
    wire [PX_W:0]     next_x, next_y, spare_x, spare_y;

    assign box_on = {!below_y[PX_W] && !above_y[PX_W], !below_x[PX_W] && !above_x[PX_W]};

    function [PX_W:0] difference;
        input [PX_W-1:0] high, low;
        difference = {high[PX_W-1], high} - {low[PX_W-1], low};
    endfunction

    array_sum #(
        .W    (PX_W + 1),
        .ROUND(0)
    ) u_reach_x (
        .a     (least),
        .choice(some_reach),
        .one   ({2'b00, higher[PX_W-1:1], 1'b0}),
        .other ({1'b0, higher, 1'b0}),
        .y     (next_x)
    );

    array_sum #(
        .W    (PX_W + 1),
        .ROUND(0)
    ) u_reach_y (
        .a     (least),
        .choice(some_reach),
        .one   ({2'b00, wider[PX_W-1:1], 1'b0}),
        .other ({1'b0, wider, 1'b0}),
        .y     (next_y)
    );

    array_sum #(
        .W    (PX_W + 1),
        .ROUND(0)
    ) u_spare_x (
        .a     (reach_x),
        .choice(apart_5[PX_W]),
        .one   ({apart_5[0+:PX_W+1], 1'b0}),
        .other ({apart_5[PX_W+1+:PX_W+1], 1'b0}),
        .y     (spare_x)
    );

    array_sum #(
        .W    (PX_W + 1),
        .ROUND(0)
    ) u_spare_y (
        .a     (reach_y),
        .choice(apart_5[3*PX_W+2]),
        .one   ({apart_5[2*PX_W+2+:PX_W+1], 1'b0}),
        .other ({apart_5[3*PX_W+3+:PX_W+1], 1'b0}),
        .y     (spare_y)
    );

    always @(posedge clk) begin
        some_reach <= join_reach != 4'd0;
        if (asks || |asks_then) begin  // otherwise a simulator can leave it out
            width        <= hi_x - lo_x;
            height       <= hi_y - lo_y;
            other_width  <= other_box[2*PX_W+:PX_W] - other_box[3*PX_W+:PX_W];
            other_height <= other_box[0+:PX_W] - other_box[PX_W+:PX_W];
            below_x      <= difference(other_box[2*PX_W+:PX_W], lo_x);
            above_x      <= difference(hi_x, other_box[3*PX_W+:PX_W]);
            below_y      <= difference(other_box[0+:PX_W], lo_y);
            above_y      <= difference(hi_y, other_box[PX_W+:PX_W]);
            wider        <= width < other_width ? other_width : width;
            higher       <= height < other_height ? other_height : height;
            apart_4      <= {above_y, below_y, above_x, below_x};
            apart_5      <= apart_4;
            reach_x      <= next_x;
            reach_y      <= next_y;
            near_x       <= box_on_5[0] || !spare_x[PX_W];
            near_y       <= box_on_5[1] || !spare_y[PX_W];
            {box_on_6, box_on_5, box_on_4} <= {box_on_5, box_on_4, box_on};
            nearby_7     <= (box_on_6[0] && near_y) || (box_on_6[1] && near_x);

            // What is compared with the other slot is there two clocks after `asked`.
            window_on    <= {share(box[0+:2*PX_W], other_window[0+:2*PX_W]), share(box[2*PX_W+:2*PX_W], other_window[2*PX_W+:2*PX_W])};
            both_on      <= {share(window[0+:2*PX_W], other_window[0+:2*PX_W]), share(window[2*PX_W+:2*PX_W], other_window[2*PX_W+:2*PX_W])};
            low_in       <= {lies_in(lo_y, other_window[0+:2*PX_W]), lies_in(lo_x, other_window[2*PX_W+:2*PX_W])};
            high_in      <= {lies_in(hi_y, other_window[0+:2*PX_W]), lies_in(hi_x, other_window[2*PX_W+:2*PX_W])};
            middle_in    <= {lies_in(middle_y, other_window[0+:2*PX_W]), lies_in(middle_x, other_window[2*PX_W+:2*PX_W])};
        end
    end

    always @(posedge clk) begin
        starts <= start;
        if (nearby_7) nearby <= nearby | asked_7;
        if (start) begin
            ahead    <= (visible | candidate | left) & ~(one << slot);
            behind   <= touched;
            follows  <= !begins;
            {meets, hidden, held, touches, returns} <= 8'd0;
            nearby   <= {N{1'b0}};
        end
        if (starts) busy <= 1'b1;
        if (busy) begin
            ahead <= ahead & (ahead - one);
            if (!any_ahead) busy <= 1'b0;
        end
        asks      <= busy && any_ahead;
        asked     <= lowest;
        asks_then <= {asks_then[5:1], asks};
        {asked_6, asked_5, asked_4, asked_3, asked_2, asked_1} <= {asked_5, asked_4, asked_3, asked_2, asked_1, asked};
        asked_7   <= asks_then[6] ? one << asked_6 : {N{1'b0}};
        {done, ends} <= {ends, busy && !any_ahead};

        is_visible   <= asks_then[2] && visible[asked_2];
        is_candidate <= asks_then[2] && candidate[asked_2] && (!follows || behind < asked_2);
        is_left      <= asks_then[2] && !visible[asked_2] && !candidate[asked_2];
        if (is_visible) begin
            meets  <= meets || &both_on;
            held   <= held || &middle_in;
            hidden <= hidden | {high_in[1] && window_on[0], low_in[1] && window_on[0], high_in[0] && window_on[1], low_in[0] && window_on[1]};
        end
        if (is_candidate && &box_on && !touches) {touches, touched} <= {1'b1, asked_3};
        if (is_left && &both_on && !returns) {returns, returned} <= {1'b1, asked_3};

        if (rst) begin
            starts    <= 1'b0;
            busy      <= 1'b0;
            asks      <= 1'b0;
            asks_then <= 6'd0;
            {done, ends} <= 8'd0;
        end
    end

    wire unused = &{1'b0, middle, spare_x, spare_y};

endmodule

`default_nettype wire
