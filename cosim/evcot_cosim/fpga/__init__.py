# SPDX-License-Identifier: Apache-2.0
"""Cost and speed of the RTL on FPGAs; netlists, releases and descriptions made from the RTL."""

__all__ = ["RECORDS"]

RECORDS = 256  # of a board that its signature is made of
