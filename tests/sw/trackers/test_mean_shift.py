# SPDX-License-Identifier: Apache-2.0
"""Mean shift on packets of events: convergence, and the tracker."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.metrics import evaluate, load_rule, read_truth
from evcot.recordings.files import read_recording
from evcot.trackers.mean_shift.kernel import converge
from evcot.trackers.mean_shift.tracker import PRESETS, MeanShiftConfig, MeanShiftTracker, cluster, event_points, fuse
from evcot.tracks.tracking import track_recording
from shared import SHARED


def test_an_event_is_its_place_its_polarity_and_its_age() -> None:
    x, y, p = np.array([7, 7, 1], np.uint16), np.array([9, 9, 2], np.uint16), np.array([1, 0, 1], np.uint8)
    events = Events(np.array([5_000, 15_000, 25_000]), x, y, p).read_only()
    points, after_us = event_points(events.t_us, events.x, events.y, events.p)
    np.testing.assert_allclose(points, [[7, 7, 1], [9, 9, 2], [2, 0, 2], [2 * np.exp(-2), 2 * np.exp(-1), 2]], rtol=1e-15)
    assert after_us.tolist() == [0, 10_000, 20_000]


@pytest.mark.parametrize(
    ("packet_events", "t_us", "ends"),
    [
        (3, [0, 1, 2, 3, 4, 5, 6], [3, 6]),
        # The second packet counts its time from its own first event.
        (3, [0, 19_999, 20_000, 39_999, 40_000, 40_001, 40_002], [2, 4, 7]),
        (2, [7, 7, 7, 7, 8], [2, 4]),
    ],
)
def test_a_packet_ends_after_its_events_or_its_time(packet_events: int, t_us: list[int], ends: list[int]) -> None:
    tracker = MeanShiftTracker(MeanShiftConfig(packet_events=packet_events))
    assert tracker.frame_ends(np.array(t_us)).tolist() == ends


def test_the_mode_of_the_most_points_absorbs_modes_near_it() -> None:
    """In a chain of modes 4 apart the middle one takes both neighbours, and not theirs."""
    modes = np.array([[0.0, 4, 8, 12, 16], [0, 0, 0, 0, 0], [9, 0, 9, 0, 9], [0, 9, 0, 9, 0]])
    member, n = fuse(np.array([0, 1, 2, 2, 2, 3, 4, 4]), modes, 5.0)
    assert n == 3
    assert member.tolist() == [2, 0, 0, 0, 0, 0, 1, 1]


def test_a_cluster_has_the_middle_sides_and_time_of_its_points() -> None:
    """A twentieth of the points lies beyond each side; clusters with few points are discarded."""
    points = np.zeros((4, 22))
    points[0], points[1] = [*range(10, 30), 200, 202], 20
    found, _, _ = cluster(points, np.arange(22.0), 20.0, 0.0, 3)
    names = ["x", "y", "width", "height", "after_us", "n"]
    assert found[names].tolist() == [(19.5, 20.0, 18.0, 1.0, 9.5, 20)]
    np.testing.assert_allclose(found["radius"], 1.5 * np.std(points[0, :20]) / np.sqrt(2))


def test_extreme_packets() -> None:
    """All events on one pixel, in the sensor's far corner, at one instant; far apart; alone."""
    n = 2_000
    corner = np.full(n, 65_535, np.uint16)
    at_once = Events(np.zeros(n, np.int64), corner, corner, np.ones(n, np.uint8))
    ends = corner * (np.arange(n, dtype=np.uint16) % 2)
    apart = Events(np.arange(n, dtype=np.int64) * 10**12, ends, corner, np.zeros(n, np.uint8))
    for events in (at_once, apart, at_once[:1]):
        _, owner = MeanShiftTracker(PRESETS["discs"]).feed(events)
        assert len(owner) == len(events)


def test_hota_on_the_first_half_of_the_recorded_traffic() -> None:
    """The half on which the preset was tuned."""
    path = SHARED / "traffic_outbound.aedat4"
    if not path.is_file():
        pytest.skip(f"no {path}")
    recording = read_recording(path, to_us=2_000_000)
    filters = FilterConfig(hot_pixels=learn_hot_pixels(recording.events, (346, 260)))
    kept: Recording = apply(recording, filters)[0]
    rule = load_rule("traffic")
    truth = read_truth(SHARED / "traffic_outbound_gt.csv", rule)
    half = truth.instants_us <= recording.events.t_us[-1]
    first = replace(truth, instants_us=truth.instants_us[half], objects=truth.objects[half[truth.objects["frame"]]])
    log = track_recording("mean-shift", MeanShiftTracker(PRESETS["traffic"]), kept)
    assert evaluate(log, first, rule).hota > 0.7


Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def equations(points: Floats, bandwidth_px: float, fold_px: float) -> tuple[Floats, int]:
    """All pairs, all points at once: where the points end, and how many shifts it took."""
    n = points.shape[1]
    z, weight, moving, ends = points.copy(), np.ones(n), np.ones(n, bool), np.arange(n)
    if fold_px:
        z, weight, moving, ends = together(z, weight, moving, fold_px)
    original, mass, now = z[:2].copy(), weight, np.arange(z.shape[1])
    shifts = iterations = 0
    while moving.any() and iterations < 50:
        iterations += 1
        shifts += int(moving.sum())
        others = np.concatenate((original, z[2:, now]))
        d2 = ((z[:, :, None] - others[:, None, :]) ** 2).sum(0)
        w = mass * np.exp(-d2 / (2 * bandwidth_px**2)) * (d2 <= (3 * bandwidth_px) ** 2)
        total = w.sum(1)
        there = (w @ others.T).T / np.where(total > 0, total, 1)
        there = np.where(moving & (total > 0), there, z)
        moving &= ((there - z) ** 2).sum(0) > (bandwidth_px / 40) ** 2
        z = there
        if fold_px and moving.any():
            z, weight, moving, into = together(z, weight, moving, fold_px)
            now, ends = into[now], into[ends]
    return z[:, ends], shifts


def together(z: Floats, weight: Floats, moving: Bools, side: float) -> tuple[Floats, Floats, Bools, NDArray[np.int64]]:
    """What shares a cell is one, at the mean; it moves if any of it does."""
    cells: dict[tuple[float, ...], list[int]] = {}
    for i, cell in enumerate(np.floor(z / side).T.tolist()):
        cells.setdefault(tuple(cell), []).append(i)
    groups = list(cells.values())
    into = np.empty(len(weight), np.int64)
    for k, group in enumerate(groups):
        into[group] = k
    means = [np.average(z[:, group], axis=1, weights=weight[group]) for group in groups]
    return (
        np.stack(means, axis=1),
        np.array([weight[group].sum() for group in groups]),
        np.array([moving[group].any() for group in groups]),
        into,
    )


def packet(seed: int, n: int = 200, size: int = 120) -> Floats:
    """Events of three rings, and noise, at pixels; polarity 0 or 2, time within 4."""
    random = np.random.default_rng(seed)
    ring, angle = random.integers(0, 3, n), random.uniform(0, 2 * np.pi, n)
    x, y = (random.uniform(20, size - 20, 3)[ring] + 8 * wave(angle) for wave in (np.cos, np.sin))
    noise = random.random(n) < 0.1
    x, y = (np.where(noise, random.uniform(0, size, n), axis) for axis in (x, y))
    return np.stack((np.rint(x), np.rint(y), 2.0 * random.integers(0, 2, n), np.sort(random.uniform(0, 4, n))))


@pytest.mark.parametrize("fold_px", [0.0, 0.7123, 3.1416])  # sides that no place is a multiple of: there, rounding would decide
@pytest.mark.parametrize("bandwidth_px", [2.0, 6.0, 15.0])
@pytest.mark.parametrize("seed", range(3))
def test_the_equations_to_1e_9(seed: int, bandwidth_px: float, fold_px: float) -> None:
    points = packet(seed)
    expected, shifts = equations(points, bandwidth_px, fold_px)
    mode_of, modes, evaluations, pairs = converge(points, bandwidth_px, fold_px)
    np.testing.assert_allclose(modes[:, mode_of], expected, rtol=0, atol=1e-9)
    if fold_px == 0:
        assert pairs == shifts * points.shape[1]
    assert 0 < evaluations < pairs or bandwidth_px > 10


@pytest.mark.parametrize("seed", range(3))
def test_folding_saves_most_evaluations_and_moves_modes_little(seed: int) -> None:
    points = packet(seed)
    plain_of, plain, many, _ = converge(points, 10.0, 0.0)
    folded_of, folded, few, _ = converge(points, 10.0, 2.5)
    assert few < 0.4 * many
    off = np.hypot(*(folded[:, folded_of] - plain[:, plain_of])[:2])
    assert np.median(off) < 0.6
    assert np.quantile(off, 0.95) < 2.0
    single = np.array([[3.0, 60_000.0], [4.0, 60_000.0], [0.0, 2.0], [1.0, 1.0]])
    mode_of, modes, _, _ = converge(single, 6.0, 0.0)
    np.testing.assert_allclose(modes[:, mode_of], single, atol=1e-12, err_msg="single points stay")
