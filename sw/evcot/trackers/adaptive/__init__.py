# SPDX-License-Identifier: Apache-2.0
"""Tracker of extended objects whose settings have no units: scales of length and time are read off the stream."""
