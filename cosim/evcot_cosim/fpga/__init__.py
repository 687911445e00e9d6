# SPDX-License-Identifier: Apache-2.0
"""What the RTL costs on an FPGA and how fast it is there; netlists, releases and descriptions made from the RTL."""

__all__ = ["RECORDS"]

RECORDS = 256  # of a board that its signature is made of
