// SPDX-License-Identifier: Apache-2.0
/*
cut = ["t:*motion_mask*"]

[properties]
owner = "the owner is the lowest slot of the first line of rule O1 that has one, the slot of an operation, or none if no line has a slot"
begins = "a candidate begins exactly where line 4 or 5 decides"
shared = "an event is shared exactly if line 1 or 2 decides and has more than one slot"
plane = "a slot's plane changes when it is placed, and at no other time"

[[tasks]]
name = "16"
parameters = { N = 16, SLOT_W = 4 }
k = 2
covers_within = 8
quick = true

[[tasks]]
name = "8"
k = 2
covers_within = 8
only = []

[[tasks]]
name = "1"
parameters = { N = 1, SLOT_W = 1 }
k = 2
covers_within = 8
only = []

[[tasks]]
name = "64"
parameters = { N = 64, SLOT_W = 6, X_W = 16, Y_W = 16, PX_W = 20 }
k = 2
covers_within = 8
only = []

[[faults]]
file = "array_lowest.v"
meaning = "of two halves the upper one wins"
right = "place[i*SLOT_W+:SLOT_W] = has[2*i] ?"
wrong = "place[i*SLOT_W+:SLOT_W] = !has[2*i+1] ?"
breaks = ["owner"]
within = 8

[[faults]]
meaning = "a window counts before a box"
right = "any_box ? of_box : any_window ? of_window"
wrong = "any_window ? of_window : any_box ? of_box"
breaks = ["owner"]
within = 8

[[faults]]
meaning = "a candidate begins in a slot whose track may return, although another one is free"
right = "(|fresh ? fresh : empty)"
wrong = "(empty)"
breaks = ["owner"]
within = 8

[[faults]]
meaning = "a candidate begins where a candidate owns the event"
right = "begins <= !any_window && !any_candidate;"
wrong = "begins <= !any_window;"
breaks = ["begins"]
within = 8

[[faults]]
meaning = "two slots of the lower half are not several"
right = "node[2*k+1] = node[4*k+1] || node[4*k+3] ||"
wrong = "node[2*k+1] = node[4*k+3] ||"
breaks = ["shared"]
within = 8

[[faults]]
meaning = "windows of several slots share an event that lies in one box"
right = "shared <= any_box ? several(by_box) : several(by_window);"
wrong = "shared <= several(by_window);"
breaks = ["shared"]
within = 8

[[faults]]
meaning = "another slot is placed as well"
right = "plane ^ (one << place_slot)"
wrong = "plane ^ (one << place_slot) ^ (one << (place_slot + 1))"
breaks = ["plane"]
within = 8
*/
// What the masks say may be anything but that a box lies within its window. The rule is written again, slot by slot.
(* anyconst *) wire [SLOT_W-1:0] f_slot;

always @* assume ((box_x & ~window_x) == {N{1'b0}} && (box_y & ~window_y) == {N{1'b0}});
always @* assume ((fresh & ~empty) == {N{1'b0}} && ((visible | candidate) & empty) == {N{1'b0}} && (visible & candidate) == {N{1'b0}});
always @* assume ({1'b0, f_slot} < N && (!place || {1'b0, place_slot} < N));

reg [N-1:0]      f_box, f_window, f_candidate, f_fresh, f_empty;  // which slots each line has, two clocks before the owner
reg              f_line_1, f_line_2, f_line_3, f_line_4, f_line_5;  // the line that decides
reg [SLOT_W-1:0] f_owner, f_op_slot;
reg              f_shared, f_asked, f_op, f_known, f_known_1;
reg              f_plane;
wire [N-1:0]     f_line = f_box != 0 ? f_box : f_window != 0 ? f_window : f_candidate != 0 ? f_candidate : f_fresh != 0 ? f_fresh : f_empty;

integer f_k, f_count;
reg [SLOT_W-1:0] f_lowest;
always @* begin
    f_lowest = {SLOT_W{1'b0}};
    f_count  = 0;
    for (f_k = N - 1; f_k >= 0; f_k = f_k - 1)
        if (f_line[f_k]) begin
            f_lowest = f_k;
            f_count  = f_count + 1;
        end
end

always @(posedge clk) begin
    f_known     <= !rst;
    f_known_1   <= f_known && !rst;
    f_box       <= visible & box_x & box_y;
    f_window    <= visible & window_x & window_y;
    f_candidate <= candidate & window_x & window_y;
    f_fresh     <= fresh;
    f_empty     <= empty;
    f_line_1    <= f_box != 0;
    f_line_2    <= f_box == 0 && f_window != 0;
    f_line_3    <= f_box == 0 && f_window == 0 && f_candidate != 0;
    f_line_4    <= f_box == 0 && f_window == 0 && f_candidate == 0 && f_fresh != 0;
    f_line_5    <= f_box == 0 && f_window == 0 && f_candidate == 0 && f_fresh == 0 && f_empty != 0;
    f_owner     <= f_lowest;
    f_shared    <= f_count > 1;
    f_asked     <= asked;
    f_op        <= is_op;
    f_op_slot   <= op_slot;
    f_plane     <= !rst && (f_plane ^ (place && place_slot == f_slot));
end

wire f_any = f_line_1 || f_line_2 || f_line_3 || f_line_4 || f_line_5;

always @* if (f_past) begin
    p_owner:  assert (!f_known_1 || (owned == f_any && (!f_op || owner == f_op_slot)
                      && (f_op || !f_any || !(f_asked || f_line_4 || f_line_5) || owner == f_owner)));
    p_begins: assert (!f_known_1 || !owned || begins == (f_line_4 || f_line_5));
    p_shared: assert (!f_known_1 || !(f_line_1 || f_line_2) || shared == f_shared);
    p_plane:  assert (plane[f_slot] == f_plane);
    i_lines:  assert (!f_known || (by_box == f_box && by_window == f_window && by_candidate == f_candidate));
    i_free:   assert (!f_known || (any_free == (f_empty != 0) && ((f_box | f_window | f_candidate) != 0 || f_empty == 0 || free == f_lowest)));
    c_owner:  cover (f_known_1 && f_line_2 && f_asked && owner == 3 && N > 1);
    c_begins: cover (f_known_1 && f_line_5 && f_owner == N - 1);
    c_shared: cover (f_known_1 && f_line_1 && shared && f_owner == 1);
    c_plane:  cover (plane[f_slot] && f_slot == N - 1);
end
