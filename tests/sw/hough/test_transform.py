# SPDX-License-Identifier: Apache-2.0
"""The model of the line transform: stories worked out by hand, and a slow model written from docs/lines.md alone."""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.hough.contract import COSINES, HoughConfig
from evcot.hough.transform import HoughTransform


def spikes_of(config: HoughConfig, x: list[int], y: list[int]) -> list[tuple[int, int, int]]:
    found = HoughTransform(config).feed(np.array(x, np.uint16), np.array(y, np.uint16))
    return [(int(spike["event"]), int(spike["angle"]), int(spike["rho"])) for spike in found]


def rows_of(config: HoughConfig, x: int, y: int) -> list[int]:
    """The cell of each angle."""
    quarter, step = config.angles // 2, 32 // config.angles
    u, v = 2 * x - (config.width - 1), 2 * y - (config.height - 1)
    rows = []
    for k in range(config.angles):
        share_x = (u * COSINES[step * min(k, config.angles - k)]) >> 6
        share_y = (v * COSINES[step * abs(quarter - k)]) >> 6
        rho = share_x + share_y if k <= quarter else share_y - share_x
        rows.append((rho >> 3) + 2 ** (config.rho_w - 1))
    return rows


def slow_spikes(config: HoughConfig, x: list[int], y: list[int]) -> list[tuple[int, int, int]]:
    """Word by word as docs/lines.md has it."""
    cells = [[(0, 0)] * 2**config.rho_w for _ in range(config.angles)]
    found, n = [], 0
    for event, (at_x, at_y) in enumerate(zip(x, y, strict=True)):
        if at_x >= config.width or at_y >= config.height:
            continue
        period, rows = n >> config.leak_log2, rows_of(config, at_x, at_y)
        n += 1
        words = [cells[k][row] for k, row in enumerate(rows)]
        hits = [1 + max(left - (period - then) % 512, 0) for left, then in words]
        fire = [k for k, count in enumerate(hits) if count == 8]
        if fire:
            found.append((event, fire[0], rows[fire[0]]))
        for k, row in enumerate(rows):
            cells[k][row] = (0 if fire else hits[k], period)
    return found


def random_events(rng: np.random.Generator, config: HoughConfig, count: int) -> tuple[list[int], list[int]]:
    """Half on lines, half anywhere, some of them outside."""
    angle = np.repeat(rng.uniform(0, pi, count // 100), 100)
    along = rng.uniform(-0.5, 0.5, len(angle)) * min(config.width, config.height)
    anywhere = rng.random(len(angle)) < 0.5
    x = np.where(anywhere, rng.integers(0, config.width + 3, len(angle)), config.width / 2 + along * np.cos(angle))
    y = np.where(anywhere, rng.integers(0, config.height + 3, len(angle)), config.height / 2 + along * np.sin(angle))
    return x.astype(int).tolist(), y.astype(int).tolist()


def test_the_eighth_event_of_a_column_is_a_spike() -> None:
    """The middle of 32 columns is 15.5; column 20 lies 4.5 px from there, in cell 4 of those above the middle one, 32."""
    config = HoughConfig(32, 24, leak_log2=9)
    assert spikes_of(config, [20] * 16, list(range(3, 19))) == [(7, 0, 36), (15, 0, 36)]


def test_a_cell_loses_one_hit_per_period() -> None:
    """Of 4 events in a period, 2 hit column 20: 2, 3, 4, 5, 6, 7, 8 hits after the seven first periods."""
    x = [20, 20, 0, 31] * 8
    y = [(5 * i) % 24 if x[i] == 20 else 23 * (i // 4 % 2) for i in range(len(x))]
    assert spikes_of(HoughConfig(32, 24, leak_log2=2), x, y)[0] == (25, 0, 36)


@pytest.mark.parametrize(
    "config",
    [HoughConfig(40, 30, leak_log2=2), HoughConfig(346, 260, leak_log2=4), HoughConfig(64, 64, 32, leak_log2=3)],
    ids=lambda config: f"{config.width}x{config.height}, {config.angles} angles",
)
def test_the_slow_model_agrees_however_events_are_split(config: HoughConfig) -> None:
    print("seed 5503")
    rng = np.random.default_rng(5503)
    x, y = random_events(rng, config, 6_000)  # with periods of 4 events, words wrap after 2048
    wanted = slow_spikes(config, x, y)
    assert len(wanted) > 30
    assert spikes_of(config, x, y) == wanted
    model, parts = HoughTransform(config), []
    for begin, end in zip([0, *(cuts := np.sort(rng.integers(0, len(x), 9)))], [*cuts, len(x)], strict=True):
        parts.append(model.feed(np.array(x[begin:end], np.uint16), np.array(y[begin:end], np.uint16)))
    assert [tuple(map(int, spike)) for spike in np.concatenate(parts)] == wanted
    assert model.events == len(x)


@pytest.mark.parametrize("sensor", [(1, 1), (346, 260), (640, 480), (1280, 720), (2048, 2048), (2048, 1), (500, 118)])
def test_rho_is_that_of_the_line_and_fits_the_memory(sensor: tuple[int, int]) -> None:
    config = HoughConfig(*sensor)
    width, height = sensor
    for x, y in [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1), (width // 3, height // 5)]:
        for k, row in enumerate(rows_of(config, x, y)):
            angle = k * pi / config.angles
            rho = (x - (width - 1) / 2) * cos(angle) + (y - (height - 1) / 2) * sin(angle)
            assert 0 <= row < 2**config.rho_w
            assert abs(row - 2 ** (config.rho_w - 1) + 0.5 - rho) <= 0.8 + hypot(width, height) / 1024
    assert 2**config.rho_w < 2 * hypot(width + 8, height + 8)


def test_the_table_is_that_of_cosines() -> None:
    table: NDArray[np.float64] = np.array(COSINES) / 256
    assert np.allclose(table, np.cos(np.arange(17) * np.pi / 32), atol=1 / 512)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("width", 0, "hough.width = 0: must be from 1 to 2048 (pixels of the sensor across)"),
        ("height", 2049, "hough.height = 2049: must be from 1 to 2048 (pixels of the sensor down)"),
        ("angles", 24, "hough.angles = 24: must be 16 or 32"),
        ("angles", 64, "hough.angles = 64: must be from 16 to 32 (angles in half a turn, 16 or 32)"),
        ("leak_log2", 1, "hough.leak_log2 = 1: must be from 2 to 9 (log2 of the events in which each cell loses one hit)"),
        ("leak_log2", 4.0, "hough.leak_log2 = 4.0: must be from 2 to 9 (log2 of the events in which each cell loses one hit)"),
    ],
)
def test_a_configuration_outside_the_contract_is_refused(field: str, value: object, message: str) -> None:
    with pytest.raises(ConfigError) as error:
        HoughConfig(**{field: value})  # type: ignore[arg-type]
    assert str(error.value) == message
