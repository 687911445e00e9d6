# SPDX-License-Identifier: Apache-2.0
"""Area and speed of the RTL on FPGAs; netlists, releases and descriptions generated from the RTL."""
