# SPDX-License-Identifier: Apache-2.0
"""The Rectangular Cluster Tracker, the established software tracker, in floating-point arithmetic."""
