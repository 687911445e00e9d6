// SPDX-License-Identifier: Apache-2.0
// Included at the end of array_match.v under `ifdef FORMAL: which windows share a pixel, and which hold one, for cot_array_rules.vh.

genvar f_i, f_j;
generate
    for (f_i = 0; f_i < N; f_i = f_i + 1) begin : f_slot
        assign f_holds[f_i] = f_x >= ~lo_x_not[f_i] && f_x <= hi_x[f_i] && f_y >= ~lo_y_not[f_i] && f_y <= hi_y[f_i];
        for (f_j = 0; f_j < N; f_j = f_j + 1) begin : f_pair
            assign f_shared[N*f_i+f_j] = f_i != f_j && active[f_i] && active[f_j]
                && ~lo_x_not[f_i] <= hi_x[f_j] && ~lo_x_not[f_j] <= hi_x[f_i]
                && ~lo_y_not[f_i] <= hi_y[f_j] && ~lo_y_not[f_j] <= hi_y[f_i];
        end
        always @* if (!rst) assert (free[f_i] + candidate[f_i] + active[f_i] <= 1);
    end
endgenerate
