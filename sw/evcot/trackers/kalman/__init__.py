# SPDX-License-Identifier: Apache-2.0
"""Tracker of extended objects: a Kalman filter on the sides of each object's box, probabilistic assignment of events."""
