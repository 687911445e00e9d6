# SPDX-License-Identifier: Apache-2.0
"""Sizes of the cameras that iniVation's older files name, and addresses whose origin is not at the top left."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .source import Sensor

__all__ = ["chip_sensor", "mirrored"]


# Prefix of a chip's name, in lower case and without its Java package -> (width, height). From jAER and libcaer.
_SENSORS: dict[str, Sensor] = {
    "dvs128": (128, 128),
    "tmpdiff128": (128, 128),  # early name of the DVS128
    "davis128": (128, 128),
    "davis208": (208, 192),
    "davis240": (240, 180),
    "sbret": (240, 180),  # of the DAVIS240
    "davis346": (346, 260),
    "davis640": (640, 480),
}


def chip_sensor(name: str) -> Sensor | None:
    """(width, height) of a chip such as "DAVIS240C" or "eu.seebetter.ini.chips.davis.Davis346blue"; None if unknown."""
    bare = re.sub(r".*\.|[\s_-]", "", name).lower()
    return next((sensor for start, sensor in _SENSORS.items() if bare.startswith(start)), None)


def mirrored(address: NDArray[Any], size: int) -> NDArray[np.uint16]:
    """Mirror (n,) addresses; one beyond `size` is returned unchanged, and refused by the later validation."""
    return np.where(address < size, size - 1 - address, address).astype(np.uint16)
