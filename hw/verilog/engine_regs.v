// SPDX-License-Identifier: Apache-2.0
// The software-written registers as the engine reads them: those of the slot in C that every event may need, and those of the slot
// in U that only its timer or a special event needs. Each bank is cot_regs.v, and keeps in hardware only what is read of it.
`default_nettype none

module engine_regs #(
    parameter N       = 8,   // slots
    parameter X_W     = 9,   // bits of an x address
    parameter Y_W     = 9,   // bits of a y address
    parameter RADIX_W = 8,   // bits of a radius register
    parameter NEV_W   = 10,  // bits of N_ev
    parameter TC_W    = 24,  // bits of a timer
    parameter SLOT_W  = 3    // bits of a slot number
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               cfg_valid,
    input  wire [SLOT_W-1:0]  cfg_slot,
    input  wire [3:0]         cfg_addr,
    input  wire [31:0]        cfg_data,

    input  wire [SLOT_W-1:0]  c_slot,
    output wire [X_W-1:0]     init_cm_x,
    output wire [Y_W-1:0]     init_cm_y,
    output wire [RADIX_W-1:0] radix_th,
    output wire [RADIX_W-1:0] radix_step,
    output wire [RADIX_W-1:0] radix_min,
    output wire [RADIX_W-1:0] radix_max,
    output wire [3:0]         hist_avg,

    input  wire [SLOT_W-1:0]  u_slot,
    output wire [1:0]         mode,
    output wire [RADIX_W-1:0] init_radix,
    output wire [TC_W-1:0]    max_ticks,
    output wire [NEV_W-1:0]   clust_nev,
    output wire [NEV_W-1:0]   nev_min,
    output wire [NEV_W-1:0]   nev_max,
    output wire [TC_W-1:0]    nev_th,
    output wire [TC_W-1:0]    detect_ticks
);

    // What the other bank is for.
    wire [1:0]         c_mode;
    wire [X_W-1:0]     u_init_cm_x;
    wire [Y_W-1:0]     u_init_cm_y;
    wire [RADIX_W-1:0] c_init_radix;
    wire [RADIX_W-1:0] u_radix_th;
    wire [RADIX_W-1:0] u_radix_step;
    wire [RADIX_W-1:0] u_radix_min;
    wire [RADIX_W-1:0] u_radix_max;
    wire [3:0]         u_hist_avg;
    wire [TC_W-1:0]    c_max_ticks;
    wire [NEV_W-1:0]   c_clust_nev;
    wire [NEV_W-1:0]   c_nev_min;
    wire [NEV_W-1:0]   c_nev_max;
    wire [TC_W-1:0]    c_nev_th;
    wire [TC_W-1:0]    c_detect_ticks;

    cot_regs #(
        .N      (N),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .RADIX_W(RADIX_W),
        .NEV_W  (NEV_W),
        .TC_W   (TC_W),
        .SLOT_W (SLOT_W)
    ) u_c (
        .clk         (clk),
        .rst         (rst),
        .cfg_valid   (cfg_valid),
        .cfg_slot    (cfg_slot),
        .cfg_addr    (cfg_addr),
        .cfg_data    (cfg_data),
        .slot        (c_slot),
        .mode        (c_mode),
        .init_cm_x   (init_cm_x),
        .init_cm_y   (init_cm_y),
        .init_radix  (c_init_radix),
        .radix_th    (radix_th),
        .radix_step  (radix_step),
        .radix_min   (radix_min),
        .radix_max   (radix_max),
        .hist_avg    (hist_avg),
        .max_ticks   (c_max_ticks),
        .clust_nev   (c_clust_nev),
        .nev_min     (c_nev_min),
        .nev_max     (c_nev_max),
        .nev_th      (c_nev_th),
        .detect_ticks(c_detect_ticks)
    );

    cot_regs #(
        .N      (N),
        .X_W    (X_W),
        .Y_W    (Y_W),
        .RADIX_W(RADIX_W),
        .NEV_W  (NEV_W),
        .TC_W   (TC_W),
        .SLOT_W (SLOT_W)
    ) u_u (
        .clk         (clk),
        .rst         (rst),
        .cfg_valid   (cfg_valid),
        .cfg_slot    (cfg_slot),
        .cfg_addr    (cfg_addr),
        .cfg_data    (cfg_data),
        .slot        (u_slot),
        .mode        (mode),
        .init_cm_x   (u_init_cm_x),
        .init_cm_y   (u_init_cm_y),
        .init_radix  (init_radix),
        .radix_th    (u_radix_th),
        .radix_step  (u_radix_step),
        .radix_min   (u_radix_min),
        .radix_max   (u_radix_max),
        .hist_avg    (u_hist_avg),
        .max_ticks   (max_ticks),
        .clust_nev   (clust_nev),
        .nev_min     (nev_min),
        .nev_max     (nev_max),
        .nev_th      (nev_th),
        .detect_ticks(detect_ticks)
    );

    wire unused = &{1'b0, c_mode, u_init_cm_x, u_init_cm_y, c_init_radix, u_radix_th, u_radix_step, u_radix_min, u_radix_max,
                    u_hist_avg, c_max_ticks, c_clust_nev, c_nev_min, c_nev_max, c_nev_th, c_detect_ticks};

endmodule

`default_nettype wire
