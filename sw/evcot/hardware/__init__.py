# SPDX-License-Identifier: Apache-2.0
"""Shared by RTL, golden model and host: the contract, the register map, and bit-exact models of modules."""
