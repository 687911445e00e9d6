# SPDX-License-Identifier: Apache-2.0
# 125 MHz, the clock that the example asks for.
create_clock -name aclk -period 8.000 [get_ports aclk]
