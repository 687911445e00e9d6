# SPDX-License-Identifier: Apache-2.0
"""Register accesses and events for `evcot_top`, and the beats that the golden model expects, as arrays and as files."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from importlib.resources import files as package_files
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.errors import ConfigError, RecordingError
from evcot.events import Recording
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.golden import golden_model
from evcot.hardware.streams import pack, pack_events
from evcot.ticks import TickedEvents
from evcot.trackers.config import RunConfig

from ..devices.base import check_addresses
from ..devices.top_device import Command, Op, address_of, configuration, parameters_of, poll_status, write
from ..rtl.files import verilog_dir

__all__ = ["FILES", "Access", "Vectors"]

BENCH = "vectors_tb.v"
FILES = ("accesses.hex", "events.hex", "owned.hex", "passed.hex", "records.hex", "vectors.json", "vectors.vh", BENCH, "rtl.f")
"""Names of the files of `Vectors.files`."""

_DATA_W = 64  # bits of a beat of m_axis_records
_SOFT_RESET = 1 << 9  # of the word `control`
_GAP_MAX_US = 1 << 31  # between two events: half the range of the time in an event's word


class Access(NamedTuple):
    """One access to the registers of `evcot_top`. It begins when those before it are done and `after` events are accepted.

    Attributes:
        after: events; event `after` is offered when the access is done.
        poll: False: write `data` at `address`. True: read `address` until the bits of `mask` are those of `data`.
        address: in bytes.
        mask: of a poll; of a write 0.
        data: 32 bits.
    """

    after: int
    poll: bool
    address: int
    mask: int
    data: int


@dataclass(frozen=True, eq=False)
class Vectors:
    """What goes into an `evcot_top`, and what must come out of it, beat by beat.

    Each output keeps its order under every pattern of stalls. Between outputs there is no order.

    Attributes:
        config: of the hardware.
        parameters: Verilog parameters with which `evcot_top` must be built; others may have any value.
        accesses: configure the hardware, enable it, and wait at the end until everything has been processed.
        events: (n,) uint64, beats of `s_axis`.
        owned, passed: (k,) uint64, beats of `m_axis_owned` and `m_axis_passed`.
        records: (m, b) uint64, beats of `m_axis_records`; b is 7 for cot_motion and 6 for cot_array, tlast in the last of them.
    """

    config: CotConfig | MotionConfig
    parameters: dict[str, int]
    accesses: tuple[Access, ...]
    events: NDArray[np.uint64]
    owned: NDArray[np.uint64]
    passed: NDArray[np.uint64]
    records: NDArray[np.uint64]

    @classmethod
    def of(cls, recording: Recording, config: RunConfig) -> Vectors:
        """Vectors of a recording; tick 0 is the time of its first event.

        Example:
            recording = evcot.simulate("discs", 3, duration_us=60_000).recording
            vectors = evcot_cosim.Vectors.of(recording, evcot.run_config(recording.width, recording.height))

        Args:
            config: gives hardware and filters; as `evcot.run_config` returns it.

        Raises:
            RecordingError: no events, or a gap of more than half an hour.
            ConfigError: hardware other than cot_array and cot_motion, or one whose addresses are too narrow.
        """
        if config.hardware.module not in ("cot_array", "cot_motion"):
            rule = "must be cot_array or cot_motion for vectors: of other hardware the order of beats depends on stalls"
            raise ConfigError(f"hardware = {config.hardware.module!r}: {rule}")
        check_addresses((recording.width, recording.height), config.hardware, recording.name)
        events, sensor = recording.events, (recording.width, recording.height)
        if not len(events):
            raise RecordingError(f"{recording.name}: holds no events")
        gaps_us = np.diff(events.t_us)
        if len(gaps_us) and gaps_us.max() > _GAP_MAX_US:
            at = int(gaps_us.argmax())
            rule = f"must be at most {_GAP_MAX_US} for vectors; take a part without it (--from, --to)"
            raise RecordingError(f"{recording.name}: event {at + 1}: a gap of {gaps_us[at]} us: {rule}")
        hardware = replace(config.device_config(*sensor), filter_shape=config.filters.shape(*sensor))
        decided = golden_model(hardware).feed(TickedEvents.of(events, hardware.tick_us))
        owned, passed = np.flatnonzero(decided.owner >= 0), np.flatnonzero(decided.owner == -1)
        return cls(
            config=hardware,
            parameters={"HAS": hardware.filters.enable, "DATA_W": _DATA_W, **parameters_of(hardware)},
            accesses=tuple(_accesses(hardware, len(events))),
            events=pack_events(events.t_us, events.x, events.y, events.p),
            owned=pack("owned", {
                "x": decided.rel_x[owned], "y": decided.rel_y[owned], "slot": decided.owner[owned], "p": events.p[owned],
                "seq": owned,
            }),
            passed=pack("passed", {
                "x": events.x[passed], "y": events.y[passed], "p": events.p[passed], "seq": passed,
            }),
            records=_beats(decided.records),
        )  # fmt: skip

    def files(self) -> dict[str, str]:
        """The text of each file of `evcot vectors` by its name: see docs/vectors.md."""
        accesses = (f"{a.after:08x}_{int(a.poll)}_{a.address:04x}_{a.mask:08x}_{a.data:08x}" for a in self.accesses)
        counts = {
            "N_ACCESSES": len(self.accesses), "N_EVENTS": len(self.events), "N_OWNED": len(self.owned),
            "N_PASSED": len(self.passed), "N_RECORDS": len(self.records), "RECORD_BEATS": self.records.shape[1],
        }  # fmt: skip
        values = self.parameters | counts
        described = {"module": "evcot_top", "tracker": self.config.module, "parameters": self.parameters, "counts": counts}
        texts = (
            _lines(accesses), _hex(self.events), _hex(self.owned), _hex(self.passed), _hex(self.records.ravel()),
            json.dumps(described, indent=2) + "\n",
            _lines(["// Parameters of evcot_top and lengths of the files beside this one.",
                    *(f"localparam {name} = {value};" for name, value in values.items())]),
            (package_files(__package__) / BENCH).read_text(encoding="utf-8"),
            _lines([*(f"{flag}{folder}" for folder in _folders() for flag in ("-y ", "+incdir+")), BENCH]),
        )  # fmt: skip
        return dict(zip(FILES, texts, strict=True))


def _accesses(config: CotConfig | MotionConfig, n_events: int) -> Iterable[Access]:
    commands: list[Command] = []
    if config.tick_us != 1:
        commands = [write(address_of("tick_us"), config.tick_us), write(address_of("control"), _SOFT_RESET)]
    commands += [*configuration(config), poll_status("pending", 0), write(address_of("control"), 1)]
    commands.append(poll_status("idle", 1, after=n_events))
    for after, op, address, data, mask in commands:
        yield Access(after, op == Op.POLL, address, mask if op == Op.POLL else 0, data)


def _beats(records: NDArray[np.void]) -> NDArray[np.uint64]:
    """The beats of each record, (m, b): its bytes, with zeros for the padding at its end."""
    clean = np.zeros(len(records), records.dtype)
    for name in records.dtype.names or ():
        clean[name] = records[name]
    return np.ascontiguousarray(clean).view(np.dtype("<u8")).reshape(len(records), records.dtype.itemsize * 8 // _DATA_W)


def _hex(words: NDArray[np.uint64]) -> str:
    return _lines(f"{word:016x}" for word in words.tolist())


def _lines(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _folders() -> list[str]:
    """The folders of the RTL."""
    return sorted({str(path.parent) for path in verilog_dir().rglob("*.v*")})
