// SPDX-License-Identifier: Apache-2.0
// One token of the memory, for the properties of the modules above: they drive the address.
wire [3:0] f_address;
wire [CLOCK_W+TOKEN_W-1:0] f_content = {time_mem[f_address], token_mem[f_address]};
reg  [4:0] f_head;  // which token `head` is
always @(posedge clk) if (fetch) f_head <= issued;
