# SPDX-License-Identifier: Apache-2.0
"""The published tracker: cycle-exact golden model of `cot_published.v` and `cot_published_chain.v`.

docs/published.md is the contract of all three. For trackers without the published hardware's quirks see `evcot.hardware.cot`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigError, RecordingError
from ...ranges import Range, check_ranges
from ._bench import BENCH_FIELDS, CLOCK, PASSED, WORDS, play
from ._kernel import CASCADE_FIELDS, ENABLE, LIBRARY_LINE, NOBODY, REGISTER_NAMES, SELECTED, TRACKER_FIELDS, run, run_one
from .registers import REGISTERS as MAP
from .registers import SELECT, SELECT_FIRST, SELECT_NONE, TRACKERS

__all__ = [
    "CASCADE_INPUT",
    "CASCADE_OUTPUT",
    "REGISTERS",
    "SELECT",
    "SELECT_FIRST",
    "SELECT_NONE",
    "TRACKER_INPUT",
    "TRACKER_OUTPUT",
    "WORD",
    "Handshakes",
    "Played",
    "PublishedCascade",
    "PublishedConfig",
    "PublishedTracker",
    "decode",
]

# Register -> first address, bytes (low byte first).
REGISTERS = {name: (register.address, register.n_bytes) for name, register in MAP.items()}

_CLOCKS = 1 << 48  # limit of a run: two months at 50 MHz

_RANGES: dict[str, Range] = {
    name: (register.low, register.high, register.meaning) for name, register in MAP.items() if name != "enable"
}


@dataclass(frozen=True)
class PublishedConfig:
    """The registers of one published tracker; the defaults are those of tracker 0 after reset, except that it is enabled.

    Raises:
        ConfigError: a field is outside its range.
    """

    init_cm_low: int = MAP["init_cm_low"].resets[0]
    init_cm_high: int = MAP["init_cm_high"].resets[0]
    radix_th: int = MAP["radix_th"].resets[0]
    init_radix: int = MAP["init_radix"].resets[0]
    max_time: int = MAP["max_time"].resets[0]
    nev_th: int = MAP["nev_th"].resets[0]
    hist_avg: int = MAP["hist_avg"].resets[0]
    enable: bool = True
    radix_step: int = MAP["radix_step"].resets[0]
    radix_max: int = MAP["radix_max"].resets[0]
    radix_min: int = MAP["radix_min"].resets[0]

    def __post_init__(self) -> None:
        check_ranges("published", self, _RANGES)
        if not isinstance(self.enable, bool):
            raise ConfigError(f"published.enable = {self.enable!r}: must be true or false")

    def writes(self, tracker: int) -> list[tuple[int, int]]:
        """(address, data) of all writes that configure tracker 0 to 3, from its selection on; `SELECT_NONE` deselects it."""
        found = [(SELECT, SELECT_FIRST + tracker)]
        for name, (address, n_bytes) in REGISTERS.items():
            value = 255 * self.enable if name == "enable" else int(getattr(self, name))
            found += [(address + i, value >> 8 * i & 255) for i in range(n_bytes)]
        return found


# The ports of cot_published.v and of cot_published_chain.v at one clock; a payload without a request reads 0.
TRACKER_INPUT = np.dtype(
    [(name, "u1") for name in ("rst", "s_req_n", "s_high", "s_low", "m_pass_ack_n", "m_event_ack_n", "m_centre_ack_n")]
)
TRACKER_OUTPUT = np.dtype(
    [("s_ack_n", "u1")]
    + [(f"m_{port}_{line}", "u1") for port in ("pass", "event", "centre") for line in ("req_n", "high", "low")]
)
CASCADE_INPUT = np.dtype(
    [
        (name, "u1")
        for name in ("rst", "cfg_valid", "cfg_addr", "cfg_data", "s_req_n", "s_high", "s_low", "m_ack_n", "m_pass_ack_n")
    ]
)
CASCADE_OUTPUT = np.dtype(
    [
        ("s_ack_n", "u1"),
        ("m_req_n", "u1"),
        ("m_word", "<u4"),
        ("m_pass_req_n", "u1"),
        ("m_pass_high", "u1"),
        ("m_pass_low", "u1"),
    ]
)

# The fields of an output word: tracker, whether it is an event of the cluster (else its centre), and the address.
WORD = np.dtype([("tracker", "u1"), ("event", "?"), ("high", "u1"), ("low", "u1")])


def decode(words: NDArray[Any]) -> NDArray[np.void]:
    """Decode 25-bit output words, (n,) integers, to (n,) WORD."""
    words = np.asarray(words, np.int64)
    decoded = np.zeros(words.shape, WORD)
    decoded["tracker"] = words >> 17 & 3
    decoded["event"] = words & 1
    decoded["high"] = words >> 9 & 255
    decoded["low"] = words >> 1 & 255
    return decoded


def _idle(dtype: np.dtype[np.void], n: int) -> NDArray[np.void]:
    """n clocks without any request or acknowledge."""
    rows = np.zeros(n, dtype)
    for name in dtype.names or ():
        if name.endswith("_n"):
            rows[name] = 1
    return rows


@dataclass(frozen=True)
class Handshakes:
    """Delays of the other side of each port, in clocks: (m,) int64 each, repeated from the start.

    Attributes:
        release: delay of the sender's release of the request after the acknowledge; 0 is at the next edge.
        ack: delay of the acknowledge by the receiver of words; 0 is within the same clock.
        pass_ack: the same for the receiver of passed events.
    """

    release: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, np.int64))
    ack: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, np.int64))
    pass_ack: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, np.int64))

    def __post_init__(self) -> None:
        for name in ("release", "ack", "pass_ack"):
            pattern = np.ascontiguousarray(getattr(self, name), np.int64)
            if pattern.ndim != 1 or not len(pattern) or pattern.min() < 0:
                raise ConfigError(f"handshakes.{name}: must be a sequence of at least one number of clocks, none negative")
            object.__setattr__(self, name, pattern)


class Played(NamedTuple):
    """The result of a run of n events; clocks are counted from reset.

    Attributes:
        acknowledged: (n,) int64, clock at which the sender saw the acknowledge of each event.
        word_clock, word: (m,) int64, clock at which each output word was taken, and the word: see `decode`.
        pass_clock, pass_high, pass_low: (k,) int64, the events that no tracker took.
        inputs, outputs: CASCADE_INPUT and CASCADE_OUTPUT of every clock, if requested; else empty.
    """

    acknowledged: NDArray[np.int64]
    word_clock: NDArray[np.int64]
    word: NDArray[np.int64]
    pass_clock: NDArray[np.int64]
    pass_high: NDArray[np.int64]
    pass_low: NDArray[np.int64]
    inputs: NDArray[np.void]
    outputs: NDArray[np.void]


class PublishedTracker:
    """Cycle-exact model of one tracker, `cot_published.v`, from reset.

    Args:
        config: its registers; `enable` is ignored here.
    """

    def __init__(self, config: PublishedConfig) -> None:
        self.config = config
        self._registers = np.array([int(getattr(config, name)) for name in REGISTER_NAMES], np.int64)
        self._state = np.zeros(TRACKER_FIELDS, np.int64)

    def clocks(self, inputs: NDArray[np.void]) -> NDArray[np.void]:
        """The output ports just before each of n clock edges: (n,) TRACKER_OUTPUT for (n,) TRACKER_INPUT."""
        outputs = np.zeros(len(inputs), TRACKER_OUTPUT)
        run_one(self._state, self._registers, inputs, outputs)
        return outputs


class PublishedCascade:
    """Cycle-exact model of four trackers with registers and output line, `cot_published_chain.v`, from reset.

    Args:
        configs: registers of up to four trackers, in order; the remaining trackers stay disabled.
        library_line: True: the published library as a whole, whose line keeps each event for 5 clocks or longer, so that
            the average is updated with it as often. False: its trackers by themselves, on a line without delay.

    Raises:
        ConfigError: more than four trackers.
    """

    def __init__(self, configs: Sequence[PublishedConfig] = (), *, library_line: bool = True) -> None:
        if len(configs) > TRACKERS:
            raise ConfigError(f"{len(configs)} published trackers: must be at most {TRACKERS}, the cascade's length")
        self._cascade = np.zeros(CASCADE_FIELDS, np.int64)
        self._cascade[LIBRARY_LINE] = library_line
        self._trackers = np.zeros((TRACKERS, TRACKER_FIELDS), np.int64)
        self._registers = np.zeros((TRACKERS, len(REGISTER_NAMES)), np.int64)
        self._clock = 0
        reset = _idle(CASCADE_INPUT, 1)
        reset["rst"] = 1
        self.clocks(reset)
        if configs:
            self.write([write for i, config in enumerate(configs) for write in config.writes(i)] + [(SELECT, SELECT_NONE)])
            self.clocks(_idle(CASCADE_INPUT, 1))  # INIT_CELL

    def write(self, writes: Sequence[tuple[int, int]]) -> None:
        """Perform register writes, (address, data), one per clock."""
        inputs = _idle(CASCADE_INPUT, len(writes))
        inputs["cfg_valid"] = 1
        inputs["cfg_addr"], inputs["cfg_data"] = np.array(writes, np.uint8).T
        self.clocks(inputs)

    def clocks(self, inputs: NDArray[np.void]) -> NDArray[np.void]:
        """The output ports just before each of n clock edges: (n,) CASCADE_OUTPUT for (n,) CASCADE_INPUT."""
        outputs = np.zeros(len(inputs), CASCADE_OUTPUT)
        run(self._cascade, self._trackers, self._registers, inputs, outputs)
        self._clock += len(inputs)
        return outputs

    @property
    def clock(self) -> int:
        """Clocks since reset."""
        return self._clock

    def play(
        self,
        clock: NDArray[np.integer[Any]],
        high: NDArray[np.integer[Any]],
        low: NDArray[np.integer[Any]],
        handshakes: Handshakes | None = None,
        *,
        trace: bool = False,
    ) -> Played:
        """Send events through 4-phase handshakes and collect the outputs, until the cascade is idle.

        Idle clocks are skipped, so real recordings at real clock rates are feasible. An event that arrives during an
        initialisation is acknowledged, but appears in no output; nor does one that is passed to a tracker that is still busy.

        Args:
            clock: (n,) earliest clock of each request, never decreasing; later if the cascade is busy.
            high, low: (n,) coordinates, 0 to 255.
            handshakes: delays of sender and receivers (default: none).
            trace: record the ports at every clock; idle clocks are then not skipped.

        Raises:
            ConfigError: a tracker is still selected.
            RecordingError: a coordinate is outside 0 to 255, or the clocks decrease.
        """
        if (selected := int(self._cascade[SELECTED])) != NOBODY and self._registers[selected, ENABLE]:
            raise ConfigError(
                f"tracker {selected} is selected: it would acknowledge forever; write {SELECT_NONE} to {SELECT} first"
            )
        clock, high, low = (np.ascontiguousarray(column, np.int64) for column in (clock, high, low))
        n = len(clock)
        if not n == len(high) == len(low):
            raise RecordingError(f"{n} clocks, {len(high)} high and {len(low)} low coordinates: must be as many of each")
        if n and not 0 <= clock[0] <= clock[-1] < _CLOCKS:
            raise RecordingError(f"events from clock {clock[0]} to {clock[-1]}: must be from 0 to {_CLOCKS - 1}")
        for name, column in (("high", high), ("low", low)):
            if len(beyond := np.flatnonzero((column < 0) | (column > 255))):
                raise RecordingError(f"event {beyond[0]}: {name} = {column[beyond[0]]}: must be from 0 to 255")
        if len(back := np.flatnonzero(np.diff(clock) < 0)):
            raise RecordingError(f"event {back[0] + 1}: clock {clock[back[0] + 1]} lies before that of the event before it")
        delays = handshakes or Handshakes()
        outcome = tuple(np.zeros(2 * (n + TRACKERS), np.int64) for _ in range(6))
        bench = np.zeros(BENCH_FIELDS, np.int64)
        bench[CLOCK] = self._clock
        inputs, outputs = [], []
        finished = n == 0
        while not finished:
            rows = 4096 if trace else 1
            at, out = _idle(CASCADE_INPUT, rows), np.zeros(rows, CASCADE_OUTPUT)
            finished, traced = play(
                bench, self._cascade, self._trackers, self._registers, (clock, high, low),
                (delays.release, delays.ack, delays.pass_ack), outcome, at, out, trace,
            )  # fmt: skip
            inputs.append(at[:traced])
            outputs.append(out[:traced])
        self._clock = int(bench[CLOCK])
        acknowledged, word_clock, word, *passed = outcome
        n_words, n_passed = int(bench[WORDS]), int(bench[PASSED])
        pass_clock, pass_high, pass_low = (column[:n_passed] for column in passed)
        return Played(
            acknowledged[:n],
            word_clock[:n_words],
            word[:n_words],
            pass_clock,
            pass_high,
            pass_low,
            np.concatenate([_idle(CASCADE_INPUT, 0), *inputs]),
            np.concatenate([np.zeros(0, CASCADE_OUTPUT), *outputs]),
        )
