# SPDX-License-Identifier: Apache-2.0
"""The module `zstd` of the standard library, which Python has from 3.14 on, or what stands in for it."""

from __future__ import annotations

import sys

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

__all__ = ["zstd"]
