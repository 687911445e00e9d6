# SPDX-License-Identifier: Apache-2.0
# async_fifo.v in Vivado, for each instance: read_xdc -ref async_fifo async_fifo.xdc. The clocks are constrained elsewhere.

set s_period [get_property -min PERIOD [get_clocks -of_objects [get_ports s_clk]]]
set m_period [get_property -min PERIOD [get_clocks -of_objects [get_ports m_clk]]]

# A pointer in Gray code: all bits arrive within a period of the clock that sends them, so that no two changes are seen as one.
set_max_delay -datapath_only -from [get_cells {write_gray_reg[*]}] -to [get_cells {g_pointers[*].u_write/stages_reg[0]}] $s_period
set_max_delay -datapath_only -from [get_cells {read_gray_reg[*]}] -to [get_cells {g_pointers[*].u_read/stages_reg[0]}] $m_period

# A word is stable for two clocks of m_clk when it is read. No effect on block RAM.
set_max_delay -datapath_only -from [get_clocks -of_objects [get_ports s_clk]] -to [get_cells {data_reg_reg[*]}] $m_period
