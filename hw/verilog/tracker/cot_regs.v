// SPDX-License-Identifier: Apache-2.0
// The software-written registers of N tracker slots: one write port, two read ports. `slot` shows the registers that every event
// may need, `late_slot` those that only a timer, or an event that moves or starts a window, needs: a pipeline reads these later.
//
// Writes take effect on the next clock, those of a mode one clock later; reads are combinational, so the bank maps to distributed
// RAM. Reset turns every slot off and leaves the other registers as they are. Addresses and meanings: evcot_defs.vh,
// docs/algorithm.md. Values are stored unchecked: the host must check legal ranges. Bits of cfg_data above a register's width are
// ignored.
//
// Latency:    1 clock from a write to its effect, 2 of a mode.
// Throughput: a write and a read of two slots per clock.
// Stall:      none.
// Reset:      every mode becomes off, the other registers stay.
// Combinational paths: c_slot, u_slot -> all registers of that slot.
`default_nettype none
`include "evcot_defs.vh"

module cot_regs #(
    parameter N       = 1,   // slots
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter RADIX_W = 8,   // bits of a radius register
    parameter NEV_W   = 10,  // bits of N_ev
    parameter TC_W    = 24,  // bits of a timer
    parameter SLOT_W  = 1    // bits of a slot number
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               cfg_valid,
    input  wire [SLOT_W-1:0]  cfg_slot,
    input  wire [`EVCOT_REG_W-1:0] cfg_addr,
    input  wire [31:0]        cfg_data,

    input  wire [SLOT_W-1:0]  slot,
    output wire [X_W-1:0]     init_cm_x,
    output wire [Y_W-1:0]     init_cm_y,
    output wire [RADIX_W-1:0] radix_th,
    output wire [RADIX_W-1:0] radix_step,
    output wire [RADIX_W-1:0] radix_min,
    output wire [RADIX_W-1:0] radix_max,
    output wire [3:0]         hist_avg,
    output wire [TC_W-1:0]    nev_th,

    input  wire [SLOT_W-1:0]  late_slot,
    output wire [1:0]         mode,
    output wire [RADIX_W-1:0] init_radix,
    output wire [TC_W-1:0]    max_ticks,
    output wire [NEV_W-1:0]   clust_nev,
    output wire [NEV_W-1:0]   nev_min,
    output wire [NEV_W-1:0]   nev_max,
    output wire [TC_W-1:0]    detect_ticks
);

    parameter_check #(.OK(N >= `EVCOT_N_SLOTS_MIN && N <= `EVCOT_N_SLOTS_MAX)) N_must_be_1_to_64 ();
    parameter_check #(.OK((1 << SLOT_W) >= N)) SLOT_W_must_hold_N_slots ();

    reg [1:0]         mode_mem         [0:N-1];
    reg [X_W-1:0]     init_cm_x_mem    [0:N-1];
    reg [Y_W-1:0]     init_cm_y_mem    [0:N-1];
    reg [RADIX_W-1:0] init_radix_mem   [0:N-1];
    reg [RADIX_W-1:0] radix_th_mem     [0:N-1];
    reg [RADIX_W-1:0] radix_step_mem   [0:N-1];
    reg [RADIX_W-1:0] radix_min_mem    [0:N-1];
    reg [RADIX_W-1:0] radix_max_mem    [0:N-1];
    reg [3:0]         hist_avg_mem     [0:N-1];
    reg [TC_W-1:0]    max_ticks_mem    [0:N-1];
    reg [NEV_W-1:0]   clust_nev_mem    [0:N-1];
    reg [NEV_W-1:0]   nev_min_mem      [0:N-1];
    reg [NEV_W-1:0]   nev_max_mem      [0:N-1];
    reg [TC_W-1:0]    nev_th_mem       [0:N-1];
    reg [TC_W-1:0]    detect_ticks_mem [0:N-1];

    assign mode         = mode_mem[late_slot];
    assign init_cm_x    = init_cm_x_mem[slot];
    assign init_cm_y    = init_cm_y_mem[slot];
    assign init_radix   = init_radix_mem[late_slot];
    assign radix_th     = radix_th_mem[slot];
    assign radix_step   = radix_step_mem[slot];
    assign radix_min    = radix_min_mem[slot];
    assign radix_max    = radix_max_mem[slot];
    assign hist_avg     = hist_avg_mem[slot];
    assign max_ticks    = max_ticks_mem[late_slot];
    assign clust_nev    = clust_nev_mem[late_slot];
    assign nev_min      = nev_min_mem[late_slot];
    assign nev_max      = nev_max_mem[late_slot];
    assign nev_th       = nev_th_mem[slot];
    assign detect_ticks = detect_ticks_mem[late_slot];

    reg              mode_written;
    reg [SLOT_W-1:0] mode_slot;
    reg [1:0]        mode_data;
    integer          i;

    always @(posedge clk) begin
        if (cfg_valid) begin
            case (cfg_addr)
                `EVCOT_REG_INIT_CM_X:    init_cm_x_mem[cfg_slot]    <= cfg_data[X_W-1:0];
                `EVCOT_REG_INIT_CM_Y:    init_cm_y_mem[cfg_slot]    <= cfg_data[Y_W-1:0];
                `EVCOT_REG_INIT_RADIX:   init_radix_mem[cfg_slot]   <= cfg_data[RADIX_W-1:0];
                `EVCOT_REG_RADIX_TH:     radix_th_mem[cfg_slot]     <= cfg_data[RADIX_W-1:0];
                `EVCOT_REG_RADIX_STEP:   radix_step_mem[cfg_slot]   <= cfg_data[RADIX_W-1:0];
                `EVCOT_REG_RADIX_MIN:    radix_min_mem[cfg_slot]    <= cfg_data[RADIX_W-1:0];
                `EVCOT_REG_RADIX_MAX:    radix_max_mem[cfg_slot]    <= cfg_data[RADIX_W-1:0];
                `EVCOT_REG_HIST_AVG:     hist_avg_mem[cfg_slot]     <= cfg_data[3:0];
                `EVCOT_REG_MAX_TICKS:    max_ticks_mem[cfg_slot]    <= cfg_data[TC_W-1:0];
                `EVCOT_REG_CLUST_NEV:    clust_nev_mem[cfg_slot]    <= cfg_data[NEV_W-1:0];
                `EVCOT_REG_NEV_MIN:      nev_min_mem[cfg_slot]      <= cfg_data[NEV_W-1:0];
                `EVCOT_REG_NEV_MAX:      nev_max_mem[cfg_slot]      <= cfg_data[NEV_W-1:0];
                `EVCOT_REG_NEV_TH:       nev_th_mem[cfg_slot]       <= cfg_data[TC_W-1:0];
                `EVCOT_REG_DETECT_TICKS: detect_ticks_mem[cfg_slot] <= cfg_data[TC_W-1:0];
                default: ;  // no such register
            endcase
        end
        // One that is reset is no memory: its decoder is given a clock.
        mode_written <= cfg_valid && cfg_addr == `EVCOT_REG_MODE;
        mode_slot    <= cfg_slot;
        mode_data    <= cfg_data[1:0];
        if (mode_written) mode_mem[mode_slot] <= mode_data;
        if (rst) begin
            mode_written <= 1'b0;
            for (i = 0; i < N; i = i + 1) mode_mem[i] <= `EVCOT_MODE_OFF;
        end
    end

    wire unused = &{1'b0, cfg_data};

endmodule

`default_nettype wire
