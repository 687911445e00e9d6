# SPDX-License-Identifier: Apache-2.0
"""The colours of heat maps are those of Matplotlib."""

from __future__ import annotations

import matplotlib
import numpy as np

from evcot_cosim.report.cividis import CIVIDIS


def test_it_is_matplotlibs_table() -> None:
    colours = matplotlib.colormaps["cividis"](np.arange(256))[:, :3]
    assert (colours * 255).astype(np.uint8).tobytes() == CIVIDIS
