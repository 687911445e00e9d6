# SPDX-License-Identifier: Apache-2.0
# Timing of evcot_top for Vivado, with its ports as pins of the device. Set the period of your clock, in two places. In a larger design
# the clock is constrained already, and the AER pins have names of your own. Without AER (SOURCES) only the clock is needed.

create_clock -name clk -period 8.000 [get_ports clk]

# AER: the chip has no clock in common. Only the first stage of a synchroniser, marked ASYNC_REG (u_request/stages_reg), sees the
# request.
set_false_path -from [get_ports aer_req]

# The word is stable from the request on and is sampled two clocks or more after it: a delay of one period is allowed.
set_max_delay -datapath_only -from [get_ports aer_row] 8.000
set_max_delay -datapath_only -from [get_ports {aer_data[*]}] 8.000

# The acknowledge is part of an asynchronous handshake.
set_false_path -to [get_ports aer_ack]
