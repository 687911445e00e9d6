# SPDX-License-Identifier: Apache-2.0
"""One module per family of event file formats; the entry points are `open_recording` and `write_events` in `..files`.

Each module has `FORMATS`, the formats it reads, and may have `WRITABLE`, the formats it writes. Formats are tried in this
order on a file's first bytes. A reader reports damage as a RecordingError without the file's name: `evcot.recordings.files`
prefixes it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._lazy import lazily

if TYPE_CHECKING:
    from .registry import format_of, formats
    from .writable import WRITABLE

__all__ = ["WRITABLE", "WRITABLE_NAMES", "format_of", "formats"]

WRITABLE_NAMES = ("npz", "csv", "evt3", "evt2", "aedat4")  # the keys of WRITABLE, for whoever need not import a writer

__getattr__, __dir__ = lazily(__name__, {"registry": ("format_of", "formats"), "writable": ("WRITABLE",)})
