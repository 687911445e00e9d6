// SPDX-License-Identifier: Apache-2.0
// The bounds of all windows, for the properties of the modules above.
wire [N*X_W-1:0] f_lo_x_not, f_hi_x;
wire [N*Y_W-1:0] f_lo_y_not, f_hi_y;
genvar f_i;
generate
    for (f_i = 0; f_i < N; f_i = f_i + 1) begin : g_bounds
        assign f_lo_x_not[X_W*f_i+:X_W] = lo_x_not[f_i];
        assign f_hi_x[X_W*f_i+:X_W]     = hi_x[f_i];
        assign f_lo_y_not[Y_W*f_i+:Y_W] = lo_y_not[f_i];
        assign f_hi_y[Y_W*f_i+:Y_W]     = hi_y[f_i];
    end
endgenerate
