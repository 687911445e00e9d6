# SPDX-License-Identifier: Apache-2.0
# The asynchronous pins of davis_evcot.v, at 100 MHz. In SDC: the same without -datapath_only.

create_clock -name clk -period 10.000 [get_ports clk]

# Only the first flip-flop of the synchroniser, which is marked ASYNC_REG, sees the request.
set_false_path -from [get_ports davis_req_n]

# The word is stable from the request on and read two clocks or more after it: a clock for the way in is safe.
set_max_delay -datapath_only -from [get_ports {davis_data[*]}] 10.000

set_false_path -to [get_ports davis_ack_n]
