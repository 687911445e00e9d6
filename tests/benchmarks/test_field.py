# SPDX-License-Identifier: Apache-2.0
"""The field of tests: changes keep the truth exact, references find what moves, and nothing is chosen on what is scored."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import field
import field_of_tests
from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.metrics import evaluate
from evcot.metrics.truth import OBJECT, GroundTruth
from evcot.scenes import insects
from evcot.scenes.insects import Insects
from evcot.scenes.shapes import KIND, QUADRANGLE, X, Y
from evcot.tracks.log import TRACK, Kind, TrackLog
from field import digits, recorded, second, traffic
from field import member as field_member
from field.contenders import Contender, contenders, more_settings, oracle_log
from field.hard import without_faint
from field.member import Absent, Entry, Member, nothing_there, scene_rule
from field.reference import SEEN, Scale, reference
from field.scoring import PACKET_US, Score, run, score, score_log
from field.second import Bouncing
from field.simulated import with_grass
from field.table import Scored, left_out
from field.transforms import (
    at_speed,
    backwards,
    doubled,
    halved,
    merged,
    noisy,
    poisson_noise,
    spliced,
    thinned,
    transposed,
    upside_down,
)
from shared import SHARED

SENSOR = 120, 80
STEP_US = 20_000
FRAMES = 25
SIZE = 16.0, 10.0
RULE = replace(scene_rule(Recording(Events.empty(), *SENSOR)), ignore={"left": 7.0, "top": 4.0}, edge_px=0.0)


def place(t_us: Any) -> tuple[Any, Any]:
    return 14.25 + 150e-6 * t_us, 20.5 + 60e-6 * t_us


def sample_member() -> Member:
    """One box that crosses the sensor, its events all over it, and a little noise."""
    random = np.random.default_rng(5)
    t_us = np.sort(random.integers(0, FRAMES * STEP_US, 6_000))
    x, y = (
        np.rint(centre + random.uniform(-side / 2, side / 2, len(t_us))) for centre, side in zip(place(t_us), SIZE, strict=True)
    )
    x[::10], y[::10] = random.integers(0, SENSOR[0], 600), random.integers(0, SENSOR[1], 600)
    p = random.integers(0, 2, len(t_us), dtype=np.uint8)
    recording = Recording(Events(t_us, x.astype(np.uint16), y.astype(np.uint16), p), *SENSOR)
    objects = np.zeros(FRAMES, OBJECT)
    instants_us = np.arange(FRAMES, dtype=np.int64) * STEP_US
    objects["frame"] = np.arange(FRAMES)
    objects["x"], objects["y"] = place(instants_us)
    objects["width"], objects["height"] = SIZE
    objects["vx"], objects["vy"] = 150, 60
    objects["counted"] = True
    truth = GroundTruth(instants_us, objects, ("a",))
    return Member("f", "m", recording, truth, RULE, "exact")


def in_boxes(member: Member, window_us: float, margin_px: float = 0.0) -> list[int]:
    """How many events lie in each box around its instant."""
    events, counts = member.recording.events, []
    for one in member.truth.objects:
        t_us = member.truth.instants_us[one["frame"]]
        inside = np.abs(events.t_us - t_us) <= window_us
        inside &= np.abs(events.x - one["x"]) <= one["width"] / 2 + margin_px
        inside &= np.abs(events.y - one["y"]) <= one["height"] / 2 + margin_px
        counts.append(int(inside.sum()))
    return counts


CHANGES: dict[str, Callable[[Member], Member]] = {
    "backwards": backwards,
    "upside down": upside_down,
    "transposed": transposed,
    "x 0.25": lambda member: at_speed(member, 0.25),
}


@pytest.mark.parametrize("name", CHANGES)
def test_the_same_events_lie_in_the_same_boxes_after_a_change(name: str) -> None:
    member = sample_member()
    window_us = {"x 0.25": 4 * 3_000.0}.get(name, 3_000.0)
    changed = CHANGES[name](member)
    found, expected = in_boxes(changed, window_us), in_boxes(member, 3_000.0)
    assert found == (expected[::-1] if name == "backwards" else expected)
    assert min(expected) > 10


@pytest.mark.parametrize("change", [backwards, upside_down, transposed])
def test_a_change_made_twice_is_none(change: Callable[[Member], Member]) -> None:
    member = sample_member()
    twice = change(change(member))
    for name in ("t_us", "x", "y", "p"):
        assert np.array_equal(getattr(twice.recording.events, name), getattr(member.recording.events, name))
    for name in OBJECT.names or ():
        assert twice.truth.objects[name] == pytest.approx(member.truth.objects[name])
    assert np.array_equal(twice.truth.instants_us, member.truth.instants_us)
    assert twice.rule == member.rule
    assert change(member).truth.objects.tolist() != member.truth.objects.tolist()


@pytest.mark.parametrize("seed", [1, 2])
def test_twice_and_half_the_size_is_the_same_again(seed: int) -> None:
    member = sample_member()
    larger = doubled(member, seed)
    again = halved(larger)
    assert np.array_equal(again.recording.events.x, member.recording.events.x)
    assert np.array_equal(again.recording.events.y, member.recording.events.y)
    for name in ("x", "y", "width", "height", "vx"):
        assert again.truth.objects[name] == pytest.approx(member.truth.objects[name])
    assert (again.rule.edge_px, again.rule.ignore) == (pytest.approx(member.rule.edge_px), member.rule.ignore)
    within, all_around = in_boxes(larger, 3_000, -1.0), in_boxes(larger, 3_000, 1.0)
    assert all(low <= n <= high for low, n, high in zip(within, in_boxes(member, 3_000), all_around, strict=True))


# How a place, a time and a length change; the rule must change alike, so that the same tracks score the same.
MAPS: dict[str, tuple[Callable[[Member], Member], Callable[[Any, Any, Any], tuple[Any, Any, Any]], float]] = {
    "upside down": (upside_down, lambda t, x, y: (t, 119 - x, 79 - y), 1.0),
    "transposed": (transposed, lambda t, x, y: (t, y, x), 1.0),
    "half": (halved, lambda t, x, y: (t, (x + 0.5) / 2 - 0.5, (y + 0.5) / 2 - 0.5), 0.5),
    "twice": (lambda member: doubled(member, 1), lambda t, x, y: (t, 2 * x + 0.5, 2 * y + 0.5), 2.0),
    "slow": (lambda member: at_speed(member, 0.25), lambda t, x, y: (4 * t, x, y), 1.0),
}


def some_log(change: Callable[[Any, Any, Any], tuple[Any, Any, Any]], length: float) -> TrackLog:
    """A track near the box that falls silent for 70 ms, and two in the bands, of which one strays out of them."""
    records = np.zeros(3 * 40, TRACK)
    records["kind"], records["track_id"] = Kind.MOVED, np.repeat((1, 2, 3), 40)
    t_us = np.tile(np.arange(40) * 10_000, 3)
    x, y = place(t_us)
    x, y = x + 1.5, y - 1.0
    x[40:80], y[40:80] = 6.0, 70.0
    x[80:], y[80:] = 100.0, np.linspace(0, 8, 40)
    records["t_us"], records["x"], records["y"] = change(t_us, x, y)
    records["radius"] = 6 * length
    for name in {"width", "height"} & set(TRACK.names or ()):
        records[name] = 12 * length
    records = records[~((records["track_id"] == 1) & (t_us > 120_000) & (t_us < 200_000))]
    return TrackLog("some", records[np.argsort(records["t_us"], kind="stable")], np.empty(0, np.int16))


@pytest.mark.parametrize("similarity", ["centre", "iou"])
@pytest.mark.parametrize("name", MAPS)
def test_tracks_changed_alike_score_the_same(name: str, similarity: str) -> None:
    change, move, length = MAPS[name]
    member = sample_member()
    changed = change(member)
    scores = [
        evaluate(log, own.truth, replace(own.rule, similarity=similarity))
        for log, own in ((some_log(lambda *where: where, 1.0), member), (some_log(move, length), changed))
    ]
    assert scores[1].hota == pytest.approx(scores[0].hota)
    for figure in ("idf1", "fp", "fn", "track_ids"):
        assert getattr(scores[1], figure) == pytest.approx(getattr(scores[0], figure))
    assert scores[0].fn >= 1  # the silence is felt
    assert scores[0].track_ids == 2  # the one in the left band is ignored, the one that strays is not


def test_two_spliced_keep_both_truths_and_both_bands() -> None:
    member = sample_member()
    both = spliced(member, member, (SENSOR[0], 0))
    assert (both.recording.width, both.recording.height) == (2 * SENSOR[0], SENSOR[1])
    assert len(both.recording.events) == 2 * len(member.recording.events)
    objects = both.truth.objects[both.truth.objects["counted"]]
    counts = in_boxes(replace(both, truth=replace(both.truth, objects=objects)), 3_000)
    expected = in_boxes(member, 3_000)
    assert counts[::2] == expected
    assert counts[1::2] == expected
    log = some_log(lambda *where: where, 1.0)
    moved = replace(log, records=log.records.copy())
    moved.records["x"] += SENSOR[0]
    moved.records["track_id"] += 10
    together = np.concatenate((log.records, moved.records))
    one = evaluate(log, member.truth, member.rule)
    two = evaluate(TrackLog("two", together[np.argsort(together["t_us"], kind="stable")], log.owner), both.truth, both.rule)
    assert (two.tp, two.fp, two.fn) == (2 * one.tp, 2 * one.fp, 2 * one.fn)


def test_loss_and_noise_leave_the_truth_alone() -> None:
    member = sample_member()
    fewer, more = thinned(member, 0.3, 1), noisy(member, 5.0, 1)
    assert len(fewer.recording.events) == pytest.approx(0.7 * len(member.recording.events), rel=0.05)
    added = 5.0 * SENSOR[0] * SENSOR[1] * member.recording.duration_us * 1e-6
    assert len(more.recording.events) - len(member.recording.events) == pytest.approx(added, rel=0.05)
    assert fewer.truth is more.truth is member.truth


def blob(begin_us: int, end_us: int, random: np.random.Generator) -> Events:
    """A swinging blob, 40 events a millisecond between two times."""
    t_us = np.sort(random.integers(begin_us, end_us, (end_us - begin_us) // 25))
    x, y = swing(t_us)
    at = [np.clip(np.rint(axis + random.normal(0, 3, len(t_us))), 0, 127).astype(np.uint16) for axis in (x, y)]
    return Events(t_us, *at, random.integers(0, 2, len(t_us), dtype=np.uint8))


def swing(t_us: Any) -> tuple[Any, Any]:
    return 64 + 40 * np.sin(t_us * 4e-6), 60 + 10 * np.cos(t_us * 4e-6)


def test_a_reference_finds_a_known_path_through_noise_and_a_silence() -> None:
    random = np.random.default_rng(2)
    noise = poisson_noise((128, 128), (0, 3_000_000), 0.1, random)
    events = merged(blob(0, 1_400_000, random), blob(1_500_000, 3_000_000, random), noise)
    found = reference(Recording(events, 128, 128), Scale(16, 30_000, 5), 20_000)
    x, y = swing(found.path["t_us"])
    seen = found.path["state"] == SEEN
    silent = (found.path["t_us"] > 1_430_000) & (found.path["t_us"] < 1_470_000)
    assert not seen[silent].any()
    assert seen[~silent].mean() > 0.95
    far = np.hypot(found.path["x"] - x, found.path["y"] - y)[seen]
    assert np.median(far) < 0.6
    assert far.max() < 4  # beside the silence
    assert np.median(found.difference_px) < 1
    assert not found.truth().objects["counted"][silent].any()


def test_equal_seed_sets_are_equal_members_and_others_are_not(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made = []
    for number, seed_set in enumerate((1, 1, 2)):
        monkeypatch.setattr(field_member, "FOLDER", tmp_path / str(number))  # nothing is kept from one to the next
        made.append(next(one for one in field.entries(seed_set, True) if one.family == "boxes").build())
    first, again, other = made
    assert np.array_equal(first.recording.events.t_us, again.recording.events.t_us)
    assert len(first.recording.events) != len(other.recording.events)


def test_what_is_kept_is_what_was_made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(field_member, "FOLDER", tmp_path)
    entry = next(one for one in field.entries(1, True) if one.family == "boxes")
    first = entry.build()
    assert len(list(tmp_path.glob("members/*.npz"))) == 1
    monkeypatch.setattr("field.simulated.simulate_scene", None)
    again = entry.build()
    assert again.recording.events.to_array().tolist() == first.recording.events.to_array().tolist()
    assert again.truth.objects.tolist() == first.truth.objects.tolist()
    assert (again.family, again.name, again.rule, again.truth.ids) == (first.family, first.name, first.rule, first.truth.ids)


def test_backwards_what_became_brighter_becomes_darker() -> None:
    events, turned = (one.recording.events for one in (sample_member(), backwards(sample_member())))
    assert turned.p.tolist() == [1 - p for p in events.p[::-1].tolist()]
    assert np.diff(turned.t_us).tolist() == np.diff(events.t_us)[::-1].tolist()


def test_at_least_ten_families_of_several_members() -> None:
    families: dict[str, set[str]] = {}
    for entry in field.entries(1):
        assert entry.name not in families.setdefault(entry.family, set())
        families[entry.family].add(entry.name)
    assert len(families) >= 10
    assert min(map(len, families.values())) >= 2
    assert {entry.family for entry in field.entries(1, quick=True)} == set(families)


def test_members_of_absent_recordings_are_left_out_and_it_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for module in (traffic, recorded, digits):
        monkeypatch.setattr(module, "SHARED", tmp_path)
    recorded.reference_of.cache_clear()
    digits._samples.cache_clear()
    begins = ("traffic", "pendulum, recorded", "hand", "digits")
    own = [entry for entry in field.entries(1, quick=True) if entry.family.startswith(begins)]
    for entry in own:
        with pytest.raises(Absent, match="is not in"):
            entry.build()
    assert list(field.members(1, [entry.family for entry in own], quick=True)) == []
    assert list(field_of_tests._built(own)) == []
    said = capsys.readouterr().err
    assert said.count("left out") == len(own)
    assert "traffic_outbound.aedat4 is not in" in said


def test_a_digit_in_its_row_keeps_all_rows_of_its_sample() -> None:
    if not (SHARED / "nmnist_800.npz").is_file():
        pytest.skip("nmnist_800.npz is not here")
    sample = digits._sample(0)
    paths = Bouncing((346, 260), np.array([[20.0, 20.0]]), np.array([60.0]), False, np.random.default_rng(1))
    for middle_y in (16.0, 16.5):
        carried = digits._carried(sample, np.array([16.0, middle_y]), paths, 0, 50_000)
        begin = sample.t_us < 50_000
        assert len(set((carried.y.astype(int) - sample.y[begin]).tolist())) == 1


def test_a_digits_events_lie_in_its_box() -> None:
    if not (SHARED / "nmnist_800.npz").is_file():
        pytest.skip("nmnist_800.npz is not here")
    member = digits.digits("apart", 1, (3,))
    inside = sum(in_boxes(member, 9_999.5))  # the windows are as long as the steps: every event is asked about once
    outside_hz = (len(member.recording.events) - inside) / 4 / (member.recording.width * member.recording.height)
    assert inside > 25_000  # seven times or more a sample of some thousands
    assert outside_hz < 1.1  # the noise, at most 1 Hz a pixel, and a few percent of the digit
    x, y = member.truth.objects["x"], member.truth.objects["y"]
    assert np.ptp(x) > 20
    sample = digits._sample(int(np.random.default_rng((3, 1)).choice(800, 1, replace=False)[0]))
    place, _ = digits._in_the_loop(sample, member.truth.instants_us)
    assert np.ptp(place[1]) > 4.0
    assert np.ptp(y - place[1]) < 1e-3  # the row


def test_a_digit_is_where_the_truth_follows_its_saccades() -> None:
    """The middle of its events within 10 ms of an instant stays where it is in the box; with the path alone it would not."""
    if not (SHARED / "nmnist_800.npz").is_file():
        pytest.skip("nmnist_800.npz is not here")
    member = digits.digits("apart", 1, (3,))
    events, truth = member.recording.events, member.truth
    off_px = []
    for row in truth.objects:
        begin, end = np.searchsorted(events.t_us, truth.instants_us[row["frame"]] + np.array([-10_000, 10_000]))
        off = np.abs(events.x[begin:end] - row["x"]), np.abs(events.y[begin:end] - row["y"])
        own = (off[0] < row["width"]) & (off[1] < row["height"])
        if np.count_nonzero(own) >= 200:
            middle = np.median(events.x[begin:end][own]), np.median(events.y[begin:end][own])
            off_px.append((middle[0] - row["x"], middle[1] - row["y"]))
    assert len(off_px) > 100
    assert np.all(np.std(off_px, axis=0) < 1.5)
    loop_px = np.ptp(digits._saccades(), axis=1)
    assert np.all((loop_px > 4.5) & (loop_px < 7.0))


def test_the_second_simulators_events_lie_in_its_boxes(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("eventcv")
    monkeypatch.setattr(second, "_SECONDS", 0.1)
    for make in (second._Shapes, second._Road):
        random = np.random.default_rng(4)
        scenery = make((240, 180), random)
        recording = Recording(second._seen(scenery, (240, 180), random), 240, 180)
        truth = second._truth(scenery, (240, 180))
        covered = np.zeros((180, 240), bool)
        for one in truth.objects:
            y, x = np.mgrid[:180, :240]
            covered |= (np.abs(x - one["x"]) <= one["width"] / 2 + 1) & (np.abs(y - one["y"]) <= one["height"] / 2 + 1)
        inside = covered[recording.events.y, recording.events.x].mean()
        density = inside / covered.mean() / ((1 - inside) / (1 - covered.mean()))
        assert density > 10  # the camera's own noise is everywhere
        assert covered.mean() < 0.5


class Knowing:
    """A tracker that says where the box is; a packet costs as long as it is told."""

    settled = 0

    def feed(self, events: Events) -> tuple[Any, Any]:
        records = np.zeros(min(1, len(events)), TRACK)
        if len(events):
            records["t_us"], records["kind"] = events.t_us[-1], Kind.MOVED
            records["x"], records["y"] = place(events.t_us[-1])
            records["radius"] = 6
        return records, np.full(len(events), -1, np.int16)

    def finish(self) -> Any:
        return np.empty(0, TRACK)


KNOWING = Contender("knowing", {"plain": None}, lambda *_: Knowing(), lambda settings, _: settings, masked=False)


class Clock:
    """Each packet takes as long as it is told; `cpu_share` of that is ours."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, packet_s: float, cpu_share: float = 1.0) -> None:
        self._ticks, self._packet_s = count(), packet_s
        monkeypatch.setattr("field.scoring.time.perf_counter", self.wall)
        monkeypatch.setattr("field.scoring.time.thread_time", lambda: cpu_share * self._now_s)
        self._now_s = 0.0

    def wall(self) -> float:
        self._now_s += self._packet_s * (next(self._ticks) % 2)  # inside the packets alone
        return self._now_s


def test_an_answer_that_comes_late_scores_less(monkeypatch: pytest.MonkeyPatch) -> None:
    member = sample_member()

    def at(packet_s: float) -> Score:
        Clock(monkeypatch, packet_s)
        return score(KNOWING, None, member, timed=True)

    quick, slow, hopeless = at(1e-6), at(1.05e-3), at(1.0)
    assert quick.hota == slow.hota == hopeless.hota
    assert quick.answered is not None
    assert slow.answered is not None
    assert quick.answered > slow.answered > hopeless.answered == 0


@pytest.mark.parametrize("cpu_share", [1.0, 0.5])
def test_an_answer_waits_for_those_before_it(monkeypatch: pytest.MonkeyPatch, cpu_share: float) -> None:
    Clock(monkeypatch, 4e-3, cpu_share)
    log, late, cpu_s = run(KNOWING, None, sample_member())
    packets = np.arange(len(log.records)) + 1
    first_us = int(sample_member().recording.events.t_us[0])
    assert np.array_equal(late.records["t_us"], first_us + PACKET_US + 4_000 * cpu_share * packets)
    assert cpu_s == pytest.approx(4e-3 * cpu_share * (len(packets) + 1))


def test_where_nothing_is_there_tracks_are_counted() -> None:
    recording = Recording(Events(np.arange(100) * 1_000, *np.ones((2, 100), np.uint16), np.ones(100, np.uint8)), 8, 8)
    member = Member("f", "m", recording, nothing_there(0, 100_000), RULE, "nothing")
    assert member.empty
    found = score(KNOWING, None, member)
    assert (found.tracks, found.hota, found.merit) == (1, None, 0.5)
    assert score_log(TrackLog.empty("none"), member).merit == 1


def scored(settings: str, family: str, hota: float) -> Scored:
    return Scored("c", settings, 1, family, "m", None, Score(1, hota=hota))


def test_what_is_left_out_is_not_chosen_on_nor_what_shares_its_source() -> None:
    # Setting "a" is good on both families of source 1 alone, "b" on source 2, "c" everywhere a little.
    table = {"a": (0.9, 0.9, 0.1), "b": (0.1, 0.2, 0.9), "c": (0.4, 0.5, 0.6)}
    families = ("one", "two", "three")
    every = [scored(name, family, hota) for name, row in table.items() for family, hota in zip(families, row, strict=True)]
    choices = {one.family: one for one in left_out(every, {"one": "1", "two": "1", "three": "2"}, ["b", "c"])}
    assert {family: one.settings for family, one in choices.items()} == {"one": "b", "two": "b", "three": "a"}
    assert {family: one.merit for family, one in choices.items()} == {"one": 0.1, "two": 0.2, "three": 0.1}
    assert {family: one.preset for family, one in choices.items()} == {"one": "c", "two": "c", "three": "b"}
    assert choices["one"].best_merit == 0.9


def test_a_final_seed_set_is_used_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(field_of_tests, "_FINALS", tmp_path / "finals.json")
    field_of_tests._use_once(77, [1])
    for seed in (77, 1):
        with pytest.raises(ConfigError, match=f"--final {seed}: must be"):
            field_of_tests._use_once(seed, [1])
    field_of_tests._use_once(78, [1])


def test_settings_at_random_are_valid_and_repeat() -> None:
    for contender in contenders(["rct", "mean-shift", "frames", "cot_array"]):
        first, again = (more_settings(contender, 3, np.random.default_rng(4)) for _ in range(2))
        assert repr(first) == repr(again)
        assert len(first) == len(contender.settings) + 3
        assert len({repr(one) for one in first.values()}) == len(first)
        for own in first.values():
            contender.start(own, SENSOR)


def members_of_two_sources(*_: Any) -> Iterator[Entry]:
    for family in ("f", "g"):
        yield Entry(family, "m", family, lambda family=family: replace(sample_member(), family=family))  # type: ignore[misc]


@pytest.fixture
def field_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[str], int]:
    """The command on a field of two small members, with one contender."""
    monkeypatch.setattr(field_of_tests, "FOLDER", tmp_path)
    monkeypatch.setattr(field_of_tests, "entries", lambda *_: list(members_of_two_sources()))
    monkeypatch.setattr(field_of_tests, "contenders", lambda *_: [KNOWING])

    def command(arguments: str) -> int:
        monkeypatch.setattr("sys.argv", ["field_of_tests.py", *arguments.format(folder=tmp_path).split()])
        return field_of_tests.main()

    return command


@pytest.mark.parametrize("more", ["", "--leave-out 1 --search-members 1"])
def test_the_table_and_the_picture_are_of_every_tracker(
    field_command: Callable[[str], int], tmp_path: Path, capsys: pytest.CaptureFixture[str], more: str
) -> None:
    assert field_command(f"--trackers knowing oracle --draws 2 --keep {{folder}}/now.json {more}") == 0
    said = capsys.readouterr().out
    assert "knowing, " in said
    assert "seeds (S, 11, D): S = [1], D = [0, 1]" in said
    assert "worst HOTA" in said
    assert "| f | validation |" in said
    assert (tmp_path / ("left_out.png" if more else "field.png")).read_bytes()[:4] == b"\x89PNG"
    results = json.loads((tmp_path / "now.json").read_text())
    titles = {"left out", "best preset"} if more else {"plain"}
    expected = {("knowing", title) for title in titles} | {("oracle", "extents of events")}
    assert {(one["contender"], one["settings"]) for one in results["scores"]} == expected
    assert {(one["family"], one["draw"]) for one in results["scores"]} == {(family, draw) for family in "fg" for draw in (0, 1)}
    if more:
        assert [one["family"] for one in results["choices"]["knowing"]] == ["f", "g"]


def test_a_run_is_compared_with_an_earlier_one_on_equal_draws(
    field_command: Callable[[str], int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "before.json"
    field_command("--trackers knowing --draws 2 --keep {folder}/before.json")
    kept_before = json.loads(path.read_text())
    for one in kept_before["scores"]:
        one["hota"] -= 0.1
        one["settings"] = "renamed"  # the only row of a file is compared with any
    path.write_text(json.dumps(kept_before))
    capsys.readouterr()
    assert field_command("--trackers knowing --draws 3 --against {folder}/before.json --members") == 0
    said = capsys.readouterr().out
    assert "| difference | knowing, plain |" in said
    assert "| g | +0.100 ± 0.000 |" in said
    assert "| mean, HOTA | +0.100 ± 0.000 ± 0.000 |" in said
    assert "| f | 1: m | knowing, plain | 0." in said


def test_the_better_of_two_truths_counts() -> None:
    member = sample_member()
    far = replace(member.truth, objects=member.truth.objects.copy())
    far.objects["x"] += 60
    log = some_log(lambda *where: where, 1.0)
    one = score_log(log, member)
    assert score_log(log, replace(member, truth=far)).hota == 0
    assert score_log(log, replace(member, truth=far, alternatives=(member.truth,))) == one
    assert score_log(log, replace(member, alternatives=(far,))) == one


def test_a_simulated_pendulum_is_a_bob_or_a_bob_with_its_rod() -> None:
    member = next(entry for entry in field.entries(1, True) if entry.family == "pendulum, simulated").build()
    (whole,) = member.alternatives
    bob = member.truth.objects[member.truth.objects["counted"]]
    assert np.array_equal(bob["frame"], whole.objects["frame"])
    for axis, side in (("x", "width"), ("y", "height")):
        for sign in (-1, 1):
            beyond = sign * (whole.objects[axis] - bob[axis]) + (whole.objects[side] - bob[side]) / 2
            assert beyond.min() >= -1e-9
    assert whole.objects["height"].min() > 2 * bob["height"].max()


def test_a_track_on_grass_is_not_false() -> None:
    member = sample_member()
    settings = Insects(width=120, height=80, count=1, blades=3, seed=4)
    truth = with_grass(member.truth, settings)
    log = some_log(lambda *where: where, 1.0)
    blade = truth.objects[~truth.objects["counted"]][0]
    log.records["x"][log.records["track_id"] == 3], log.records["y"][log.records["track_id"] == 3] = blade["x"], blade["y"]
    assert evaluate(log, member.truth, member.rule).fp - evaluate(log, truth, member.rule).fp > 20
    for t_us in range(0, 4_000_000, 100_000):
        for number, *corners in blades_at(settings, t_us):
            own = truth.objects[(truth.objects["object"] == 1 + number) & (truth.objects["frame"] == 3)][0]
            for axis, side, coordinates in zip("xy", ("width", "height"), corners, strict=True):
                assert np.abs(coordinates - own[axis]).max() <= own[side] / 2 + 1e-6


def blades_at(settings: Insects, t_us: int) -> Iterator[tuple[int, Any, Any]]:
    """Number and corners, x and y, of each blade of grass that is drawn at a time."""
    shapes = insects._Stage(settings).shapes(t_us)
    for number, blade in enumerate(shapes[shapes[:, KIND] == QUADRANGLE]):
        yield number, blade[X : X + 4], blade[Y : Y + 4]


def test_the_oracle_has_true_identity_and_knows_nothing_of_later_events() -> None:
    member = sample_member()
    found = score_log(oracle_log(member), member)
    assert found.hota is not None
    assert found.hota > 0.85
    assert (found.idf1, found.switches, found.tracks) == (pytest.approx(1, abs=0.03), 0, 1)
    events = member.recording.events
    half = replace(member, recording=replace(member.recording, events=events.where(events.t_us <= 240_000)))
    early, whole = oracle_log(half).records, oracle_log(member).records
    assert early[early["t_us"] <= 240_000].tolist() == whole[whole["t_us"] <= 240_000].tolist()
    assert early["t_us"].max() <= 260_000  # no events, no track


def test_an_object_that_sends_next_to_nothing_need_not_be_found() -> None:
    member = sample_member()
    objects = member.truth.objects
    still = objects.copy()
    still["object"], still["x"], still["y"] = 1, 30.0, 70.0  # where there is only noise
    truth = replace(member.truth, objects=np.stack((objects, still), axis=1).ravel(), ids=("a", "b"))
    judged = without_faint(noisy(replace(member, truth=truth), 0.5, 1)).truth.objects
    assert judged["counted"][judged["object"] == 0].all()
    assert not judged["counted"][judged["object"] == 1].any()
    assert truth.objects["counted"].all()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--trackers nobody", "--trackers nobody: must be some of cot_motion, "),
        ("--vary moon=1", "--vary moon=1: 'moon': must be a register, "),
        ("--vary step_log2=99", "motion.step_log2 = 99: must be an integer from 0 to 20"),
        ("--trackers frames --draws -1", "--draws -1: must be at least 0"),
        (f"--trackers frames --keep {__file__}", f"--keep {__file__}: must be a file that does not exist yet"),
        ("--trackers frames --against moon.json", "--against moon.json: must be a file that --keep wrote"),
        ("--families moon", "--families moon: no family begins so"),
        ("--members moon", "--members moon: no member has this name"),
        ("--families digits --leave-out 1", "--leave-out 1: must have families of two sources at least"),
        ("--final 1", "--final 1: must be a seed set that was not used before"),
    ],
)
def test_arguments_that_cannot_be_end_in_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: str, said: str
) -> None:
    monkeypatch.setattr(field_of_tests, "_FINALS", tmp_path / "finals.json")
    monkeypatch.setattr("sys.argv", ["field_of_tests.py", *arguments.split()])
    assert field_of_tests.main() == 2
    printed = capsys.readouterr()
    assert printed.err.startswith(said)
    assert printed.err.count("\n") == 1
    assert printed.out == ""
