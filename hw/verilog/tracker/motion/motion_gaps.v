// SPDX-License-Identifier: Apache-2.0
// The bins of all slots, and the search for a gap in them: docs/motion.md, rules G1 and G3.
//
// An event makes its bin on each axis one more: read, then written four clocks later; what is being written is forwarded. A bin can
// be cleared in its place.
//
// Latency:    4 clocks from count to the bin; 47 clocks from look to done.
// Throughput: an event per clock, and one look beside them, of a slot whose bins do not change.
// Stall:      what a look found stays until the next one.
// Reset:      waits for a look. Bins are not reset.
// Combinational paths: none.
`default_nettype none

module motion_gaps #(
    parameter PX_W   = 13,  // bits of a length in pixels
    parameter SLOT_W = 3    // bits of a slot number
) (
    input  wire              clk,
    input  wire              rst,

    // an event
    input  wire [SLOT_W-1:0] slot,
    input  wire              count,
    input  wire              in_x,       // the event has a bin on x
    input  wire              in_y,
    input  wire [3:0]        bin_x,
    input  wire [3:0]        bin_y,
    input  wire              clear,      // in place of an event: this bin is cleared on both axes
    input  wire [3:0]        cleared,

    input  wire              look,
    input  wire [SLOT_W-1:0] look_slot,
    input  wire              on_y,
    input  wire [4:0]        bin_log2,   // a bin has 2^bin_log2 pixels
    input  wire [PX_W-1:0]   narrowest,  // pixels of a gap
    input  wire [3:0]        gap_share,

    output reg               done,
    output reg               found,
    output reg               low_stays,  // the part below the gap has at least as many events
    output reg  [3:0]        begins,     // first bin of the gap
    output reg  [3:0]        ends        // first bin behind it
);

    localparam BIN_W  = 18;         // bits of a count: 255 corrections of 1023 events
    localparam WIDE_W = PX_W + 1;   // bits of the gap's width: 2^(PX_W - 3) pixels a bin at most

    // ---- an event ----------------------------------------------------------------------------------------------------

    wire [BIN_W-1:0] looked_x, looked_y;
    reg  [4:0]       at;  // bin that is looked at; that of three clocks before is there

    motion_bins #(
        .BIN_W  (BIN_W),
        .PLACE_W(SLOT_W + 4)
    ) u_x (
        .clk   (clk),
        .rst   (rst),
        .count (count && in_x),
        .clear (clear),
        .place ({slot, clear ? cleared : bin_x}),
        .look  ({look_slot, at[3:0]}),
        .looked(looked_x)
    );

    motion_bins #(
        .BIN_W  (BIN_W),
        .PLACE_W(SLOT_W + 4)
    ) u_y (
        .clk   (clk),
        .rst   (rst),
        .count (count && in_y),
        .clear (clear),
        .place ({slot, clear ? cleared : bin_y}),
        .look  ({look_slot, at[3:0]}),
        .looked(looked_y)
    );

    // ---- a look: twice through the bins --------------------------------------------------------------------------------

    localparam [2:0] WAIT  = 3'd0;
    localparam [2:0] SUM   = 3'd1;  // all events
    localparam [2:0] LEAST = 3'd2;  // what an empty bin has at most, found until the first one is there
    localparam [2:0] RUNS  = 3'd3;  // the widest gap
    localparam [2:0] PLACE = 3'd4;  // where it lies
    localparam [2:0] WIDE  = 3'd5;
    localparam [2:0] JUDGE = 3'd6;

    reg [2:0]        state;
    reg              wide;
    reg [BIN_W-1:0]  value;
    reg [BIN_W:0]    total;         // of all events
    reg [BIN_W:0]    sum;           // of those in the bins before, and then of all
    reg [BIN_W+1:0]  rest;          // of those below the widest gap, less all
    reg [BIN_W:0]    run_below;     // of those before a run of empty bins,
    reg [BIN_W:0]    below, with_gap;  // before the widest gap, and with those in it
    reg [BIN_W:0]    sum_then, run_below_then;  // one clock before
    reg [BIN_W-1:0]  least, share;
    reg              full;     // the value is more than an empty bin has
    reg              any;      // a bin that is not empty was there
    reg              closes;   // a run of empty bins between two that are not has ended: so many, before this one
    reg [3:0]        ran, stop;
    reg [3:0]        run, widest, behind, bin_1, bin_2, bin;
    reg [4:0]        log2;
    reg [10:0]       part;
    reg [WIDE_W-1:0] width;    // of the widest gap, in pixels

    wire             looking = state != WAIT;
    wire [BIN_W-1:0] looked  = on_y ? looked_y : looked_x;
    wire [BIN_W:0]   next_sum = sum + {1'b0, value};
    wire [BIN_W:0]   spare   = {1'b0, least} - {1'b0, looked};  // negative where a bin is not empty
    reg              there;                // the value of `bin`
    reg              last;                 // of all bins
    wire [BIN_W+1:0] parts   = rest + {1'b0, with_gap};  // of those below, less those above

    always @(posedge clk) begin
        done     <= 1'b0;
        bin_1    <= at[3:0];
        bin_2    <= bin_1;
        bin      <= bin_2;
        log2     <= bin_log2;
        value    <= looked;
        full     <= spare[BIN_W];
        share    <= total[BIN_W-1:0] >> gap_share;
        rest     <= {1'b0, below} - {1'b0, total};
        there    <= at > 5'd1 && !last;
        last     <= at == 5'd17;
        closes   <= state == RUNS && there && full && any;
        ran      <= run;
        stop     <= bin;
        begins   <= behind - widest;
        ends     <= behind;
        part     <= {7'd0, widest} << log2[2:0];
        width    <= {{(WIDE_W - 11) {1'b0}}, part} << {log2[4:3], 3'd0};
        sum_then       <= sum;
        run_below_then <= run_below;
        if (closes && widest < ran) begin
            widest   <= ran;
            behind   <= stop;
            below    <= run_below_then;
            with_gap <= sum_then;
        end
        if (looking) at <= last ? 5'd0 : at + 5'd1;
        case (state)
            WAIT: begin
                at    <= 5'd0;
                sum   <= {(BIN_W + 1) {1'b0}};
                if (look) state <= SUM;
            end
            SUM: begin
                if (there) sum <= next_sum;
                if (last) state <= LEAST;
            end
            LEAST: begin
                any    <= 1'b0;
                run    <= 4'd0;
                widest <= 4'd0;
                at     <= 5'd0;
                total  <= sum;
                sum    <= {(BIN_W + 1) {1'b0}};
                state  <= RUNS;
            end
            RUNS: begin
                if (!there) least <= share == {BIN_W{1'b0}} ? {{(BIN_W - 1) {1'b0}}, 1'b1} : share;
                if (there && full) any <= 1'b1;
                if (there) run <= full ? 4'd0 : run + 4'd1;
                if (there) sum <= next_sum;
                if (there && full) run_below <= next_sum;
                if (last) state <= PLACE;
            end
            PLACE: begin
                at    <= 5'd0;
                state <= WIDE;
            end
            WIDE: begin
                wide <= widest != 4'd0 && !(width < {{(WIDE_W - PX_W) {1'b0}}, narrowest});
                if (at == 5'd4) state <= JUDGE;
            end
            JUDGE: begin
                found     <= wide;
                low_stays <= !parts[BIN_W+1];
                done      <= 1'b1;
                state     <= WAIT;
            end
            default: state <= WAIT;
        endcase
        if (rst) begin
            state <= WAIT;
            done  <= 1'b0;
        end
    end

    wire unused = &{1'b0, parts[BIN_W:0], spare};

endmodule

`default_nettype wire
