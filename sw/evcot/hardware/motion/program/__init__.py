# SPDX-License-Identifier: Apache-2.0
"""The program of the array with motion in RTL: what motion_engine.v does to a slot, instruction by instruction."""
