# SPDX-License-Identifier: Apache-2.0
"""Every kind of event file that evcot writes."""

from __future__ import annotations

from . import aedat4_sink, npz_sink, prophesee, text
from .source import WritableFormat

__all__ = ["WRITABLE"]

WRITABLE: dict[str, WritableFormat] = {
    kind.name: kind for kind in (*npz_sink.WRITABLE, *text.WRITABLE, *prophesee.WRITABLE, *aedat4_sink.WRITABLE)
}
