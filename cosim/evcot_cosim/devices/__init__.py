# SPDX-License-Identifier: Apache-2.0
"""Compiled RTL as Python objects, driven by streams of events or words, or interactively by ports and clocks."""
