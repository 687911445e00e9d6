# SPDX-License-Identifier: Apache-2.0
"""The golden model of the classifier against the rules of docs/recognition.md, and stories worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.classifier import CELLS, HIDDEN, RecognitionRegisters
from evcot.recognition import model
from evcot.recognition.model import Classifier, Network, OwnedEvents, Windows
from support.slow_classifier import OwnedEvent, SlowClassifier

REL_W = 10
SHORT = RecognitionRegisters(window_log2=8, shift_1=3, shift_2=4, classes=3)


def network(seed: int, classes: int = 3) -> Network:
    random = np.random.default_rng(seed)
    return Network(*(random.integers(-128, 128, shape).astype(np.int8) for shape in ((CELLS**2, HIDDEN), (HIDDEN, classes))))


def owned(events: list[OwnedEvent]) -> OwnedEvents:
    """As many events as the last one's number says; those that are not listed have no owner."""
    n = events[-1].seq + 1 if events else 0
    owner, visible = np.full(n, -1, np.int16), np.zeros(n, np.bool_)
    rel_x, rel_y = np.zeros(n, np.uint16), np.zeros(n, np.uint16)
    for e in events:
        owner[e.seq], visible[e.seq] = e.slot, e.visible
        rel_x[e.seq], rel_y[e.seq] = e.dx & ((1 << REL_W) - 1), e.dy & ((1 << REL_W) - 1)
    return OwnedEvents(owner, rel_x, rel_y, visible)


def part(events: OwnedEvents, begin: int, end: int) -> OwnedEvents:
    return OwnedEvents(*(column[begin:end] for column in events))


def traffic(seed: int, count: int, slots: int) -> list[OwnedEvent]:
    """Objects of random size, place and shear; slots are shared unevenly, and tracks end."""
    random = np.random.default_rng(seed)
    share = random.dirichlet(np.full(slots, 0.5))
    spread, off = random.uniform(1, 150, (slots, 2)), random.uniform(-60, 60, (slots, 2))
    shear = random.uniform(-1, 1, slots)
    events, seq = [], -1
    for slot in random.choice(slots, count, p=share).tolist():
        seq += int(random.integers(1, 3))
        dy = random.normal(off[slot, 1], spread[slot, 1])
        dx = random.normal(off[slot, 0], spread[slot, 0]) + shear[slot] * dy
        place = (int(np.clip(one, -512, 511)) for one in (dx, dy))
        events.append(OwnedEvent(seq, slot, *place, bool(random.random() > 0.0004)))
    return events


def rows(verdicts: np.ndarray) -> list[tuple[int, ...]]:
    return [tuple(int(one) for one in row) for row in verdicts.tolist()]


@pytest.mark.parametrize("seed", range(6))
def test_random_traffic_gives_the_verdicts_of_the_rules(seed: int) -> None:
    registers = replace(SHORT, scale_start=(16, 300, 984, 4095)[seed % 4], margin_min=(0, 20)[seed % 2], shift_1=seed)
    events = traffic(seed, 30_000, (1, 2, 5)[seed % 3])
    expected = SlowClassifier(registers, network(seed), 5).feed(events)
    assert len(expected) > 10
    assert rows(Classifier(registers, network(seed), 5, REL_W).feed(owned(events))) == expected


def test_the_split_into_runs_changes_nothing() -> None:
    events = traffic(11, 20_000, 3)
    decided = owned(events)
    whole = rows(Classifier(SHORT, network(1), 3, REL_W).feed(decided))
    classifier = Classifier(SHORT, network(1), 3, REL_W)
    ends = [0, 1, 2, 700, 700, 9_999, len(decided.owner)]
    found = [classifier.feed(part(decided, begin, end)) for begin, end in pairwise(ends)]
    assert rows(np.concatenate(found)) == whole


def test_more_windows_than_the_buffer_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    events = traffic(12, 20_000, 3)
    whole = rows(Classifier(SHORT, network(1), 3, REL_W).feed(owned(events)))
    monkeypatch.setattr(model, "_RUN_WINDOWS", 4)
    assert len(whole) > 8
    assert rows(Classifier(SHORT, network(1), 3, REL_W).feed(owned(events))) == whole


def of_one_slot(count: int, begin: int = 0, slot: int = 0, visible: bool = True) -> list[OwnedEvent]:
    return [OwnedEvent(begin + i, slot, 0, 0, visible) for i in range(count)]


def closings(events: list[OwnedEvent], slots: int = 2) -> list[tuple[int, int, int]]:
    """(event, slot, stage) of each window."""
    found = Windows(SHORT, slots, REL_W).feed(owned(events))
    return [
        (int(event), int(slot), int(stage))
        for each in found
        for event, slot, stage in zip(each.event, each.slot, each.stage, strict=True)
    ]


def test_a_slot_pauses_for_768_owned_events_of_any_slot() -> None:
    events = of_one_slot(256) + of_one_slot(500, 256, slot=1, visible=False) + of_one_slot(268 + 256, 756)
    assert closings(events) == [(255, 0, 0), (255 + 768 + 255, 0, 1)]


def test_windows_of_two_slots_are_evaluated_one_after_the_other() -> None:
    both = [OwnedEvent(seq, seq % 2, 0, 0, True) for seq in range(512)]
    events = both + of_one_slot(4000, 512, slot=1)
    # Slot 0 closes at 510 and leaves the queue at 510 + 768; slot 1 leaves it 768 events later and fills its next window.
    assert closings(events)[:3] == [(510, 0, 0), (511, 1, 0), (510 + 2 * 768 + 255, 1, 1)]


def test_an_event_of_a_candidate_begins_a_new_track() -> None:
    events = of_one_slot(200) + of_one_slot(1, 200, visible=False) + of_one_slot(256, 201)
    assert closings(events) == [(456, 0, 0)]


def test_the_first_window_of_a_track_has_no_verdict() -> None:
    events = of_one_slot(256 + 767 + 256)
    verdicts = Classifier(SHORT, network(2), 1, REL_W).feed(owned(events))
    assert [(int(one["seq"]), int(one["windows"])) for one in verdicts] == [(256 + 767 + 255, 1)]


def test_an_object_beyond_the_image_becomes_smaller_until_it_fits() -> None:
    random = np.random.default_rng(3)
    events = [OwnedEvent(i, 0, *random.integers(-150, 151, 2).tolist(), True) for i in range(40 * 1024)]
    edge = [
        int(image.reshape(CELLS, CELLS)[:, [0, -1]].sum()) / image.sum()
        for each in Windows(SHORT, 1, REL_W).feed(owned(events))
        for image in each.images
    ]
    assert edge[0] > 0.6
    assert edge[-1] < 0.05


def test_a_write_begins_all_windows_and_votes_anew() -> None:
    classifier = Classifier(SHORT, network(4), 1, REL_W)
    classifier.feed(owned(of_one_slot(256 + 767 + 255)))
    classifier.write(SHORT, network(5))
    verdicts = classifier.feed(owned(of_one_slot(256 + 767 + 256)))
    assert [(int(one["seq"]), int(one["windows"])) for one in verdicts] == [(2 * (256 + 767) + 255 + 255, 1)]


def test_a_network_of_another_shape_is_refused() -> None:
    good = network(1)
    with pytest.raises(ConfigError, match=r"w1 is \(144, 31\) int8: must be \(144, 32\) int8"):
        Network(good.w1[:, 1:], good.w2)
    with pytest.raises(ConfigError, match=r"w2 is \(32, 11\) int8: must be \(32, 2 to 10\) int8"):
        Network(good.w1, np.zeros((32, 11), np.int8))
    with pytest.raises(ConfigError, match=r"w2 is \(32, 3\) int16"):
        Network(good.w1, good.w2.astype(np.int16))  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match=r"recognition.classes = 4: must be 3, as of w2"):
        Classifier(replace(SHORT, classes=4), good, 1, REL_W)


@pytest.mark.parametrize(("name", "value"), [("window_log2", 7), ("scale_start", 4096), ("classes", 1), ("margin_min", -1)])
def test_a_register_outside_its_range_is_refused(name: str, value: int) -> None:
    with pytest.raises(ConfigError, match=rf"recognition.{name} = {value}: must be from "):
        RecognitionRegisters(**{name: value})
