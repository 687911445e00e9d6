# SPDX-License-Identifier: Apache-2.0
"""What the RTL costs on an FPGA and how fast it is there; netlists, releases and descriptions made from the RTL."""
