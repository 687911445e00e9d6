# SPDX-License-Identifier: Apache-2.0
"""A baseline: mean shift clustering of events in packets, by the paper's equations 1 and 2."""
