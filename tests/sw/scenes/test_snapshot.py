# SPDX-License-Identifier: Apache-2.0
"""A snapshot shows each pixel in the colour of its last event, recordings side by side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from evcot.events import Events, Recording
from evcot.recordings.files import write_recording
from evcot.scenes.snapshot import main, snapshot

RED, BLUE, WHITE = (200, 60, 0), (0, 90, 180), (255, 255, 255)


def recording() -> Recording:
    rows = np.array([(0, 1, 1, 1), (5_000, 2, 1, 0), (6_000, 1, 1, 0), (7_000, 3, 2, 0), (7_000, 3, 2, 1), (90_000, 0, 0, 1)])
    t_us, x, y, p = rows.T
    return Recording(Events(t_us, x.astype(np.uint16), y.astype(np.uint16), p.astype(np.uint8)), 6, 4)


def test_the_last_event_of_a_pixel_colours_it() -> None:
    picture = snapshot(recording())
    assert picture.shape == (4, 6, 3)
    found = {(x, y): tuple(picture[y, x].tolist()) for y in range(4) for x in range(6)}
    coloured = {place: colour for place, colour in found.items() if colour != WHITE}
    assert coloured == {(1, 1): BLUE, (2, 1): BLUE, (3, 2): RED, (0, 0): RED}


def test_four_recordings_stand_in_two_rows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, picture = tmp_path / "r.npz", tmp_path / "r.png"
    write_recording(recording(), path)
    assert main([*[str(path)] * 4, "-o", str(picture), "--at", "0"]) == 0
    with Image.open(picture) as image:
        assert image.size == (3 * 6 + 2 * 4, 2 * 4 + 4)
        pixels = image.convert("RGB")
        assert pixels.getpixel((3, 2)) == pixels.getpixel((10 + 3, 8 + 2 - 8)) == RED
        assert pixels.getpixel((0, 0)) == WHITE
    assert main([str(tmp_path / "none.npz"), "-o", str(picture)]) == 2
    assert capsys.readouterr().err.startswith("snapshot: ")
    assert main([str(path), "-o", str(tmp_path / "no" / "r.png"), "--at", "0"]) == 2
