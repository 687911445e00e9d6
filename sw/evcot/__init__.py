# SPDX-License-Identifier: Apache-2.0
"""evcot: event-camera object tracking in software, and the golden model of the tracker in hardware."""

from pathlib import Path as _Path

from ._stale_kernels import forget_stale_kernels as _forget_stale_kernels

__version__ = "0.1.0"

_forget_stale_kernels(_Path(__file__).parent)
