// SPDX-License-Identifier: Apache-2.0
// The software-written registers of a filter chain: one write port, every value on an output, but those of the noise's levels, of
// which one is read at a time.
//
// Writes take effect on the next clock. Reset disables all filters, stops the clock of filter_decay, gives that of filter_cells
// units of a tick, as both run whether enabled or not, and leaves the other registers as they are. Addresses and meanings:
// evcot_defs.vh, docs/filters.md. Values are stored unchecked: the host must check legal ranges. Bits of cfg_data above a
// register's width are ignored. Register `mask` is not a value but a command: it is output for one clock.
//
// Latency:    1 clock from a write to its effect.
// Throughput: a write per clock.
// Stall:      none.
// Reset:      as above.
// Combinational paths: noise_asked -> noise_least.
`default_nettype none
`include "evcot_defs.vh"

module filter_regs #(
    parameter STAMP_W = 20  // bits of a time stamp in a filter's memory
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               cfg_valid,
    input  wire [`EVCOT_FREG_W-1:0] cfg_addr,
    input  wire [31:0]        cfg_data,

    output reg  [7:0]         enable,            // bit EVCOT_FILTER_*
    output reg  [15:0]        region_x0,
    output reg  [15:0]        region_x1,
    output reg  [15:0]        region_y0,
    output reg  [15:0]        region_y1,
    output reg                polarity,
    output reg  [STAMP_W-2:0] refractory_ticks,
    output reg  [STAMP_W-2:0] activity_ticks,
    output reg  [3:0]         activity_support,
    output reg  [STAMP_W-2:0] recent_ticks,
    output reg  [3:0]         recent_radius,
    output reg  [8:0]         recent_support,
    output reg  [24:0]        decay_rate,
    output reg  [7:0]         decay_epsilon,
    output reg  [11:0]        decay_support,
    output reg  [STAMP_W-2:0] rowcol_ticks,
    output reg  [3:0]         rowcol_radius,
    output reg  [2:0]         rowcol_support,
    output reg  [3:0]         stamp_shift,
    output reg  [4:0]         noise_log2,
    input  wire [2:0]         noise_asked,       // the low bits of the address of noise_2 ... noise_6
    output wire [15:0]        noise_least,       // its value
    output reg                mask_valid,        // mark one pixel
    output reg  [15:0]        mask_x,
    output reg  [14:0]        mask_y,
    output reg                mask_hot
);

    parameter_check #(.OK(STAMP_W >= `EVCOT_STAMP_W_MIN && STAMP_W <= `EVCOT_STAMP_W_MAX)) STAMP_W_must_be_4_to_32 ();

    // One at a time is compared: in a small RAM.
    reg  [15:0] noise_levels [0:7];
    wire        is_noise = cfg_addr >= `EVCOT_FREG_NOISE_2 && cfg_addr <= `EVCOT_FREG_NOISE_6;

    assign noise_least = noise_levels[noise_asked];

    always @(posedge clk) if (cfg_valid && is_noise) noise_levels[cfg_addr[2:0]] <= cfg_data[15:0];

    always @(posedge clk) begin
        mask_valid <= cfg_valid && cfg_addr == `EVCOT_FREG_MASK;
        if (cfg_valid)
            case (cfg_addr)
                `EVCOT_FREG_ENABLE:           enable                     <= cfg_data[7:0];
                `EVCOT_FREG_REGION_X0:        region_x0                  <= cfg_data[15:0];
                `EVCOT_FREG_REGION_X1:        region_x1                  <= cfg_data[15:0];
                `EVCOT_FREG_REGION_Y0:        region_y0                  <= cfg_data[15:0];
                `EVCOT_FREG_REGION_Y1:        region_y1                  <= cfg_data[15:0];
                `EVCOT_FREG_POLARITY:         polarity                   <= cfg_data[0];
                `EVCOT_FREG_REFRACTORY_TICKS: refractory_ticks           <= cfg_data[STAMP_W-2:0];
                `EVCOT_FREG_ACTIVITY_TICKS:   activity_ticks             <= cfg_data[STAMP_W-2:0];
                `EVCOT_FREG_ACTIVITY_SUPPORT: activity_support           <= cfg_data[3:0];
                `EVCOT_FREG_RECENT_TICKS:     recent_ticks               <= cfg_data[STAMP_W-2:0];
                `EVCOT_FREG_RECENT_RADIUS:    recent_radius              <= cfg_data[3:0];
                `EVCOT_FREG_RECENT_SUPPORT:   recent_support             <= cfg_data[8:0];
                `EVCOT_FREG_DECAY_RATE:       decay_rate                 <= cfg_data[24:0];
                `EVCOT_FREG_DECAY_EPSILON:    decay_epsilon              <= cfg_data[7:0];
                `EVCOT_FREG_DECAY_SUPPORT:    decay_support              <= cfg_data[11:0];
                `EVCOT_FREG_ROWCOL_TICKS:     rowcol_ticks               <= cfg_data[STAMP_W-2:0];
                `EVCOT_FREG_ROWCOL_RADIUS:    rowcol_radius              <= cfg_data[3:0];
                `EVCOT_FREG_ROWCOL_SUPPORT:   rowcol_support             <= cfg_data[2:0];
                `EVCOT_FREG_STAMP_SHIFT:      stamp_shift                <= cfg_data[3:0];
                `EVCOT_FREG_NOISE_LOG2:       noise_log2                 <= cfg_data[4:0];
                `EVCOT_FREG_MASK:             {mask_hot, mask_y, mask_x} <= cfg_data;
                default: ;
            endcase
        if (rst) begin
            enable      <= 8'd0;
            decay_rate  <= 25'd0;
            stamp_shift <= 4'd0;
            mask_valid  <= 1'b0;
        end
    end

endmodule

`default_nettype wire
