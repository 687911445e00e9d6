# SPDX-License-Identifier: Apache-2.0
"""A tracker of extended objects: a Kalman filter on the sides of each object's box, events shared out by probability."""
