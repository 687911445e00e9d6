# SPDX-License-Identifier: Apache-2.0
"""The exact twin of hw/fpga/board_core.v: the settings of a board's self-test, and the signature that its records must give.

As a program it writes hw/fpga/board_selftest.vh.
"""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from numpy.typing import NDArray

from evcot.config import CotConfig, SlotConfig
from evcot.contract import RECORD, REGISTERS, Mode, Shape
from evcot.cot import CotModel
from evcot.lfsr_event_source import LfsrEventSource
from evcot.outputs import written_aside
from evcot.registers import register_map

from ..build import verilog_dir
from .selftest import signature

__all__ = ["RECORDS", "SIZES", "board_dir", "expected_records", "header", "shape"]

RECORDS = 256  # in the signature
SIZES = (1, 2, 4, 8)  # numbers of slots that a board may have
_EVENTS = 40_000  # more than make so many records

# Words that board_small.v has.
_SMALL = (
    "id", "version", "shape0", "shape1", "shape2", "build", "sensor", "memory", "control",
    "events", "owned", "passed", "records",
)  # fmt: skip
_SOURCE = LfsrEventSource(x_min=0, x_span=127, y_min=0, y_span=127, gap=24, seed=2026, x_w=7, y_w=7)
# Noise all over 128 x 128 pixels, an event every 25 us: windows are born, move, meet and die all the time.
_SLOT = SlotConfig(
    mode=Mode.SEEDED, init_cm_x=0, init_cm_y=0, init_radix=12, radix_th=4, radix_step=1, radix_min=6, radix_max=20, hist_avg=1,
    max_ticks=1200, clust_nev=3, nev_min=2, nev_max=16, nev_th=500, detect_ticks=4000,
)  # fmt: skip


def board_dir() -> Path:
    """The folder of what is for boards: hw/fpga of a checkout."""
    return verilog_dir().parent / "fpga"


def shape(n: int) -> Shape:
    """The widths of a board's trackers: small, so that the smallest board holds one."""
    return Shape(n_slots=n, x_w=7, y_w=7, frac=4, tick_w=8, radix_w=6, nev_w=5, tc_w=13, sup_w=8, id_w=8, seq_w=16, time_w=20)


def expected_records(n: int, count: int = RECORDS) -> NDArray[np.void]:
    """The first records of a board with so many slots after reset, (count,) of dtype `contract.RECORD`."""
    events = _SOURCE.events(_EVENTS)
    model = CotModel(CotConfig(shape(n), (_SLOT,) * n))
    return model.feed(events.t_us - events.t_us[0], events.x, events.y).records[:count]


def _expected(n: int) -> int:
    words = np.frombuffer(expected_records(n).tobytes(), "<u4")
    assert len(words) == RECORDS * RECORD.itemsize // 4
    return signature(words.astype(np.uint64))


def _address(name: str) -> int:
    return register_map().word(name).address


def _shape_word(name: str) -> int:
    """What a word of the map that tells the shape holds, but for the number of slots."""
    values = asdict(shape(1)) | {"n_slots": 0}
    return sum(values[field.name] << field.lsb for field in register_map().word(name).fields)


def _before() -> list[tuple[str, int, int]]:
    """What is written before the slots: the LFSR's settings, which a soft reset lets in."""
    source = _SOURCE
    return [
        ("lfsr_seed", _address("lfsr_seed"), source.seed),
        ("lfsr_gap", _address("lfsr_gap"), source.gap),
        ("lfsr_x", _address("lfsr_x"), source.x_min | source.x_span << 16),
        ("lfsr_y", _address("lfsr_y"), source.y_min | source.y_span << 16),
        ("control: soft_reset", _address("control"), 1 << 9),
    ]


def _of_slot() -> list[tuple[str, int, int]]:
    bank = register_map().banks["slot"]
    own = [
        (name, bank.base + 4 * REGISTERS[name].address, int(getattr(_SLOT, name)))
        for name in sorted(REGISTERS, key="mode".__eq__)
    ]
    return [*own, ("commit", bank.base + 4 * bank.commit, 1)]


def header() -> str:
    """The text of board_selftest.vh."""
    environment = Environment(loader=PackageLoader("evcot_cosim"), undefined=StrictUndefined, keep_trailing_newline=True)
    shared = {name: value for name, value in asdict(shape(1)).items() if name != "n_slots"}
    return environment.get_template("board_selftest.vh.j2").render(
        shape=shared, records=RECORDS, signatures={n: _expected(n) for n in SIZES},
        source=_SOURCE, words=[_shape_word(f"shape{i}") for i in range(3)],
        addresses={name: _address(name) for name in _SMALL},
        before=_before(), of_slot=_of_slot(), after=[("control: enable", _address("control"), 1)],
        slot_step=4 * register_map().banks["slot"].words, address_w=register_map().address_w,
    )  # fmt: skip


def _main() -> int:
    path = board_dir() / "board_selftest.vh"
    with written_aside(path) as file:
        file.write(header().encode())
    print(f"{path}: written")
    return 0


if __name__ == "__main__":
    sys.exit(_main())
