// SPDX-License-Identifier: Apache-2.0
// Constants of the line transform: bits of a period, and cosines of a quarter turn.
// Generated from sw/evcot/hough/contract.py by `python -m evcot.hardware.generate`: edit there.
// For the inside of a module, so it carries no include guard.
localparam STAMP_W = 9;  // bits of a period in a cell's word
// 256 cos(j * pi / 32), rounded, 9 bits each; j = 0 in the lowest bits
localparam [9*17-1:0] COSINES = {
    9'd0,
    9'd25,
    9'd50,
    9'd74,
    9'd98,
    9'd121,
    9'd142,
    9'd162,
    9'd181,
    9'd198,
    9'd213,
    9'd226,
    9'd237,
    9'd245,
    9'd251,
    9'd255,
    9'd256
};
