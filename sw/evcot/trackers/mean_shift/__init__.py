# SPDX-License-Identifier: Apache-2.0
"""Mean shift clustering of events in packets, and of frames: the paper's equations 1 and 2."""
