# SPDX-License-Identifier: Apache-2.0
"""hough_lines.v, with hough_angle.v in it, against its golden model: stories, random traffic under stalls, resets."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.hough.contract import HoughConfig
from evcot.hough.transform import HoughTransform
from support.stream_device import Bundle, StreamDevice, StreamRun, check_reset, random_stalls
from support.testing import EXHAUSTIVE

TOP = "hough_lines"
TOKEN = ("tick", "event", "skip", "x", "y", "p")
IN, OUT = Bundle("s_", TOKEN), Bundle("m_", ("tick", "event", "skip", "angle", "rho", "x", "y", "p"))
LATENCY = 8
LEAST_STORIES = HoughConfig(32, 24, leak_log2=9)

Words = NDArray[np.uint64]


def device_of(config: HoughConfig, tick_w: int = 20, x_w: int = 0, y_w: int = 0) -> StreamDevice:
    sizes = {"X_W": x_w or config.width.bit_length(), "Y_W": y_w or config.height.bit_length(), "TICK_W": tick_w}
    shape = {"WIDTH": config.width, "HEIGHT": config.height, "ANGLES": config.angles}
    ports = {"leak_log2": config.leak_log2}
    return StreamDevice(TOP, sizes | shape, inputs=[IN], outputs=[OUT], ports=ports, has_idle=True)


def expected(model: HoughTransform, tokens: Words) -> Words:
    """What the hardware must send, without angle and rho where there is no spike."""
    found = np.zeros((len(tokens), len(OUT.fields)), np.uint64)
    found[:, [0, 5, 6, 7]] = tokens[:, [0, 3, 4, 5]]
    (events,) = np.nonzero(tokens[:, 1])
    first = model.events
    spikes = model.feed(tokens[events, 3].astype(np.uint16), tokens[events, 4].astype(np.uint16))
    found[:, 2] = tokens[:, 2] | tokens[:, 1]
    at = events[spikes["event"] - first]
    found[at, 1], found[at, 2] = 1, tokens[at, 2]
    found[at, 3], found[at, 4] = spikes["angle"], spikes["rho"]
    return found


def meant(run: StreamRun) -> Words:
    """What the hardware sent, without angle and rho where there is no spike."""
    words = run.words["m_"].copy()
    words[words[:, 1] == 0, 3:5] = 0
    return words


def tokens_of(x: list[int], y: list[int]) -> Words:
    """Events without ticks."""
    words = np.zeros((len(x), len(TOKEN)), np.uint64)
    words[:, 1], words[:, 3], words[:, 4] = 1, x, y
    return words


def random_tokens(rng: np.random.Generator, config: HoughConfig, count: int, x_w: int, y_w: int, tick_w: int) -> Words:
    """Events on a few lines and on single pixels, noise, events outside the sensor, and tokens without an event."""
    words = np.zeros((count, len(TOKEN)), np.uint64)
    words[:, 0] = rng.integers(0, 1 << tick_w, count)
    kind = rng.random(count)
    words[:, 1] = kind < 0.9
    words[:, 2] = rng.random(count) < 0.1
    words[:, 5] = rng.integers(0, 2, count)
    x, y = rng.integers(0, config.width, count), rng.integers(0, config.height, count)
    angle = np.repeat(rng.uniform(0, np.pi, -(-count // 200)), 200)[:count]
    along = rng.uniform(-0.5, 0.5, count) * min(config.width, config.height)
    on_line = kind < 0.6
    x = np.where(on_line, np.rint(config.width / 2 + along * np.cos(angle)), x)
    y = np.where(on_line, np.rint(config.height / 2 + along * np.sin(angle)), y)
    for distance in (1, 2, 3, 4):  # the pixel of a token just ahead
        same = np.flatnonzero(rng.random(count) < 0.1)
        same = same[same >= distance]
        x[same], y[same] = x[same - distance], y[same - distance]
    outside = rng.random(count) < 0.03
    words[:, 3] = np.clip(np.where(outside, rng.integers(0, 1 << x_w, count), x), 0, (1 << x_w) - 1)
    words[:, 4] = np.clip(np.where(outside, rng.integers(0, 1 << y_w, count), y), 0, (1 << y_w) - 1)
    return words


class TestStories:
    def test_the_eighth_event_of_a_column_is_a_spike_of_angle_0(self) -> None:
        device = device_of(LEAST_STORIES)
        run = device.run({"s_": tokens_of([20] * 9, list(range(3, 21, 2)))})
        words = meant(run)
        assert words[:, 1].tolist() == [0] * 7 + [1, 0]
        assert words[:, 2].tolist() == [1] * 7 + [0, 1]
        # The middle of 32 columns is 15.5; column 20 lies 4.5 px from there, in cell 4 of those above the middle one, 32.
        assert words[7, 3:].tolist() == [0, 32 + 4, 20, 17, 0]

    def test_the_eighth_event_of_a_row_is_a_spike_of_a_quarter_turn(self) -> None:
        device = device_of(LEAST_STORIES)
        words = meant(device.run({"s_": tokens_of(list(range(4, 28, 3)), [5] * 8)}))
        # The middle of 24 rows is 11.5; row 5 lies 6.5 px before it, in cell -7.
        assert words[7].tolist() == [0, 1, 0, 8, 32 - 7, 25, 5, 0]

    def test_a_spike_empties_all_cells_of_its_event(self) -> None:
        """Eight events of one pixel charge the cells of all angles alike; after the spike none fires for seven events."""
        device = device_of(LEAST_STORIES)
        words = meant(device.run({"s_": tokens_of([9] * 24, [9] * 24)}))
        assert np.flatnonzero(words[:, 1]).tolist() == [7, 15, 23]
        assert words[7, 3] == 0, "the lowest angle"

    def test_each_cell_loses_one_hit_per_period(self) -> None:
        """Of the four events in a period, two are of one column: it gains one hit per period, and fires with the eighth."""
        device = device_of(HoughConfig(32, 24, leak_log2=2))
        far = [(0, 0), (31, 23), (0, 23), (31, 0), (0, 11), (31, 9)]  # none of their lines gathers eight hits
        x, y = [], []
        for period in range(8):
            x += [20, 20, far[2 * period % 6][0], far[(2 * period + 1) % 6][0]]
            y += [(3 * period) % 24, (3 * period + 1) % 24, far[2 * period % 6][1], far[(2 * period + 1) % 6][1]]
        words = meant(device.run({"s_": tokens_of(x, y)}))
        assert np.flatnonzero(words[:, 1])[:1].tolist() == [4 * 6 + 1]
        assert words[25, 3:5].tolist() == [0, 36]

    def test_events_outside_the_sensor_are_dropped_and_hit_nothing(self) -> None:
        device = device_of(HoughConfig(20, 20, leak_log2=9))
        x, y = [9] * 7 + [20, 9, 9], [9] * 7 + [9, 31, 9]
        words = meant(device.run({"s_": tokens_of(x, y)}))
        assert words[:, 1].tolist() == [0] * 9 + [1]
        assert words[:, 2].tolist() == [1] * 9 + [0]


SHAPES = [
    (HoughConfig(346, 260), 9, 9, 20),
    (HoughConfig(29, 22, leak_log2=2), 6, 5, 1),
    (HoughConfig(64, 48, angles=32, leak_log2=3), 6, 6, 8),
    (HoughConfig(5, 3, leak_log2=4), 16, 16, 32),
    (HoughConfig(1280, 720, leak_log2=7), 11, 10, 4),
]
EVENTS = 1_000_000 if EXHAUSTIVE else 20_000


@pytest.mark.parametrize(("config", "x_w", "y_w", "tick_w"), SHAPES, ids=lambda value: getattr(value, "width", None))
def test_random_traffic_is_exact_under_stalls_and_resets(config: HoughConfig, x_w: int, y_w: int, tick_w: int) -> None:
    print("seed 5501")
    device = device_of(config, tick_w, x_w, y_w)
    spikes = 0
    for run in range(4):
        rng = np.random.default_rng([5501, run])
        model = HoughTransform(config)
        device.reset()
        device.stalls = random_stalls(rng, ("s_", "m_")) if run else {}
        tokens = random_tokens(rng, config, EVENTS, x_w, y_w, tick_w)
        for part in np.array_split(tokens, 3):
            found, wanted = meant(device.run({"s_": part})), expected(model, part)
            (wrong,) = np.nonzero((found != wanted).any(1)) if len(found) == len(wanted) else ([len(found)],)
            assert len(wrong) == 0, f"run {run}, token {wrong[0]}: {found[wrong[0]]}, not {wanted[wrong[0]]}"
            spikes += int(wanted[:, 1].sum())
    assert 0.01 < spikes / (4 * EVENTS) < 0.3


def test_a_reset_at_any_moment_leaves_nothing_behind() -> None:
    print("seed 5502")
    config = HoughConfig(29, 22, leak_log2=3)
    device = device_of(config, x_w=6)
    for run in range(20):
        rng = np.random.default_rng([5502, run])
        device.stalls = random_stalls(rng, ("s_", "m_"))
        tokens = random_tokens(rng, config, 600, 6, 5, 20)
        device.run({"s_": tokens}, clocks=int(rng.integers(80, 500)))
        device.reset()
        found = meant(device.run({"s_": tokens}))
        assert np.array_equal(found, expected(HoughTransform(config), tokens)), run


def test_reset_amid_tokens_leaves_nothing_to_come_out() -> None:
    device = device_of(LEAST_STORIES)
    check_reset(device, {"s_": random_tokens(np.random.default_rng(1), LEAST_STORIES, 300, 6, 5, 20)}, clocks=200)


def test_a_token_takes_8_clocks_and_one_enters_per_clock() -> None:
    config = HoughConfig(346, 260)
    device = device_of(config)
    run = device.run({"s_": random_tokens(np.random.default_rng(1), config, 500, 9, 9, 20)})
    assert np.diff(run.accepted["s_"]).max() == 1
    assert set((run.given["m_"] - run.accepted["s_"]).tolist()) == {LATENCY}
    assert run.accepted["s_"][0] <= (1 << config.rho_w) + 6
