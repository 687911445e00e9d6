# SPDX-License-Identifier: Apache-2.0
# Timing of evcot_top in Quartus, Radiant, Diamond and other readers of SDC, its ports as pins of the device. Set the period of your
# clock, twice. As a part of a larger design: the clock is there already, and the AER ports are pins with names of yours. Without AER
# (SOURCES) nothing is needed but the clock.

create_clock -name clk -period 8.000 [get_ports {clk}]

# AER: the chip has no clock in common. Only the first stage of a synchroniser sees the request.
set_false_path -from [get_ports {aer_req}]

# The word is stable from the request on and is read two clocks or more after it: one period is the delay that it may have.
set_max_delay -from [get_ports {aer_row}] 8.000
set_max_delay -from [get_ports {aer_data*}] 8.000

# The acknowledge is awaited by a handshake.
set_false_path -to [get_ports {aer_ack}]
