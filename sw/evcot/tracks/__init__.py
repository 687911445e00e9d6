# SPDX-License-Identifier: Apache-2.0
"""Tracker output: the TrackLog, the interface of a tracker, timelines, and comparison of two logs."""
