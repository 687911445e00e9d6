# SPDX-License-Identifier: Apache-2.0
"""Figures for publications: content, size, and reproducible files."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.pictures.plots import Log, Material, density, figure_of, plot
from evcot.pictures.style import KINDS
from evcot.tracks.log import TRACK, Kind, TrackLog
from support.logs import verdicts_of

SENSOR = (64, 40)


def log(shift_px: float = 0) -> TrackLog:
    """Two tracks that cross: 3 from left to right, 5 from the right until it merges into 3 at 2.5 s; 9 begins after 4 s."""
    rows = []
    for step in range(30):
        t_us = 1_000_000 + 100_000 * step
        kind = Kind.BORN if step == 0 else Kind.MOVED
        rows.append((t_us, step, kind, 3, 0, 5 + 1.5 * step + shift_px, 20, -1))
        if step <= 15:
            end = step == 15
            rows.append((t_us, step, Kind.MERGED if end else kind, 5, 1, 55 - 1.5 * step, 25, 3 if end else -1))
    rows.append((4_500_000, 99, Kind.BORN, 9, 1, 30, 30, -1))
    records = np.zeros(len(rows), TRACK)
    for name, column in zip(
        ("t_us", "event_index", "kind", "track_id", "slot", "x", "y", "other_id"), zip(*rows, strict=True), strict=True
    ):
        records[name] = column
    records["radius"], records["width"], records["height"] = 4, 9, 7
    return TrackLog("rct", records, np.zeros(100, np.int16))


def some_events(n: int = 3_000) -> Events:
    random = np.random.default_rng(1)
    t_us = np.sort(random.integers(1_000_000, 4_000_000, n))
    x, y = (random.integers(side, size=n).astype(np.uint16) for side in SENSOR)
    return Events(t_us, x, y, np.zeros(n, np.uint8))


def material(*logs: TrackLog, from_us: int = 1_000_000, to_us: int = 4_000_000) -> Material:
    counts, _, _ = density([some_events()], SENSOR)
    named = tuple(Log(f"log {i}", each) for i, each in enumerate(logs or (log(),)))
    return Material(counts, named, from_us, to_us, 1_000_000)


def test_density_counts_events_by_pixel_however_they_are_cut() -> None:
    some = some_events()
    counts, first_us, last_us = density([some[:0], some[:10], some[10:]], SENSOR)
    assert counts.shape == (40, 64)
    assert counts.sum() == 3_000
    assert counts[some.y[0], some.x[0]] == np.count_nonzero((some.x == some.x[0]) & (some.y == some.y[0]))
    assert (first_us, last_us) == (some.t_us[0], some.t_us[-1])
    assert density([], SENSOR)[1:] == (0, 0)


def test_the_window_decides_which_tracks_there_are() -> None:
    whole, late = material(), material(from_us=3_000_000)
    assert whole.lives(whole.logs[0])["track_id"].tolist() == [3, 5]
    assert late.lives(late.logs[0])["track_id"].tolist() == [3]
    paths = late.paths(late.logs[0])
    assert list(paths) == [3]
    assert paths[3]["x"][0] == 35.0, "where it stood when the window began"
    assert whole.alive(whole.logs[0])[[0, -1]].tolist() == [2, 1]
    assert whole.axis.unit == "s"
    assert material(to_us=1_500_000).axis.unit == "ms"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_every_kind_has_the_same_bytes_each_time_and_no_date(tmp_path: Path, kind: str, suffix: str) -> None:
    for name in ("a", "b"):
        plot(material(log(), log(2.0)), tmp_path / f"{name}{suffix}", (kind,), width_mm=85)
    data = (tmp_path / f"a{suffix}").read_bytes()
    assert data == (tmp_path / f"b{suffix}").read_bytes()
    assert len(data) > 3_000
    for stamp in (b"CreationDate", b"dc:date", b"Software", b"Matplotlib v", b"Producer"):
        assert stamp not in data


def test_sizes_are_millimetres(tmp_path: Path) -> None:
    plot(material(), tmp_path / "a.png", ("alive", "xy"), width_mm=85, height_mm=60, dpi=254)
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (850, 600)
    plot(material(), tmp_path / "a.pdf", ("tracks",), width_mm=178, height_mm=100)
    box = re.search(rb"/MediaBox \[ ?0 0 ([0-9.]+) ([0-9.]+) ?\]", (tmp_path / "a.pdf").read_bytes())
    assert box is not None
    assert [float(side) / 72 * 25.4 for side in box.groups()] == pytest.approx([178, 100], abs=0.01)


def test_fonts_are_embedded(tmp_path: Path) -> None:
    plot(material(), tmp_path / "a.pdf", ("alive",))
    data = (tmp_path / "a.pdf").read_bytes()
    assert b"/FontFile2" in data
    assert b"/Type3" not in data
    assert b"/Type1" not in data
    plot(material(), tmp_path / "a.svg", ("alive",))
    text = (tmp_path / "a.svg").read_text()
    assert "font-family" not in text.split("<defs>", 1)[1]
    assert '<use xlink:href="#DejaVuSans-' in text, "letters are outlines"


def test_a_track_is_drawn_where_it_was(tmp_path: Path) -> None:
    plot(material(), tmp_path / "with.png", ("tracks",), width_mm=100, dpi=100)
    plot(material(TrackLog.empty("rct")), tmp_path / "without.png", ("tracks",), width_mm=100, dpi=100)
    with Image.open(tmp_path / "with.png") as one, Image.open(tmp_path / "without.png") as other:
        changed = np.abs(np.asarray(one.convert("RGB"), int) - np.asarray(other.convert("RGB"), int)).max(axis=2) > 40
        inked = np.asarray(one.convert("L")) < 250
    rows, columns = np.nonzero(changed)
    frame_rows, frame_columns = np.nonzero(inked)
    height, width = np.ptp(frame_rows), np.ptp(frame_columns)
    assert np.ptp(columns) / width == pytest.approx(45 / 64, abs=0.12)
    assert np.ptp(rows) / height < 0.3


def test_a_track_is_labelled_by_its_class_at_the_end_of_the_window() -> None:
    classified = replace(log(), verdicts=verdicts_of((1_500_000, 3, 2), (3_500_000, 3, -1)), class_names={2: "cup"})
    for to_us, label in ((4_000_000, "3 ?"), (3_000_000, "3 cup"), (1_400_000, "3")):
        texts = figure_of(material(classified, to_us=to_us)).axes[0].texts
        assert [text.get_text() for text in texts] == [label, "5"]


def test_logs_of_nothing_make_figures_too(tmp_path: Path) -> None:
    nothing = Material(np.zeros((4, 6), np.int64), (Log("a", TrackLog.empty("rct")),), 5, 5, 5)
    plot(nothing, tmp_path / "a.png", KINDS)
    assert (tmp_path / "a.png").stat().st_size > 1_000


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kinds": ("paths",)}, "--kind paths: must be one or more of tracks, xy, alive, lifetimes"),
        ({"kinds": ()}, "--kind : must be one or more of tracks, xy, alive, lifetimes"),
        ({"width_mm": 5.0}, "--width 5: must be from 20 to 1000"),
        ({"height_mm": float("inf")}, "--height inf: must be from 20 to 1000"),
        ({"dpi": 9_999.0}, "--dpi 9999: must be from 50 to 1200"),
        ({"path": "a.jpg"}, "a.jpg: must end in .png, .pdf, .svg"),
    ],
)
def test_what_cannot_be_drawn_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: dict[str, object], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError, match=f"^{re.escape(message)}$"):
        plot(material(), **({"path": "a.png"} | changes))  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
