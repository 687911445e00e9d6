# SPDX-License-Identifier: Apache-2.0
"""What a task needs, in memory once this module is imported: evcot, and Numba with its tables of types, which it fills at the
first call of any kernel, in half a second.

None of that becomes garbage, so it is no longer searched for any: that took a third of the time in which a truth is read.
"""

from __future__ import annotations

import gc
from contextlib import suppress

import numpy as np

from evcot.recordings.formats.numeric import microseconds

from . import execute

__all__ = ["execute"]

with suppress(Exception):  # a task meets it again, and its row says so
    microseconds(np.zeros(1))
gc.freeze()
