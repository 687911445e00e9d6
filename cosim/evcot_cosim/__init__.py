# SPDX-License-Identifier: Apache-2.0
"""Compiles the evcot RTL, drives it in lock-step with the golden model, and shows where hardware and software agree."""
