# SPDX-License-Identifier: Apache-2.0
"""The table of figures, its file in the repository, and the detection of regressions."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from math import sqrt
from pathlib import Path
from statistics import fmean, median, variance

from evcot.errors import ConfigError
from evcot.outputs import written_aside

__all__ = [
    "LIMIT",
    "USUAL_SEEDS",
    "Figure",
    "Figures",
    "case_name",
    "growths",
    "load",
    "recorded_with",
    "save",
    "seed_noise",
    "smallest_loss",
]

LIMIT = 0.05
"""Tolerated growth, as a fraction."""

USUAL_SEEDS = 3
"""Seeds of place and route, by default."""

_FEW = {"luts": 8, "ffs": 8, "lut_rams": 8, "block_rams": 0, "multipliers": 0}
"""Tolerated growth of a small module, in units: renaming a signal may cost a few."""

_MEDIAN = 1.2533  # standard error of a median over that of a mean, normal distribution
_SURE = 2.0  # standard errors


@dataclass(frozen=True)
class Figure:
    """One row: a module at one size on one device.

    Attributes:
        key: hash of all inputs of the synthesis.
        luts, ffs, block_rams, lut_rams, multipliers: resources of the module alone, see `devices.Resources`.
        seeds: number of seeds tried, from 1 up.
        fmax_mhz: register-to-register Fmax for each seed that was placed and routed.
        misfit: the resource of which the device has too few, or the reason why a seed failed; empty on success.
    """

    module: str
    n: int | None
    device: str
    key: str
    luts: int
    ffs: int
    block_rams: int
    lut_rams: int
    multipliers: int
    seeds: int = 0
    fmax_mhz: tuple[float, ...] = ()
    misfit: str = ""

    @property
    def name(self) -> str:
        return f"{case_name(self.module, self.n)} {self.device}"

    @property
    def median_mhz(self) -> float | None:
        return median(self.fmax_mhz) if self.fmax_mhz else None

    @property
    def best_mhz(self) -> float | None:
        return max(self.fmax_mhz, default=None)


Figures = dict[str, Figure]
"""By name."""


def case_name(module: str, n: int | None) -> str:
    """A module with its size, if it has one."""
    return module if n is None else f"{module} N={n}"


def load(path: Path) -> Figures:
    """Read the figures in a file; none if there is no file.

    Raises:
        ConfigError: the file holds something else.
    """
    if not path.is_file():
        return {}
    try:
        rows = [Figure(**{**row, "fmax_mhz": tuple(row["fmax_mhz"])}) for row in json.loads(path.read_text())["figures"]]
    except (ValueError, KeyError, TypeError) as error:
        raise ConfigError(f"{path}: not a table of figures: {error}") from error
    return {row.name: row for row in rows}


def recorded_with(path: Path) -> str:
    """The version of Yosys with which the figures in a file were recorded.

    Raises:
        ConfigError: the file holds something else.
    """
    try:
        return str(json.loads(path.read_text())["tools"]["yosys"])
    except (ValueError, KeyError, TypeError) as error:
        raise ConfigError(f"{path}: not a table of figures: {error}") from error


def save(path: Path, figures: Figures, versions: Mapping[str, str]) -> None:
    """Write figures, one row per line, with the versions of the tools; a tool that is not named keeps its stored version."""
    stored = json.loads(path.read_text())["tools"] if path.is_file() else {}
    rows = [json.dumps(asdict(figure), ensure_ascii=False) for figure in figures.values()]
    text = f'{{\n"tools": {json.dumps({**stored, **versions}, indent=1)},\n"figures": [\n' + ",\n".join(rows) + "\n]\n}\n"
    with written_aside(path, force=True) as file:
        file.write(text.encode())


def seed_noise(figures: Iterable[Figure]) -> float:
    """Standard deviation of Fmax from seed to seed, as a fraction, over all cases with more than one seed; else 0.05."""
    spreads = [
        (len(row.fmax_mhz) - 1, variance(row.fmax_mhz) / fmean(row.fmax_mhz) ** 2) for row in figures if len(row.fmax_mhz) > 1
    ]
    freedom = sum(count for count, _ in spreads)
    return sqrt(sum(count * spread for count, spread in spreads) / freedom) if freedom else 0.05


@dataclass(frozen=True)
class Growth:
    """One regression."""

    name: str
    what: str
    before: str
    now: str
    change: float


def smallest_loss(noise: float, seeds: int, seeds_now: int | None = None) -> float:
    """The smallest significant decrease of a median over this number of seeds, as a fraction; at least `LIMIT`."""
    return max(LIMIT, _SURE * _MEDIAN * noise * sqrt(1 / seeds + 1 / (seeds_now or seeds)))


def growths(before: Figure, now: Figure, noise: float) -> list[Growth]:
    """Figures that are worse by more than `LIMIT`.

    A median Fmax must have fallen by more than the limit and by more than two standard errors of the difference of two
    medians, which chance exceeds in 1 of 40: any change of the netlist is like another set of seeds.
    """
    found = []
    for what, few in _FEW.items():
        old, new = getattr(before, what), getattr(now, what)
        if new > old * (1 + LIMIT) and new - old > few:
            found.append(Growth(now.name, what, f"{old:,}", f"{new:,}", new / old - 1 if old else float("inf")))
    if before.median_mhz and now.median_mhz:
        change = now.median_mhz / before.median_mhz - 1
        if -change > smallest_loss(noise, len(before.fmax_mhz), len(now.fmax_mhz)):
            found.append(Growth(now.name, "median Fmax", f"{before.median_mhz:.1f} MHz", f"{now.median_mhz:.1f} MHz", change))
    elif before.median_mhz and now.misfit:
        found.append(Growth(now.name, "fit", f"{before.median_mhz:.1f} MHz", now.misfit, float("-inf")))
    return found
