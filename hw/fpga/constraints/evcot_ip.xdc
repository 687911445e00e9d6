# SPDX-License-Identifier: Apache-2.0
# Timing inside the IP of evcot_top for Vivado, which applies it to each instance: the AER pins alone. The clock is constrained by
# the design around it. Without AER (SOURCES) nothing matches, which is no error.

# Only the first stage of the synchroniser sees the request.
set_false_path -to [get_pins -quiet -hierarchical -filter {NAME =~ */u_request/stages_reg[0]/D}]

# The word is stable from the request on and is sampled two clocks or more after it: 5 ns are less than a clock of any device.
set_max_delay -quiet -datapath_only -from [get_ports -quiet {aer_row aer_data[*]}] 5.000

# The acknowledge is part of an asynchronous handshake.
set_false_path -quiet -to [get_ports -quiet aer_ack]
