# SPDX-License-Identifier: Apache-2.0
"""filter_recent.v: an event stays when enough of the last few events lie near it, whatever stamps do meanwhile."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot_cosim.devices.base import Stalls
from support.filter_trials import FilterDevice, FilterTraffic, check_reset_amid_events, compare_with_reference, filter_traffic
from support.tokens import ticked

Story = list[tuple[int, int, int]]  # tick, x, y


def recent_filter(
    depth: int = 4, stamp_w: int = 6, tick_w: int = 8, *, ticks: int = 20, radius: int = 2, support: int = 1, x_w: int = 5
) -> FilterDevice:
    parameters = {"X_W": x_w, "Y_W": 5, "TICK_W": tick_w, "STAMP_W": stamp_w, "DEPTH": depth}
    ports = {"enable": 1, "recent_ticks": ticks, "recent_radius": radius, "recent_support": support}
    return FilterDevice("filter_recent", parameters, ports)


def run_story(device: FilterDevice, story: Story) -> list[int]:
    """The events of a story, numbered from 0, that stay."""
    ticks, x, y = np.array(story, np.int64).T
    keep = device.stream(ticked(ticks + device.now, x, y))
    return np.flatnonzero(keep).tolist()


class Memory:
    """The contract, without end: the last `depth` events that reached the filter, whatever became of them."""

    def __init__(self, depth: int) -> None:
        self.depth = depth
        self.events = np.zeros((3, 0), np.int64)  # ticks, x, y

    def judge(self, batch: FilterTraffic, ticks: int, radius: int, support: int) -> NDArray[np.bool_]:
        """Which of these events stay, each compared with the one before it, then the one before that; they are remembered."""
        reaches = batch.keep
        known = self.events.shape[1]
        events = np.concatenate([self.events, np.stack([batch.ticks, batch.x, batch.y])[:, reaches]], axis=1)
        supporters = np.zeros(events.shape[1], np.int64)
        for back in range(1, min(self.depth + 1, events.shape[1])):
            age, dx, dy = np.abs(events[:, back:] - events[:, :-back])
            distance = np.maximum(dx, dy)
            supporters[back:] += (age <= ticks) & (distance >= 1) & (distance <= radius)
        self.events = events[:, -self.depth :]
        stays = np.zeros(len(batch.ticks), np.bool_)
        stays[reaches] = supporters[known:] >= support
        return stays


class TestStories:
    def test_company_within_the_radius(self) -> None:
        device = recent_filter(depth=1, radius=2)
        assert run_story(device, [(0, 10, 10), (1, 12, 8), (1, 9, 8), (1, 11, 10), (1, 11, 13)]) == [1, 3]

    def test_its_own_pixel_supports_nothing(self) -> None:
        assert run_story(recent_filter(), [(0, 10, 10), (1, 10, 10), (1, 11, 10), (1, 11, 11)]) == [2, 3]

    def test_as_many_as_asked_for(self) -> None:
        device = recent_filter(support=3)
        assert run_story(device, [(0, 10, 10), (0, 11, 10), (0, 12, 10), (0, 11, 11), (0, 31, 31), (0, 10, 11)]) == [3, 5]

    def test_those_that_do_not_stay_are_remembered_too(self) -> None:
        assert run_story(recent_filter(), [(0, 10, 10), (0, 11, 11)]) == [1]

    @pytest.mark.parametrize(("wait", "stays"), [(20, [1]), (21, [])])
    def test_up_to_the_age_that_is_asked_for(self, wait: int, stays: list[int]) -> None:
        assert run_story(recent_filter(ticks=20), [(5, 10, 10), (5 + wait, 11, 11)]) == stays

    @pytest.mark.parametrize(("others", "stays"), [(3, True), (4, False)])
    def test_the_oldest_leaves_when_a_new_one_finds_no_room(self, others: int, stays: bool) -> None:
        story = [(0, 10, 10), *[(0, 30, 30)] * others, (0, 11, 11)]
        assert (len(story) - 1 in run_story(recent_filter(depth=4), story)) == stays

    @pytest.mark.parametrize("corner", [(0, 0), (31, 0), (0, 31), (31, 31)])
    def test_the_border_is_no_neighbour(self, corner: tuple[int, int]) -> None:
        x, y = corner
        assert run_story(recent_filter(radius=15), [(0, x, y), (0, 31 - x, y), (0, x, 31 - y), (0, 31 - x, 31 - y)]) == []

    def test_a_skipped_event_is_not_remembered(self) -> None:
        device = recent_filter()
        keep = device.stream(ticked(0, [10, 11], [10, 11]), np.array([False, True]))
        assert not keep.any()

    def test_not_enabled_it_hands_on_and_leaves_its_memory_alone_but_time_passes(self) -> None:
        device = recent_filter(ticks=20)
        assert run_story(device, [(0, 10, 10)]) == []
        device.set(enable=0)
        assert run_story(device, [(5, 20, 20)]) == [0]
        device.set(enable=1)
        assert run_story(device, [(1, 21, 21), (15, 11, 11), (16, 8, 9)]) == [1]  # 20, 20 never came; now 10, 10 is too old

    @pytest.mark.parametrize("step", [1, 31, 32, 33, 64, 4096])
    def test_no_wait_makes_an_old_event_new(self, step: int) -> None:
        """Stamps have 6 bits. The wait is for events elsewhere, a `step` apart, and then for the one that counts."""
        device = recent_filter(ticks=31)
        waits = [*range(28, 70), *range(90, 100), *range(120, 160), 255, 256, 257, 511, 512, 513, 1024, 4096]
        stays = []
        for wait in waits:
            device.reset()
            story = [(7, 10, 10), *[(7 + k * step, 30, 30) for k in (1, 2, 3) if k * step < wait], (7 + wait, 11, 11)]
            stays += [wait] * (len(story) - 1 in run_story(device, story))
        assert stays == [28, 29, 30, 31]


@pytest.mark.parametrize(
    ("depth", "stamp_w", "tick_w"), [(1, 4, 20), (3, 5, 1), (7, 8, 3), (32, 20, 20), (64, 12, 8)], ids=lambda value: str(value)
)
def test_random_registers_traffic_and_stalls_are_exact(depth: int, stamp_w: int, tick_w: int) -> None:
    """One long life: runs with other registers, some of them disabled, on one memory."""
    print("seed 61")
    rng = np.random.default_rng([61, depth])
    device, memory, kept = recent_filter(depth, stamp_w, tick_w, x_w=7), Memory(depth), []
    longest = min(5 << stamp_w, 400 << tick_w)
    for run in range(14):
        device.stall(Stalls.random(rng) if run % 3 == 1 else Stalls())
        ticks = min(int(2 ** rng.uniform(2, stamp_w - 1)), (1 << (stamp_w - 1)) - 1)
        radius = int(rng.integers(1, 16))
        support = int(rng.integers(1, 2 + depth // 8))
        device.set(enable=int(run % 5 != 4), recent_ticks=ticks, recent_radius=radius, recent_support=support)
        traffic = filter_traffic(
            rng, 16_000, 100, 32, ticks_per_event=float(rng.choice([0.5, ticks / 4])), longest_gap=longest, gaps=0.02,
            first_tick=device.now,
        )  # fmt: skip

        def wanted(batch: FilterTraffic, registers: tuple[int, int, int] = (ticks, radius, support)) -> NDArray[np.bool_]:
            return memory.judge(batch, *registers) if device.sim.io.enable else batch.keep

        kept.append(compare_with_reference(device, traffic, wanted))
    enabled = [part for run, part in enumerate(kept) if run % 5 != 4]
    print(enabled)
    assert min(enabled) < 0.6
    assert max(enabled) > 0.25


def test_a_token_every_clock_six_clocks_later() -> None:
    traffic = filter_traffic(np.random.default_rng(62), 1000, 32, 32)
    _, times = recent_filter().stream_timed(traffic, traffic.keep)
    assert (np.diff(times.accepted) == 1).all()
    assert (times.given - times.accepted == 6).all()


def test_reset_amid_events_leaves_nothing() -> None:
    check_reset_amid_events(recent_filter())


def test_reset_forgets_all_events() -> None:
    device = recent_filter()
    assert run_story(device, [(0, 10, 10), (0, 11, 11)]) == [1]
    device.reset()
    assert device.settled_after == 0
    assert run_story(device, [(0, 12, 12)]) == []
    device.set(s_valid=1, s_event=1, m_ready=0)
    device.sim.clock.tick()
    device.set(s_valid=0)
    for _ in range(4):
        assert device.sim.io.idle == 0
        device.sim.clock.tick()
    device.reset()
    assert (device.sim.io.idle, device.sim.io.m_valid) == (1, 0)
