# SPDX-License-Identifier: Apache-2.0
"""Filters in front of a tracker, as golden models of those in hardware; docs/filters.md is the contract that both keep."""
