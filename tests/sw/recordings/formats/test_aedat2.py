# SPDX-License-Identifier: Apache-2.0
"""AEDAT 2.0 and 1.0: address bits of each chip, orientation, wrap-around of time, and records that are not events."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingWarning
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats import aedat2
from evcot.recordings.formats.aedat2 import Aedat2File
from evcot.recordings.formats.source import BLOCK_EVENTS

from .fuzzing import fuzz
from .reading import Row, assert_same, by_others, read, refusal, rows_of, shared

TURN = 1 << 32


def dvs128_address(x: int, y: int, p: int) -> int:
    """As the chip sends it: darker is 1, x counts from the right and y from the bottom."""
    return 127 - y << 8 | 127 - x << 1 | 1 - p


def davis_address(x: int, y: int, p: int, width: int, height: int) -> int:
    """As the chip sends it: x counts from the right and y from the bottom."""
    return height - 1 - y << 22 | width - 1 - x << 12 | p << 11


def file_of(*records: tuple[int, int], header: str = "# AEChip: DVS128\r\n", version: str = "2.0") -> bytes:
    """(address, time) records behind a header."""
    layout = ">II" if version == "2.0" else ">HI"
    return f"#!AER-DAT{version}\r\n{header}".encode() + b"".join(struct.pack(layout, *record) for record in records)


def dvs128_file(rows: list[Row], **header: str) -> bytes:
    return file_of(*((dvs128_address(x, y, p), t) for t, x, y, p in rows), **header)


def davis_file(rows: list[Row], chip: str, width: int, height: int) -> bytes:
    header = f"# AEChip: eu.seebetter.ini.chips.davis.{chip}\r\n" if chip else ""
    return file_of(*((davis_address(x, y, p, width, height), t) for t, x, y, p in rows), header=header)


def make_rows(count: int, width: int, height: int, start_us: int = 1000) -> list[Row]:
    random = np.random.default_rng(31)
    columns = (
        start_us + np.sort(random.integers(0, 3 * count, count)),
        random.integers(0, width, count),
        random.integers(0, height, count),
        random.integers(0, 2, count),
    )
    return list(zip(*(column.tolist() for column in columns), strict=True))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "events.aedat"


def test_dvs128_addresses(path: Path) -> None:
    content = file_of((0, 10), (1, 11), (0x7F << 1, 12), (0x7F << 8, 13), (3 << 8 | 5 << 1, 14))
    assert read(path, content) == [(10, 127, 127, 1), (11, 127, 127, 0), (12, 0, 127, 1), (13, 127, 0, 1), (14, 122, 124, 1)]
    expected = make_rows(1000, 128, 128)
    assert read(path, dvs128_file(expected)) == read(path, dvs128_file(expected, header="", version="1.0")) == expected


@pytest.mark.parametrize(
    ("chip", "width", "height"),
    [
        ("DAVIS240C", 240, 180),
        ("SBret20", 240, 180),
        ("Davis346blue", 346, 260),
        ("Davis640", 640, 480),
        ("Davis128", 128, 128),
    ],
)
def test_davis_addresses(path: Path, chip: str, width: int, height: int) -> None:
    expected = make_rows(1000, width, height)
    assert read(path, davis_file(expected, chip, width, height)) == expected
    with open_recording(path) as file:
        assert file.sensor == (width, height)
        assert file.details == {"chip": f"eu.seebetter.ini.chips.davis.{chip}"}


def test_events_come_in_blocks_of_one_size(path: Path) -> None:
    expected = make_rows(2 * BLOCK_EVENTS + 5, 128, 128)
    path.write_bytes(dvs128_file(expected))
    blocks = list(Aedat2File(path).blocks())
    assert [len(block) for block in blocks] == [BLOCK_EVENTS, BLOCK_EVENTS, 5]
    assert rows_of(Events.joined(blocks)) == expected


def test_a_real_dvs128_file_bit_by_bit_and_its_pendulum_hangs_from_the_top() -> None:
    real = shared("pendulum_dvs128.aedat")
    events = read_recording(real).events
    body = real.read_bytes().split(b"#End Of ASCII Header\r\n", 1)[1]
    address, t_us = np.frombuffer(body, ">u4").reshape(-1, 2).T.astype(np.int64)
    assert len(events.t_us) == len(t_us) == 278_538
    assert_same(events, (t_us, 127 - (address >> 1 & 127), 127 - (address >> 8 & 127), 1 - (address & 1)))
    # The bob is lowest in the middle of its swing, and dark: it darkens what it moves to.
    middle, side = (np.median(events.y[(events.x >= x) & (events.x < x + 10)]) for x in (60, 115))
    assert middle > side + 5
    assert np.mean(bob_motion(events) > 0) > 0.8


def bob_motion(events: Events, step_us: int = 40_000) -> np.ndarray:
    """Product of the bob's motion along x and how far its darkening side lies ahead of the other, where it moves fast."""

    def centre(begin_us: int, polarities: tuple[int, ...]) -> float:
        seen = (events.t_us >= begin_us) & (events.t_us < begin_us + step_us) & (events.x > 30)
        seen &= np.isin(events.p, polarities)
        return float(np.median(events.x[seen])) if np.count_nonzero(seen) >= 60 else np.nan

    products = []
    for begin_us in range(int(events.t_us[0]) + step_us, int(events.t_us[-1]) - step_us, 4 * step_us):
        motion = centre(begin_us + step_us, (0, 1)) - centre(begin_us - step_us, (0, 1))
        if abs(motion) >= 4:
            products.append(motion * (centre(begin_us, (0,)) - centre(begin_us, (1,))))
    return np.array([product for product in products if np.isfinite(product)])


@pytest.mark.parametrize(("chip", "width", "height"), [("DAVIS240C", 240, 180), ("Davis346blue", 346, 260)])
def test_eventcv_reads_the_same_but_does_not_turn_x_around_as_jaer_does(path: Path, chip: str, width: int, height: int) -> None:
    expected = make_rows(500, width, height)
    path.write_bytes(davis_file(expected, chip, width, height))
    assert [(t_us, width - 1 - x, y, p) for t_us, x, y, p in rows_of(by_others("eventcv", path))] == expected


def test_what_is_no_brightness_change_is_passed_over(path: Path) -> None:
    sync, special = 1 << 15, 1 << 31
    assert read(path, file_of((0, 10), (sync, 11), (special, 12), (0, 13))) == [(10, 127, 127, 1), (13, 127, 127, 1)]
    frame, imu, external = 1 << 31, 1 << 31 | 3 << 10, 1 << 10
    content = file_of((0, 10), (frame, 11), (imu, 12), (external, 13), (0, 14), header="# AEChip: DAVIS240C\r\n")
    assert read(path, content) == [(10, 239, 179, 0), (14, 239, 179, 0)]
    with pytest.warns(RecordingWarning, match="2 events left out: address bits that the chip does not have"):
        assert read(path, file_of((0, 10), (1 << 16, 11), (1 << 30, 12), (0, 13))) == [(10, 127, 127, 1), (13, 127, 127, 1)]


@pytest.mark.parametrize("block_events", [1, 2, 100])
def test_time_goes_on_where_its_32_bits_wrap_around(path: Path, monkeypatch: pytest.MonkeyPatch, block_events: int) -> None:
    monkeypatch.setattr(aedat2, "BLOCK_EVENTS", block_events)
    times = [TURN - 2, TURN - 1, 3, 1 << 31, TURN - 1, 0]
    expected = [TURN - 2, TURN - 1, TURN + 3, TURN + (1 << 31), 2 * TURN - 1, 2 * TURN]
    assert [row[0] for row in read(path, file_of(*((0, t) for t in times)))] == expected


@pytest.mark.parametrize("back", [10_199, 0, TURN - 1])
def test_a_step_back_is_left_for_the_reader_s_rules(path: Path, back: int) -> None:
    content = file_of((0, 100), (0, 20_200), (0, back), (0, 20_300))
    t_us = back if back < 20_200 else -1
    assert refusal(path, content) == f"event 2: t = {t_us} us follows t = 20200 us: time must not run back"
    with pytest.warns(RecordingWarning, match="1 events left out: time runs back"):
        assert [row[0] for row in read(path, content, damage="skip")] == [100, 20_200, 20_300]


@pytest.mark.parametrize(
    ("header", "addresses", "sensor", "chip"),
    [
        ("# HardwareInterface: DVS128-V1 0392\r\n", (dvs128_address(5, 6, 1),), (128, 128), "DVS128-V1 0392"),
        ("# HardwareInterface: DAVIS FX3 0002-INI\r\n# AEChip: Davis346red\r\n", (davis_address(5, 6, 1, 346, 260),),
         (346, 260), "Davis346red"),
        ("# created today\r\n", (dvs128_address(5, 6, 1), 1 << 15), (128, 128), "none named, a DVS128 by its addresses"),
        *(("", (davis_address(5, 6, 1, *size), *more), size, f"none named, a DAVIS of {size[0]}x{size[1]} by its addresses")
          for size, more in (((240, 180), ()), ((346, 260), ()), ((640, 480), (1 << 31 | 1023 << 12,)))),
    ],
)  # fmt: skip
def test_the_header_names_the_chip_else_the_addresses_do(
    path: Path, header: str, addresses: tuple[int, ...], sensor: tuple[int, int], chip: str
) -> None:
    path.write_bytes(file_of(*((address, 10) for address in addresses), header=header))
    with open_recording(path) as file:
        assert (file.sensor, file.details["chip"]) == (sensor, chip)
        assert rows_of(file.read().events) == [(10, 5, 6, 1)]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (file_of((0, 1), header="# AEChip: CochleaAMS1c\r\n"),
         "header: chip 'CochleaAMS1c': must be a DVS128, or a DAVIS of known size"),
        (file_of((1023 << 12, 1), header=""), "header names no chip, and none that is known has 1024x1 pixels"),
        (file_of(header="# AEChip: DVS128\r\n"), "holds no events"),
        (file_of((1 << 15, 5)), "holds no events"),
        (file_of((0, 1), (0, 2))[:-3], "5 bytes behind the last record: records must be of 8 bytes; is it cut off?"),
        (b"#!AER-DAT2.0", "header line at byte 0: must end in a newline; is it cut off?"),
        (file_of(header="# AEChip: DVS"), "header line at byte 14: must end in a newline; is it cut off?"),
        (file_of((0, 1), header="# AEChip: DAVIS240C\r\n", version="1.0"),
         "header: chip 'DAVIS240C': must be a DVS128 in AEDAT 1.0"),
        (file_of((0, 10), (180 << 22, 11), header="# AEChip: DAVIS240C\r\n"),
         "event 1: y = 180: must be below the sensor's 180"),
    ],
)  # fmt: skip
def test_what_is_no_whole_recording_is_refused_by_rule(path: Path, content: bytes, message: str) -> None:
    assert refusal(path, content) == message


def test_the_events_before_a_cut_are_given(path: Path) -> None:
    expected = make_rows(5, 128, 128)
    with pytest.warns(RecordingWarning, match="everything after 4 events left out: 7 bytes behind the last record"):
        assert read(path, dvs128_file(expected)[:-1], damage="skip") == expected[:4]


@pytest.mark.parametrize("end", ["#End Of ASCII Header\r\n", ""])
def test_a_record_that_starts_like_a_header_line_is_a_record(path: Path, end: str) -> None:
    row = (0x10, 200, 179 - 140, 1)
    address = davis_address(*row[1:], 240, 180)
    assert address >> 24 == ord("#")
    assert read(path, file_of((address, 0x10), header=f"# AEChip: DAVIS240C\r\n{end}")) == [row]


def test_after_the_header_s_last_line_even_text_is_a_record(path: Path) -> None:
    address, t_us = struct.unpack(">II", b"#abcdef\n")
    content = file_of((address, t_us), header="# AEChip: Davis640\r\n#End Of ASCII Header\r\n")
    assert read(path, content) == [(t_us, 639 - (address >> 12 & 1023), 479 - (address >> 22), 0)]


def test_a_window_is_found_by_halving(path: Path) -> None:
    expected = make_rows(100_000, 128, 128)
    path.write_bytes(dvs128_file(expected))
    source = Aedat2File(path)
    from_us = expected[90_000][0]
    first = next(source.blocks(from_us))
    assert 0 < 90_000 - (100_000 - len(first)) <= 4096 + 3
    assert [row for row in rows_of(first) if row[0] >= from_us] == [row for row in expected if row[0] >= from_us]
    window = read(path, dvs128_file(expected), from_us=90_000, to_us=91_000)
    assert window == [row for row in expected if 90_000 <= row[0] - expected[0][0] < 91_000]


def test_a_window_of_a_file_whose_time_wraps_is_found_by_reading(path: Path) -> None:
    expected = make_rows(20_000, 128, 128, start_us=TURN - 20_000)
    content = dvs128_file([(t % TURN, x, y, p) for t, x, y, p in expected])
    t0_us = expected[0][0]
    assert read(path, content, from_us=30_000) == [row for row in expected if row[0] - t0_us >= 30_000]


def test_damage_to_a_dvs128_file(path: Path) -> None:
    content = dvs128_file(make_rows(50, 128, 128), header="# created today\r\n# AEChip: DVS128\r\n#End Of ASCII Header\r\n")
    outcomes = fuzz(path, content, seed=32)
    assert outcomes.refused > 1_500
    assert outcomes.lossy > 100


@pytest.mark.parametrize("chip", ["DAVIS240C", ""])
def test_damage_to_a_davis_file_left_out(path: Path, chip: str) -> None:
    content = davis_file(make_rows(50, 240, 180), chip, 240, 180)
    assert fuzz(path, content, corruptions=2000, seed=33, damage="skip").lossy > 500
