# SPDX-License-Identifier: Apache-2.0
"""Open the recordings that a command takes."""

from __future__ import annotations

import argparse
from pathlib import Path

from evcot.recordings.files import Damage, RecordingFile, open_recording

from ...standard_streams import as_file
from ..options import sensor_from

__all__ = ["open_from"]


def open_from(options: argparse.Namespace, path: Path) -> RecordingFile:
    """Open a recording as the options say.

    Raises:
        ConfigError: --sensor that is no size.
        RecordingError: as `open_recording`.
    """
    damage: Damage = "skip" if options.skip_damaged else "refuse"
    return open_recording(as_file(path), sensor_from(options), damage=damage, struct=options.struct)
