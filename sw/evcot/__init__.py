# SPDX-License-Identifier: Apache-2.0
"""evcot: event-camera object tracking in software, and the golden model of the tracker in hardware."""

__version__ = "0.1.0"
