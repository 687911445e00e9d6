# SPDX-License-Identifier: Apache-2.0
"""One module per family of event file; `evcot.recordings.files.open_recording` and `write_events` are the way in.

Each module has `FORMATS`, the kinds it reads, and may have `WRITABLE`, the kinds it writes. Each kind is tried in this order
on a file's first bytes. What a reader finds wrong it raises as a RecordingError that leaves the file's name out:
`evcot.recordings.files` puts it in front.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._lazy import lazily

if TYPE_CHECKING:
    from .registry import FORMATS, WRITABLE

__all__ = ["FORMATS", "WRITABLE", "WRITABLE_NAMES"]

WRITABLE_NAMES = ("npz", "csv", "evt3", "evt2", "aedat4")  # the keys of WRITABLE, for whoever need not import a writer

__getattr__, __dir__ = lazily(__name__, {"registry": ("FORMATS", "WRITABLE")})
