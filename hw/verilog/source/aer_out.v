// SPDX-License-Identifier: Apache-2.0
// Tagged address events to a chip: 4-phase request and acknowledge, the acknowledge asynchronous to the clock.
//
// A word is {kind, slot, y, x, p}. It is driven SETUP clocks before the request and until the next word, thus beyond the
// acknowledge. The request is de-asserted after the acknowledge, and the next word waits until the acknowledge is de-asserted.
//
// Latency:    SETUP + 1 clocks from s_ to the request.
// Throughput: with a receiver that answers at once, a word in SETUP + 2 * SYNC + 3 clocks, occasionally one more.
// Stall:      a receiver that does not acknowledge, or does not de-assert its acknowledge, holds s_ready low.
// Reset:      no request; s_ready rises once the acknowledge is de-asserted.
// Combinational paths: active_low -> aer_req.
`default_nettype none

module aer_out #(
    parameter X_W    = 9,  // bits of an x address
    parameter Y_W    = 9,  // bits of a y address
    parameter SLOT_W = 3,  // bits of a slot number
    parameter SETUP  = 1,  // clocks from a word to its request, 1..255
    parameter SYNC   = 2,  // stages of the synchronizer, 2..4
    parameter AER_W  = 2 + SLOT_W + Y_W + X_W + 1  // derived: leave it alone
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              active_low,  // aer_req and aer_ack; change it under reset alone

    // events in
    input  wire              s_valid,
    output wire              s_ready,
    input  wire [1:0]        s_kind,      // 0: passed event, 1: owned event, 2: centre of mass, 3: free
    input  wire [SLOT_W-1:0] s_slot,
    input  wire [X_W-1:0]    s_x,
    input  wire [Y_W-1:0]    s_y,
    input  wire              s_p,

    // the chip
    output wire              aer_req,
    input  wire              aer_ack,
    output reg  [AER_W-1:0]  aer_data,

    output wire              idle         // nothing inside
);

    parameter_check #(.OK(X_W >= 1)) X_W_must_be_at_least_1 ();
    parameter_check #(.OK(Y_W >= 1)) Y_W_must_be_at_least_1 ();
    parameter_check #(.OK(SLOT_W >= 1)) SLOT_W_must_be_at_least_1 ();
    parameter_check #(.OK(SETUP >= 1 && SETUP <= 255)) SETUP_must_be_1_to_255 ();
    parameter_check #(.OK(AER_W == 2 + SLOT_W + Y_W + X_W + 1)) AER_W_must_be_left_at_its_default ();

    localparam [1:0] READY   = 2'd0;  // waiting for a word
    localparam [1:0] SETTLE  = 2'd1;  // the word stands, no request yet
    localparam [1:0] REQUEST = 2'd2;  // waiting for the acknowledge
    localparam [1:0] RETURN  = 2'd3;  // waiting for the acknowledge to go

    localparam [31:0] LAST_SETTLED = SETUP - 1;

    reg [1:0]      state;
    reg [7:0]      settled;
    reg            request;
    reg [SYNC-1:0] synced;  // the highest: the synchronizer has forgotten the reset
    wire           level;
    wire           acknowledge = !synced[SYNC-1] || (level ^ active_low);

    synchronizer #(
        .STAGES(SYNC),
        .RESET (0)
    ) u_acknowledge (
        .clk(clk),
        .rst(rst),
        .d  (aer_ack),
        .q  (level)
    );

    always @(posedge clk) synced <= rst ? {SYNC{1'b0}} : {synced[SYNC-2:0], 1'b1};

    assign aer_req = request ^ active_low;
    assign s_ready = state == READY;
    assign idle    = s_ready;

    always @(posedge clk) begin
        case (state)
            READY:
            if (s_valid) begin
                aer_data <= {s_kind, s_slot, s_y, s_x, s_p};
                settled  <= 8'd0;
                state    <= SETTLE;
            end
            SETTLE: begin
                settled <= settled + 8'd1;
                if (settled == LAST_SETTLED[7:0]) begin
                    request <= 1'b1;
                    state   <= REQUEST;
                end
            end
            REQUEST:
            if (acknowledge) begin
                request <= 1'b0;
                state   <= RETURN;
            end
            RETURN:  if (!acknowledge) state <= READY;
            default: state <= RETURN;
        endcase
        if (rst) begin
            request <= 1'b0;
            state   <= RETURN;
        end
    end

endmodule

`default_nettype wire
