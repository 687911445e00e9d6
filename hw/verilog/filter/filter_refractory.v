// SPDX-License-Identifier: Apache-2.0
// Drops the events of each pixel for a while after a kept event (docs/filters.md).
//
// One bank of block RAM holds the time of each pixel's last kept event; stamp_walk.v keeps stamps of STAMP_W bits exact while they
// wrap. A pixel is read four clocks before the decision and written with it, as only kept events are stored. If the same pixel is
// written in between, the new stamp is forwarded; likewise for a visit of the walk, which is decided and written at the same
// stage. Data read from the address that is written in the same clock is never used.
//
// Latency:    7 clocks from s_ to m_: time and address, address, RAM, its output, stamp, age, decision.
// Throughput: 1 token per clock; for stalls by the walk over the memory, which are rare, see stamp_walk.v.
// Stall:      while the output is full, the pipeline stalls.
// Reset:      becomes empty and clears the memory: WIDTH * HEIGHT + 6 clocks with idle and s_ready low.
// RAM:        WIDTH * HEIGHT * STAMP_W bits.
// Combinational paths: none; s_ready comes from registers alone, and all m_ outputs are registers.
`default_nettype none
`include "evcot_defs.vh"

module filter_refractory #(
    parameter X_W     = 9,    // bits of an x address
    parameter Y_W     = 9,    // bits of a y address
    parameter TICK_W  = 20,   // bits of the tick input
    parameter WIDTH   = 346,  // pixels of the sensor across
    parameter HEIGHT  = 260,  // pixels of the sensor down
    parameter STAMP_W = 20    // bits of a time stamp
) (
    input  wire               clk,
    input  wire               rst,

    // registers: see filter_regs.v
    input  wire               enable,
    input  wire [STAMP_W-2:0] refractory_ticks,

    // tokens in
    input  wire               s_valid,
    output wire               s_ready,
    input  wire [TICK_W-1:0]  s_tick,
    input  wire               s_event,
    input  wire               s_skip,
    input  wire [X_W-1:0]     s_x,
    input  wire [Y_W-1:0]     s_y,
    input  wire               s_p,

    // tokens out
    output wire               m_valid,
    input  wire               m_ready,
    output wire [TICK_W-1:0]  m_tick,
    output wire               m_event,
    output wire               m_skip,
    output wire [X_W-1:0]     m_x,
    output wire [Y_W-1:0]     m_y,
    output wire               m_p,

    output wire               idle  // nothing inside, memory emptied after reset
);

    parameter_check #(.OK(X_W >= `EVCOT_X_W_MIN && X_W <= `EVCOT_X_W_MAX)) X_W_must_be_1_to_16 ();
    parameter_check #(.OK(Y_W >= `EVCOT_Y_W_MIN && Y_W <= `EVCOT_Y_W_MAX)) Y_W_must_be_1_to_16 ();
    parameter_check #(.OK(TICK_W >= `EVCOT_TICK_W_MIN && TICK_W <= `EVCOT_TICK_W_MAX)) TICK_W_must_be_1_to_32 ();
    parameter_check #(.OK(WIDTH >= `EVCOT_WIDTH_MIN && WIDTH <= `EVCOT_WIDTH_MAX)) WIDTH_must_be_1_to_65536 ();
    parameter_check #(.OK(HEIGHT >= `EVCOT_HEIGHT_MIN && HEIGHT <= `EVCOT_HEIGHT_MAX)) HEIGHT_must_be_1_to_65536 ();
    parameter_check #(.OK(WIDTH <= 16777216 / HEIGHT)) WIDTH_times_HEIGHT_must_be_at_most_2_to_the_24 ();
    parameter_check #(.OK(STAMP_W >= `EVCOT_STAMP_W_MIN && STAMP_W <= `EVCOT_STAMP_W_MAX)) STAMP_W_must_be_4_to_32 ();

    localparam PIXELS  = WIDTH * HEIGHT;
    localparam ADDR_W  = (PIXELS > 1) ? $clog2(PIXELS) : 1;
    localparam TOKEN_W = TICK_W + X_W + Y_W + 4;

    localparam [31:0] ACROSS = WIDTH;
    localparam [31:0] DOWN   = HEIGHT;
    localparam [STAMP_W-1:0] KEEP = {1'b1, {(STAMP_W - 1) {1'b0}}};  // the age of none

    wire space;  // for one more token in the output: everything moves

    // ---- time and pixel, and what enters: a token, or a visit of the walk --------------------------------------------

    wire [31:0] x     = {{(32 - X_W) {1'b0}}, s_x};
    wire [31:0] y     = {{(32 - Y_W) {1'b0}}, s_y};
    wire [31:0] pixel = y * ACROSS + x;
    wire        on_sensor = x < ACROSS && y < DOWN;
    wire        unused    = &{1'b0, pixel};

    reg [TOKEN_W-1:0] token;
    reg [ADDR_W-1:0]  token_at;

    always @(posedge clk)
        if (s_ready) begin
            token    <= {s_event && enable, s_tick, s_event, s_skip, s_x, s_y, s_p};
            token_at <= pixel[ADDR_W-1:0];
        end

    wire enters, access, visits, clearing, waits;
    wire [ADDR_W-1:0]  row;
    wire [STAMP_W-1:0] now;

    reg                read_valid, read_access, read_visits;
    reg                found_valid, found_access, found_visits;
    reg                held_valid, held_access, held_visits;
    reg                then_valid, then_access, then_visits;
    reg                age_valid, age_access, age_visits;
    reg [TOKEN_W-1:0]  read_token, found_token, held_token, then_token, age_token;
    reg [ADDR_W-1:0]   read_at, found_at, held_at, then_at, age_at;
    reg [STAMP_W-1:0]  read_now, found_now, held_now, then_now, age_now;

    stamp_walk #(
        .W        (STAMP_W),
        .SEGMENT_W(STAMP_W - 2),  // ages up to 2^(STAMP_W-1) - 1 matter
        .STEP_W   (TICK_W),
        .ROWS     (PIXELS),
        .ROW_W    (ADDR_W)
    ) u_walk (
        .clk        (clk),
        .rst        (rst),
        .advance    (space),
        .s_valid    (s_valid),
        .s_ready    (s_ready),
        .s_step     (s_tick),
        .s_access   (s_event && enable && on_sensor),
        .enters     (enters),
        .access     (access),
        .visits     (visits),
        .row        (row),
        .now        (now),
        .visited    (age_visits),
        .missed     (1'b0),
        .visited_row(age_at),
        .clearing   (clearing),
        .waits      (waits)
    );

    // ---- memory ------------------------------------------------------------------------------------------------------

    (* ram_style = "block", no_rw_check *)
    reg [STAMP_W-1:0] stamps [0:PIXELS-1];
    reg [STAMP_W-1:0] found, held, then, age;

    // What the read could not find: written by the slot ahead, by the second, the third one ahead, or by the fourth, in the clock
    // of the read.
    reg               same_as_first, same_as_second, same_as_third, passed, replaced;
    reg [STAMP_W-1:0] passed_stamp, replacement;

    // An age of KEEP or more is long enough. A lesser one, less refractory_ticks, lies between -KEEP and KEEP: its sign tells.
    reg  [STAMP_W-1:0] then_least;  // the newest stamp that is old enough
    reg                too_young;   // if the age is less than KEEP

    wire stays  = age_access && (age[STAMP_W-1] || !too_young);
    wire writes = stays || (age_visits && (age[STAMP_W-1] || clearing));
    wire [STAMP_W-1:0] stamp = stays ? age_now : age_now - KEEP;

    wire [STAMP_W-1:0] last   = (same_as_first && stays) ? age_now : then;
    wire [STAMP_W-1:0] margin = then_least - last;  // age - refractory_ticks
    wire               unused_margin = &{1'b0, margin};

    always @(posedge clk)
        if (space) begin
            if (writes) stamps[age_at] <= stamp;
            found          <= stamps[read_at];
            passed         <= read_at == age_at && writes;
            passed_stamp   <= stamp;

            same_as_third  <= read_at == then_at;
            held           <= found;  // a RAM gives late in its clock
            replaced       <= (same_as_third && writes) || passed;
            replacement    <= (same_as_third && writes) ? stamp : passed_stamp;

            same_as_second <= found_at == then_at;
            then           <= (same_as_second && writes) ? stamp : replaced ? replacement : held;

            same_as_first  <= held_at == then_at;
            age            <= then_now - last;
            then_least     <= held_now - {1'b0, refractory_ticks};
            too_young      <= margin[STAMP_W-1];
        end

    // ---- the way to the decision -------------------------------------------------------------------------------------

    always @(posedge clk) begin
        if (space) begin
            read_valid   <= enters;
            read_access  <= access;
            read_visits  <= visits;
            read_token   <= token;
            read_at      <= visits ? row : token_at;
            read_now     <= now;

            found_valid  <= read_valid;
            found_access <= read_access;
            found_visits <= read_visits;
            found_token  <= read_token;
            found_at     <= read_at;
            found_now    <= read_now;

            held_valid   <= found_valid;
            held_access  <= found_access;
            held_visits  <= found_visits;
            held_token   <= found_token;
            held_at      <= found_at;
            held_now     <= found_now;

            then_valid   <= held_valid;
            then_access  <= held_access;
            then_visits  <= held_visits;
            then_token   <= held_token;
            then_at      <= held_at;
            then_now     <= held_now;

            age_valid    <= then_valid;
            age_access   <= then_access;
            age_visits   <= then_visits;
            age_token    <= then_token;
            age_at       <= then_at;
            age_now      <= then_now;
        end
        if (rst) begin
            read_valid   <= 1'b0;
            read_access  <= 1'b0;
            read_visits  <= 1'b0;
            found_valid  <= 1'b0;
            found_access <= 1'b0;
            found_visits <= 1'b0;
            held_valid   <= 1'b0;
            held_access  <= 1'b0;
            held_visits  <= 1'b0;
            then_valid   <= 1'b0;
            then_access  <= 1'b0;
            then_visits  <= 1'b0;
            age_valid    <= 1'b0;
            age_access   <= 1'b0;
            age_visits   <= 1'b0;
        end
    end

    wire              judged, is_event, skip;
    wire [TICK_W-1:0] tick;
    wire [X_W+Y_W:0]  rest;  // x, y, p
    assign {judged, tick, is_event, skip, rest} = age_token;

    wire drops = judged && !stays;

    skid_buffer #(
        .W(TICK_W + X_W + Y_W + 3)
    ) u_output (
        .clk    (clk),
        .rst    (rst),
        .s_valid(age_valid),
        .s_ready(space),
        .s_data ({tick, is_event && !drops, skip || drops, rest}),
        .m_valid(m_valid),
        .m_ready(m_ready),
        .m_data ({m_tick, m_event, m_skip, m_x, m_y, m_p})
    );

    assign idle = !clearing && !waits && !read_valid && !found_valid && !held_valid && !then_valid && !age_valid && !m_valid;

endmodule

`default_nettype wire
