// SPDX-License-Identifier: Apache-2.0
// Which slots have a deadline, for the properties of the modules above.
wire [N-1:0] f_timed;
genvar f_i;
generate
    for (f_i = 0; f_i < N; f_i = f_i + 1) begin : g_timed
        assign f_timed[f_i] = timed[f_i];
    end
endgenerate
