# SPDX-License-Identifier: Apache-2.0
"""One module per family of event file formats; the entry points are `open_recording` and `write_events` in `..files`.

Each module has `FORMATS`, the formats it reads, and may have `WRITABLE`, the formats it writes. Formats are tried in this
order on a file's first bytes. A reader reports damage as a RecordingError without the file's name: `evcot.recordings.files`
prefixes it.
"""

from __future__ import annotations

from . import aedat2, aedat3, aedat4, aedat4_sink, es, hdf5, matlab, npz_sink, numpy_files, prophesee, ros, text
from .source import Format, WritableFormat

__all__ = ["FORMATS", "WRITABLE"]

FORMATS: tuple[Format, ...] = (
    *aedat4.FORMATS,
    *aedat3.FORMATS,
    *aedat2.FORMATS,
    *es.FORMATS,
    *matlab.FORMATS,  # before HDF5: MATLAB version 7.3 is HDF5, too
    *hdf5.FORMATS,
    *numpy_files.FORMATS,
    *prophesee.FORMATS,
    *ros.FORMATS,
    *text.FORMATS,  # last: almost anything printable looks like text
)

WRITABLE: dict[str, WritableFormat] = {
    kind.name: kind for kind in (*npz_sink.WRITABLE, *text.WRITABLE, *prophesee.WRITABLE, *aedat4_sink.WRITABLE)
}
