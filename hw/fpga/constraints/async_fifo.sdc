# SPDX-License-Identifier: Apache-2.0
# async_fifo.v in Quartus, Radiant, Diamond and other tools that read SDC. Replace u_fifo by the path of the instance, and 8.000 by the
# shorter period of the two clocks, which are constrained elsewhere.

# A pointer in Gray code: all bits arrive within a period, so that no two changes are seen as one.
set_max_delay -from [get_registers {*u_fifo*write_gray*}] -to [get_registers {*u_fifo*u_write*stages[0]}] 8.000
set_max_delay -from [get_registers {*u_fifo*read_gray*}] -to [get_registers {*u_fifo*u_read*stages[0]}] 8.000
set_min_delay -from [get_registers {*u_fifo*write_gray*}] -to [get_registers {*u_fifo*u_write*stages[0]}] -100.000
set_min_delay -from [get_registers {*u_fifo*read_gray*}] -to [get_registers {*u_fifo*u_read*stages[0]}] -100.000
