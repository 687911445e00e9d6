# SPDX-License-Identifier: Apache-2.0
"""Figures and pictures of a log in a notebook."""

from __future__ import annotations

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.tracks.log import Kind, TrackLog
from support.logs import log_of

LOG = log_of([(10, Kind.BORN, 0, 5.0, 6.0), (30, Kind.MOVED, 0, 40.0, 20.0), (90, Kind.LOST, 0, 40.0, 20.0)])


def test_without_a_recording_the_axes_hold_the_tracks() -> None:
    (axes,) = LOG.plot().axes
    assert axes.get_xlim() == (-0.5, 50.5)  # 40 + half the width of 20, one more for the pixel at 0
    assert axes.get_ylim() == (26.5, -0.5)
    path = axes.lines[-1].get_xydata()
    assert path[0].tolist() == [5.0, 6.0]
    assert path[-1].tolist() == [40.0, 20.0]


def test_a_recording_gives_events_and_the_size_of_the_sensor() -> None:
    events = Events(np.array([10, 20]), *np.array([[3, 3], [4, 4]], np.uint16), np.ones(2, np.uint8))
    recording = Recording(events, 64, 48)
    figure = LOG.plot(recording, ("tracks", "alive"))
    assert len(figure.axes) == 2
    assert figure.axes[0].get_xlim() == (-0.5, 63.5)
    grey = np.asarray(figure.axes[0].images[0].get_array())
    assert grey.shape == (48, 64)
    assert np.argwhere(grey < 1).tolist() == [[4, 3]]


def test_a_notebook_shows_a_figure_as_png() -> None:
    assert Image.open(io.BytesIO(LOG.plot()._repr_png_())).format == "PNG"  # type: ignore[attr-defined]


def test_a_recording_with_fewer_events_than_the_log_is_refused() -> None:
    log = TrackLog("rct", LOG.records, np.zeros(3, np.int16))
    with pytest.raises(ConfigError) as error:
        log.plot(Recording(Events.empty(), 64, 48, "drive"))
    assert str(error.value) == "plot: drive has 0 events: must be the recording of the log, of 3 events at least"


def test_a_panel_that_is_none_is_refused() -> None:
    with pytest.raises(ConfigError, match="tracks, xy, alive, lifetimes"):
        LOG.plot(panels=("track",))


@pytest.mark.parametrize("log", [LOG, TrackLog.empty("rct")], ids=["tracks", "no tracks"])
def test_a_notebook_shows_a_line_and_a_picture(log: TrackLog) -> None:
    shown = log._repr_html_()
    assert f"&lt;TrackLog {log.engine}: {len(log.tracks)} tracks" in shown
    (picture,) = re.findall(r'src="data:image/png;base64,([^"]+)"', shown)
    assert Image.open(io.BytesIO(base64.b64decode(picture))).width == 649


def test_a_track_far_outside_does_not_take_memory_without_end() -> None:
    far = log_of([(10, Kind.BORN, 0, 1e9, 6.0)])
    (axes,) = far.plot().axes
    assert (axes.get_xlim(), axes.get_ylim()) == ((-0.5, 4095.5), (1023.5, -0.5))
