// SPDX-License-Identifier: Apache-2.0
// What the program of motion_engine.v starts and waits for: the search for a gap, and the correction of a velocity.
//
// Latency:    1 clock from a word of the program to its effect; then those of motion_gaps.v and motion_velocity.v.
// Throughput: one search and one correction at a time.
// Stall:      results stay until the next start.
// Reset:      nothing is under way.
// Combinational paths: none.
`default_nettype none
`include "motion_codes.vh"

module motion_units #(
    parameter SLOT_W = 3,
    parameter PX_W   = 13,   // bits of a length in pixels
    parameter OFF_W  = 30,   // bits of an offset
    parameter W      = 48    // bits of the engine's words
) (
    input  wire              clk,
    input  wire              rst,

    // a word of the program
    input  wire              write,
    input  wire [4:0]        target,
    input  wire [W-1:0]      acc_x,
    input  wire [W-1:0]      acc_y,
    input  wire              flag,
    input  wire [SLOT_W-1:0] at,

    // registers
    input  wire [4:0]        step_log2,
    input  wire [14:0]       speed_max,
    input  wire [3:0]        gap_share,

    // events in bins: see motion_gaps.v
    input  wire              busy,
    input  wire              count,
    input  wire [SLOT_W-1:0] slot,
    input  wire              in_bin_x,
    input  wire              in_bin_y,
    input  wire [3:0]        bin_x,
    input  wire [3:0]        bin_y,
    input  wire              first_x,
    input  wire              first_y,
    input  wire [15:0]       used_x,
    input  wire [15:0]       used_y,

    output reg               looking,
    output wire              gap_found,
    output wire              low_stays,
    output wire [3:0]        gap_bin,     // of the cut
    output reg               speeding,
    output wire signed [15:0] speed_x,
    output wire signed [15:0] speed_y
);

    reg                     look, on_y, start, slower;
    reg [4:0]               bin_log2;
    reg [PX_W-1:0]          narrowest;
    reg [23:0]              ticks;
    reg [3:0]               gain;
    reg signed [15:0]       v_x, v_y;
    reg signed [OFF_W-1:0]  low_x, low_y, high_x, high_y;
    wire                    look_done, speed_done;
    wire [3:0]              begins, ends;

    assign gap_bin = low_stays ? begins : ends;

    always @(posedge clk) begin
        look  <= 1'b0;
        start <= 1'b0;
        if (look_done) looking <= 1'b0;
        if (speed_done) speeding <= 1'b0;
        if (write)
            case (target)
                `EVCOT_MOTION_OUT_SCALE: bin_log2 <= acc_x[4:0];
                `EVCOT_MOTION_OUT_SCALE_Y: bin_log2 <= acc_y[4:0];
                `EVCOT_MOTION_OUT_LOOK_X: begin
                    narrowest <= acc_x[PX_W-1:0];
                    on_y      <= 1'b0;
                    look      <= 1'b1;
                    looking   <= 1'b1;
                end
                `EVCOT_MOTION_OUT_LOOK_Y: begin
                    narrowest <= acc_y[PX_W-1:0];
                    on_y      <= 1'b1;
                    look      <= 1'b1;
                    looking   <= 1'b1;
                end
                `EVCOT_MOTION_OUT_TICKS: ticks <= acc_x[23:0];
                `EVCOT_MOTION_OUT_SLOWER: slower <= flag;
                `EVCOT_MOTION_OUT_GAIN: gain <= acc_x[3:0];
                `EVCOT_MOTION_OUT_OFF_LO: {low_x, low_y} <= {acc_x[OFF_W-1:0], acc_y[OFF_W-1:0]};
                `EVCOT_MOTION_OUT_OFF_HI: {high_x, high_y} <= {acc_x[OFF_W-1:0], acc_y[OFF_W-1:0]};
                `EVCOT_MOTION_OUT_SPEED: begin
                    {v_x, v_y} <= {acc_x[15:0], acc_y[15:0]};
                    start      <= 1'b1;
                    speeding   <= 1'b1;
                end
                default: ;
            endcase
        if (rst) begin
            look     <= 1'b0;
            start    <= 1'b0;
            looking  <= 1'b0;
            speeding <= 1'b0;
        end
    end

    motion_gaps #(
        .PX_W  (PX_W),
        .SLOT_W(SLOT_W)
    ) u_gaps (
        .clk      (clk),
        .rst      (rst),
        .slot     (busy && !count ? at : slot),
        .count    (count),
        .in_x     (in_bin_x),
        .in_y     (in_bin_y),
        .bin_x    (bin_x),
        .bin_y    (bin_y),
        .first_x  (first_x),
        .first_y  (first_y),
        .look     (look),
        .on_y     (on_y),
        .used     (on_y ? used_y : used_x),
        .bin_log2 (bin_log2),
        .narrowest(narrowest),
        .gap_share(gap_share),
        .done     (look_done),
        .found    (gap_found),
        .low_stays(low_stays),
        .begins   (begins),
        .ends     (ends)
    );

    motion_velocity #(
        .OFF_W(OFF_W)
    ) u_velocity (
        .clk      (clk),
        .rst      (rst),
        .start    (start),
        .ticks    (ticks),
        .off_lo_x (low_x),
        .off_hi_x (high_x),
        .off_lo_y (low_y),
        .off_hi_y (high_y),
        .slower   (slower),
        .gain     (gain),
        .step_log2(step_log2),
        .speed_max(speed_max),
        .v_x      (v_x),
        .v_y      (v_y),
        .done     (speed_done),
        .v_x_next (speed_x),
        .v_y_next (speed_y)
    );

    wire unused = &{1'b0, acc_x, acc_y};

endmodule

`default_nettype wire
