// SPDX-License-Identifier: Apache-2.0
// Times of all slots, in block RAM, and what follows from those of the slot that is worked on: docs/motion.md, rules C4, C7 and M3.
//
// Three times of each slot: of its last correction, of its seed and of its last record. One is read, or written, at once. The deadline
// is in a memory of its own, by its lower bits, and compared with sign.
//
// Latency:    4 clocks from `at`, `since` or `now` to age, 5 to the rest; 3 clocks from `at` or `counted` to `ended`, and to `later` from
//             `at`; 6 and life_log2 from `grants` to the deadline; `enough` and `overdue` are there when `dividing` falls.
// Throughput: an age per clock.
// Stall:      none.
// Reset:      nothing is under way. Times are not reset.
// Combinational paths: none.
`default_nettype none

module motion_times #(
    parameter SLOT_W = 3,
    parameter TIME_W = 48,
    parameter UNTIL_W = 32  // bits of a deadline, of which less than half a lap counts
) (
    input  wire              clk,
    input  wire              rst,

    input  wire [SLOT_W-1:0] at,
    input  wire [1:0]        since,      // which of its times: 0 last correction, 1 seed, 2 last record
    input  wire              keep_now,   // that time is written
    input  wire              keep_until, // the deadline is
    input  wire [TIME_W-1:0] now,
    input  wire [UNTIL_W-1:0] counted,   // now, without the empty periods that do not count for deadlines
    output reg  [TIME_W-1:0] age,        // of that time
    output wire              ended,      // the deadline is not in the future
    output reg  [23:0]       ticks,      // age, at least 1; if that has more than 24 bits, 2^24 - 1 a clock later
    output reg               beyond,     // it has
    output reg               instant,    // ticks are 1, a clock later
    output reg               silent,     // for more than twice the usual time

    // the usual time between corrections, and the deadline that follows
    input  wire              load,       // takes loaded
    input  wire [23:0]       loaded,
    input  wire              seed,       // the deadline is in detect_ticks
    input  wire              leave,      // the deadline is in return_ticks
    input  wire              correct,    // takes ticks, or a quarter of what they are more; if they are 1 only at first
    input  wire              first,      // from the clock before
    output reg  [23:0]       usual,
    input  wire [23:0]       detect_ticks,
    input  wire [3:0]        life_log2,
    input  wire [23:0]       life_ticks,
    input  wire [23:0]       coast_ticks,
    input  wire [23:0]       return_ticks,
    input  wire              hold,       // the deadline is the one that was read
    output reg               later,      // and it is not before that which is read now

    // an age that stays, and is counted in steps
    input  wire              take,
    input  wire              divide,     // by 2^down
    input  wire [5:0]        down,
    output reg               dividing,
    output reg               older,      // it is more than the present one
    input  wire [15:0]       together,   // steps that two slots have moved together
    input  wire [9:0]        join_steps,
    output reg               enough,     // these are as many, and the age is not more
    input  wire [9:0]        report_steps,
    output reg               overdue     // the age is so many steps
);

    localparam PLACE_W = SLOT_W > 4 ? SLOT_W + 2 : 7;  // more than 64 words, for block RAM on every device
    localparam ADDR_W  = SLOT_W > 7 ? SLOT_W : 7;

    wire [PLACE_W-1:0] place = {{(PLACE_W - SLOT_W) {1'b0}}, at} | ({{(PLACE_W - 2) {1'b0}}, since} << SLOT_W);
    wire [TIME_W-1:0] then;
    reg  [TIME_W-1:0] other;
    reg  [UNTIL_W-1:0] deadline;
    wire [UNTIL_W-1:0] its_deadline, next_deadline;
    reg               many;  // other has more than 16 bits
    reg  [5:0]        left;
    reg               grants, grows, limits, chooses, adds, divides;
    reg               over, shorter, longer;  // 24 bits; less than life_ticks; more than coast_ticks
    reg  [3:0]        grow_left;
    reg  [23:0]       grant, granted;
    wire             doubles = grows && grow_left != 4'd0;
    wire             halves  = divides && left != 6'd0;
    wire [TIME_W:0] ahead = {age[TIME_W-1], age} - {other[TIME_W-1], other};
    reg  [24:0]       slower_by;
    wire [23:0]       next_usual;

    wire [UNTIL_W-1:0] late  = counted - its_deadline;
    wire [UNTIL_W-1:0] spare = deadline - its_deadline;
    reg                future;

    assign ended = !future;

    block_memory #(
        .W    (TIME_W),
        .DEPTH(1 << PLACE_W)
    ) u_times (
        .clk          (clk),
        .write        (keep_now),
        .write_address(place),
        .write_data   (now),
        .read_enable  (1'b1),
        .read_address (place),
        .out_enable   (1'b1),
        .read_data    (then)
    );

    block_memory #(
        .W    (UNTIL_W),
        .DEPTH(1 << ADDR_W)
    ) u_deadlines (
        .clk          (clk),
        .write        (keep_until),
        .write_address({{(ADDR_W - SLOT_W) {1'b0}}, at}),
        .write_data   (deadline),
        .read_enable  (1'b1),
        .read_address ({{(ADDR_W - SLOT_W) {1'b0}}, at}),
        .out_enable   (1'b1),
        .read_data    (its_deadline)
    );

    // slower_by is 0 at first.
    array_sum #(
        .W    (24),
        .ROUND(0)
    ) u_usual (
        .a     ({slower_by[24], slower_by[24:2]}),
        .choice(first),
        .one   ({ticks, 1'b0}),
        .other ({usual, 1'b0}),
        .y     (next_usual)
    );

    // What is granted is 0 but when a deadline is set.
    array_sum #(
        .W    (UNTIL_W),
        .ROUND(0)
    ) u_deadline (
        .a     ({{(UNTIL_W - 24) {1'b0}}, granted}),
        .choice(hold),
        .one   ({its_deadline, 1'b0}),
        .other ({counted, 1'b0}),
        .y     (next_deadline)
    );

    always @(posedge clk) begin
        age    <= now - then;
        beyond <= |age[TIME_W-1:24];
        ticks  <= age[23:0] | {24{beyond}} | {23'd0, age[23:1] == 23'd0};
        future  <= late[UNTIL_W-1];
        later   <= !spare[UNTIL_W-1];
        instant <= ticks[23:1] == 23'd0;
        silent <= |age[TIME_W-1:25] || {usual, 1'b0} < age[24:0];

        slower_by <= first ? 25'd0 : {1'b0, ticks} - {1'b0, usual};
        if (load) usual <= loaded;
        if (correct && (first || !instant)) usual <= next_usual;

        // The time until the deadline is shifted, then limited, then added.
        grants <= correct;
        if (grants) begin
            over      <= 1'b0;
            grow_left <= life_log2;
            grows     <= 1'b1;
        end
        if (grows) begin
            grow_left <= grow_left - 4'd1;
            if (grow_left == 4'd0) grows <= 1'b0;
            else over <= over || grant[23];
        end
        if (grants || doubles) grant <= doubles ? {grant[22:0], 1'b0} : usual;
        limits  <= grows && grow_left == 4'd0;
        shorter   <= !over && grant < life_ticks;
        longer    <= over || coast_ticks < grant;
        chooses <= limits;
        if (seed || leave || chooses)
            granted <= seed ? detect_ticks : leave ? return_ticks : shorter ? life_ticks : longer ? coast_ticks : grant;
        adds <= chooses || seed || leave;
        if (adds || hold) deadline <= next_deadline;

        if (take || halves) other <= halves ? {1'b0, other[TIME_W-1:1]} : age;
        if (divide) begin
            left    <= down;
            divides <= 1'b1;
        end
        if (divides) begin
            left <= left - 6'd1;
            if (left == 6'd0) divides <= 1'b0;
        end
        dividing <= divide || divides;
        older   <= ahead[TIME_W];
        many    <= |other[TIME_W-1:16];
        enough  <= !(together < {6'd0, join_steps}) && (many ? &together : !(together < other[15:0]));
        overdue <= many || !(other[15:0] < {6'd0, report_steps});

        if (rst) begin
            grants   <= 1'b0;
            grows    <= 1'b0;
            limits   <= 1'b0;
            chooses  <= 1'b0;
            adds     <= 1'b0;
            divides  <= 1'b0;
            dividing <= 1'b0;
        end
        if (rst || (adds && !seed && !leave && !chooses)) granted <= 24'd0;
    end

    wire unused = &{1'b0, slower_by, ahead[TIME_W-1:0], late, spare};

endmodule

`default_nettype wire
