# SPDX-License-Identifier: Apache-2.0
"""Every kind of event file that evcot writes."""

from __future__ import annotations

from . import aedat4_sink, numpy_files, prophesee, text
from .source import WritableFormat

__all__ = ["WRITABLE"]

WRITABLE: dict[str, WritableFormat] = {
    kind.name: kind for kind in (*numpy_files.WRITABLE, *text.WRITABLE, *prophesee.WRITABLE, *aedat4_sink.WRITABLE)
}
