# SPDX-License-Identifier: Apache-2.0
"""Every kind of event file that evcot reads, in the order in which they are tried, and every kind that it writes."""

from __future__ import annotations

from . import aedat2, aedat3, aedat4, aedat4_sink, es, hdf5, matlab, nmnist, npz_sink, numpy_files, prophesee, ros, text
from .source import Format, WritableFormat

__all__ = ["FORMATS", "WRITABLE"]

FORMATS: tuple[Format, ...] = (
    *aedat4.FORMATS,
    *aedat3.FORMATS,
    *aedat2.FORMATS,
    *es.FORMATS,
    *matlab.FORMATS,  # before HDF5, which its version 7.3 is
    *hdf5.FORMATS,
    *numpy_files.FORMATS,
    *prophesee.FORMATS,
    *ros.FORMATS,
    *nmnist.FORMATS,
    *text.FORMATS,  # last: almost anything printable looks like text
)

WRITABLE: dict[str, WritableFormat] = {
    kind.name: kind for kind in (*npz_sink.WRITABLE, *text.WRITABLE, *prophesee.WRITABLE, *aedat4_sink.WRITABLE)
}
