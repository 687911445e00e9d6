# SPDX-License-Identifier: Apache-2.0
"""The software tracker that the field knows: the Rectangular Cluster Tracker, in float arithmetic."""
