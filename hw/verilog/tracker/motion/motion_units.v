// SPDX-License-Identifier: Apache-2.0
// What the program of motion_engine.v starts and waits for: the search for a gap, and what a division by a number is done with.
//
// Latency:    1 clock from a word of the program to its effect; then those of motion_gaps.v and motion_inverse.v.
// Throughput: one search and one number at a time.
// Stall:      results stay until the next start.
// Reset:      nothing is under way.
// Combinational paths: none.
`default_nettype none
`include "motion_codes.vh"

module motion_units #(
    parameter SLOT_W = 3,
    parameter PX_W   = 13,   // bits of a length in pixels
    parameter W      = 48    // bits of the engine's words
) (
    input  wire              clk,
    input  wire              rst,

    // a word of the program
    input  wire              write,
    input  wire [4:0]        target,
    input  wire [W-1:0]      acc_x,
    input  wire [W-1:0]      acc_y,
    input  wire [SLOT_W-1:0] at,

    // registers
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
    output wire              dividing,
    output wire [4:0]        leading,
    output wire [6:0]        inverse
);

    reg            look, on_y;
    reg [4:0]      bin_log2;
    reg [PX_W-1:0] narrowest;
    wire           look_done;
    wire [3:0]     begins, ends;

    assign gap_bin = low_stays ? begins : ends;

    always @(posedge clk) begin
        look <= 1'b0;
        if (look_done) looking <= 1'b0;
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
                default: ;
            endcase
        if (rst) begin
            look    <= 1'b0;
            looking <= 1'b0;
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

    motion_inverse u_inverse (
        .clk    (clk),
        .rst    (rst),
        .start  (write && target == `EVCOT_MOTION_OUT_DIVISOR),
        .number (acc_x[23:0]),
        .busy   (dividing),
        .leading(leading),
        .inverse(inverse)
    );

    wire unused = &{1'b0, acc_x, acc_y};

endmodule

`default_nettype wire
