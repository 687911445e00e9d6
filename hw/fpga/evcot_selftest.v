// SPDX-License-Identifier: Apache-2.0
// A tracker with a built-in self-test: pseudo-random events, fixed settings, and three signatures of all results.
//
// After reset the registers of all slots are written, then events of lfsr_event_source.v go in, one tick each. Records, owned
// and passed events are folded into a signature each: rotated by one bit, then the word's 32-bit pieces exclusive-ored in.
// What they hold depends on the order of the events alone, so the signatures are the same at any clock, and those of the Python twin, evcot_cosim/fpga/selftest.py.
//
// done is asserted once everything is idle and stays high; passed is then high if the signatures are as expected. Reset restarts.
`default_nettype none
`include "evcot_defs.vh"

module evcot_selftest (
    input  wire        clk,
    input  wire        rst,

    output reg         done,
    output wire        passed,
    output reg  [31:0] n_records,
    output reg  [31:0] cm_signature,
    output reg  [31:0] own_signature,
    output reg  [31:0] pass_signature
);

    // N, EVENTS, SEED, GAP_W, GAP, MIN, SPAN, *_EXPECTED, WRITES, register_write
    `include "evcot_selftest.vh"

    localparam SLOT_W = (N > 1) ? $clog2(N) : 1;
    localparam X_W = 9;
    localparam Y_W = 9;
    localparam QUIET = 6'd63;  // clocks without a word, after which there is none to come
    localparam [31:0] LAST_SLOT = N - 1;

    // ---- registers -------------------------------------------------------------------------------------------------

    reg                configured;
    reg [`EVCOT_REG_W-1:0] write;
    reg [SLOT_W-1:0]   slot;
    wire [`EVCOT_REG_W+31:0] word = register_write(write);  // address, value

    always @(posedge clk) begin
        if (!configured) begin
            write <= write + 1'b1;
            if (write == WRITES - 1'b1) begin
                write      <= {`EVCOT_REG_W{1'b0}};
                slot       <= slot + 1'b1;
                configured <= slot == LAST_SLOT[SLOT_W-1:0];
            end
        end
        if (rst) begin
            write      <= {`EVCOT_REG_W{1'b0}};
            slot       <= {SLOT_W{1'b0}};
            configured <= 1'b0;
        end
    end

    // ---- events ----------------------------------------------------------------------------------------------------

    reg        loaded;
    reg [31:0] n_events;
    wire       valid, ready, p;
    wire [X_W-1:0] x;
    wire [Y_W-1:0] y;
    wire       offered = valid && n_events != EVENTS;

    always @(posedge clk) begin
        loaded <= configured;
        if (offered && ready) n_events <= n_events + 32'd1;
        if (rst) begin
            loaded   <= 1'b0;
            n_events <= 32'd0;
        end
    end

    /* verilator lint_off PINCONNECTEMPTY */
    lfsr_event_source #(
        .X_W   (X_W),
        .Y_W   (Y_W),
        .GAP_W (GAP_W),
        .LFSR_W(32)
    ) u_source (
        .clk       (clk),
        .rst       (rst),
        .enable    (loaded),
        .load      (configured && !loaded),
        .seed      (SEED),
        .seed_error(),
        .done      (),
        .gap       (GAP),
        .x_min     (MIN),
        .x_span    (SPAN),
        .y_min     (MIN),
        .y_span    (SPAN),
        .m_valid   (valid),
        .m_ready   (ready && offered),
        .m_x       (x),
        .m_y       (y),
        .m_p       (p)
    );
    /* verilator lint_on PINCONNECTEMPTY */

    // ---- tracker ---------------------------------------------------------------------------------------------------

    wire              cm_valid, own_valid, pass_valid, own_p, pass_p, idle;
    wire [1:0]        cm_kind;
    wire [SLOT_W-1:0] cm_slot, own_slot;
    wire [31:0]       cm_id, cm_other;
    wire [X_W+3:0]    cm_x;
    wire [Y_W+3:0]    cm_y;
    wire [8:0]        cm_radius;
    wire [9:0]        cm_n_ev, own_x, own_y;
    wire [15:0]       cm_support;
    wire [47:0]       cm_seq, cm_time, own_seq, pass_seq;
    wire [X_W-1:0]    pass_x;
    wire [Y_W-1:0]    pass_y;

    cot_array #(
        .N      (N),
        .TICK_W (1)
    ) u_tracker (
        .clk         (clk),
        .rst         (rst),
        .cfg_valid   (!configured),
        .cfg_slot    (slot),
        .cfg_addr    (word[32+:`EVCOT_REG_W]),
        .cfg_data    (word[31:0]),
        .s_valid     (offered),
        .s_ready     (ready),
        .s_tick      (1'b1),
        .s_event     (1'b1),
        .s_skip      (1'b0),
        .s_x         (x),
        .s_y         (y),
        .s_p         (p),
        .m_cm_valid  (cm_valid),
        .m_cm_ready  (1'b1),
        .m_cm_kind   (cm_kind),
        .m_cm_slot   (cm_slot),
        .m_cm_id     (cm_id),
        .m_cm_other  (cm_other),
        .m_cm_x      (cm_x),
        .m_cm_y      (cm_y),
        .m_cm_radius (cm_radius),
        .m_cm_n_ev   (cm_n_ev),
        .m_cm_support(cm_support),
        .m_cm_seq    (cm_seq),
        .m_cm_time   (cm_time),
        .m_own_valid (own_valid),
        .m_own_ready (1'b1),
        .m_own_slot  (own_slot),
        .m_own_x     (own_x),
        .m_own_y     (own_y),
        .m_own_p     (own_p),
        .m_own_seq   (own_seq),
        .m_pass_valid(pass_valid),
        .m_pass_ready(1'b1),
        .m_pass_x    (pass_x),
        .m_pass_y    (pass_y),
        .m_pass_p    (pass_p),
        .m_pass_seq  (pass_seq),
        .idle        (idle)
    );

    // ---- signatures ------------------------------------------------------------------------------------------------

    // The fields, each in as many 32-bit pieces as it needs, one after another.
    wire [31:0] cm_word = {30'd0, cm_kind} ^ {{(24 - SLOT_W) {1'b0}}, cm_slot, 8'd0} ^ cm_id ^ turned(cm_other)
                        ^ {3'd0, cm_x, 16'd0} ^ {19'd0, cm_y} ^ {cm_radius, 23'd0} ^ {9'd0, cm_n_ev, 13'd0}
                        ^ {cm_support, 16'd0} ^ cm_seq[31:0] ^ {cm_seq[47:32], 16'd0} ^ turned(cm_time[31:0])
                        ^ {16'd0, cm_time[47:32]};
    wire [31:0] own_word = {{(32 - SLOT_W) {1'b0}}, own_slot} ^ {14'd0, own_x, 8'd0} ^ {4'd0, own_y, 18'd0} ^ {own_p, 31'd0}
                         ^ own_seq[31:0] ^ {own_seq[47:32], 16'd0};
    wire [31:0] pass_word = {23'd0, pass_x} ^ {12'd0, pass_y, 11'd0} ^ {pass_p, 31'd0} ^ pass_seq[31:0]
                          ^ {pass_seq[47:32], 16'd0};

    function [31:0] turned;
        input [31:0] word_in;
        turned = {word_in[30:0], word_in[31]};
    endfunction

    reg [5:0] quiet;
    wire      busy = !configured || offered || n_events != EVENTS || !idle || cm_valid || own_valid || pass_valid;

    assign passed = done && cm_signature == CM_EXPECTED && own_signature == OWN_EXPECTED && pass_signature == PASS_EXPECTED;

    always @(posedge clk) begin
        if (cm_valid) n_records <= n_records + 32'd1;
        if (cm_valid) cm_signature <= turned(cm_signature) ^ cm_word;
        if (own_valid) own_signature <= turned(own_signature) ^ own_word;
        if (pass_valid) pass_signature <= turned(pass_signature) ^ pass_word;
        quiet <= busy ? 6'd0 : quiet + {5'd0, quiet != QUIET};
        if (quiet == QUIET) done <= 1'b1;
        if (rst) begin
            n_records      <= 32'd0;
            cm_signature   <= 32'd0;
            own_signature  <= 32'd0;
            pass_signature <= 32'd0;
            quiet          <= 6'd0;
            done           <= 1'b0;
        end
    end

endmodule

`default_nettype wire
