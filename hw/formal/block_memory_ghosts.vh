// SPDX-License-Identifier: Apache-2.0
// One word of the memory, for the properties of the modules above: they drive the address.
wire [ADDR_W-1:0] f_address;
wire [W-1:0] f_content = memory[f_address];
