# SPDX-License-Identifier: Apache-2.0
"""A damaged RAW or DAT file is refused, or its losses are counted; no event is outside the sensor or back in time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError, RecordingWarning
from evcot.recordings.files import Damage, open_recording, read_recording

from .fuzzing import fuzz
from .reference_evt import (
    dat_event,
    evt2_event,
    evt2_high,
    evt3_base,
    evt3_event,
    evt3_high,
    evt3_low,
    evt3_row,
    evt3_vector8,
    evt3_vector12,
    evt21_event,
    evt21_high,
    packed,
)

HEADERS = {
    "evt2": b"% evt 2.0\n% format EVT2;height=240;width=320\n% geometry 320x240\n% end\n",
    "evt21": b"% evt 2.1\n% format EVT21;endianness=little;height=240;width=320\n% end\n",
    "evt21-legacy": b"% evt 2.1\n% endianness legacy\n% geometry 320x240\n% end\n",
    "evt3": b"% evt 3.0\n% format EVT3;height=240;width=320\n% geometry 320x240\n% t0 1718925184590631\n% end\n",
    "dat1": b"% Version 1\n% Width 304\n% Height 240\n\x00\x08",
    "dat2": b"% Version 2\n% Width 320\n% Height 240\n\x0c\x08",
}


def small_file(kind: str) -> bytes:
    """About 50 events with marks, vectors, triggers and vendors' words among them."""
    random = np.random.default_rng(7)
    words: list[int] = []
    for step in range(16):
        x, y, p, low = (int(each) for each in random.integers(0, (280, 240, 2, 60)))
        match kind:
            case "evt2":
                words += [evt2_high(5 + step), *(evt2_event(p, low + each, x + each, y) for each in range(3))]
                words += [0xA0000001] if step % 5 == 0 else []
            case "evt21" | "evt21-legacy":
                words += [evt21_high(5 + step), evt21_event(p, low, x, y, 0b10011 << step)]
                words += [0xE << 60 | 20] if step % 5 == 0 else []
            case "evt3":
                words += [evt3_high(4090 + step if step < 6 else step - 6), evt3_low(40 * low), evt3_row(y)]
                words += [evt3_event(p, x)] if step % 3 else [evt3_base(p, x), *[evt3_vector12(0x409)] * 2, evt3_vector8(0x81)]
                words += [0xA001, 0xE014, 0xF001, 0x7001] if step % 5 == 0 else []
            case _:
                words += [dat_event(1000 * step + low + each, x, y, p, int(kind[-1])) for each in range(3)]
    return packed(kind, words, HEADERS[kind])


@pytest.mark.parametrize("damage", ["refuse", "skip"])
@pytest.mark.parametrize("kind", HEADERS)
def test_every_cut_and_many_corruptions_are_answered_by_the_rules(tmp_path: Path, kind: str, damage: Damage) -> None:
    content = small_file(kind)
    refuses = damage == "refuse"
    outcomes = fuzz(tmp_path / "events", content, corruptions=10_000 if refuses else 1_000, seed=11, damage=damage)
    assert outcomes.refused > (1000 if refuses else 50)
    assert outcomes.read > 100
    assert outcomes.lossy > 100 or (refuses and kind.startswith("dat"))  # DAT has no reserved words, and a time in every word


def answer(path: Path, content: bytes, damage: Damage = "refuse") -> str:
    path.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        read_recording(path, damage=damage)
    return str(caught.value).removeprefix(f"{path}: ")


def test_what_stands_before_a_word_that_is_cut_off_can_be_had(tmp_path: Path) -> None:
    path = tmp_path / "events"
    content = packed("evt2", [evt2_high(1), evt2_event(1, 2, 3, 4), evt2_event(1, 2, 4, 4)])[:-1]
    rule = f"ends within a word of 4 bytes, at byte {len(content)}; is it cut off?"
    assert answer(path, content) == rule
    with pytest.warns(RecordingWarning, match="everything after 1 events left out: ends within a word of 4 bytes"):
        assert len(read_recording(path, damage="skip").events) == 1


def test_a_file_that_shrinks_while_it_is_read_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "events"
    content = packed("dat2", [dat_event(each, 1, 1, 1) for each in range(10)])
    path.write_bytes(content)
    with open_recording(path, (2, 2)) as file:
        path.write_bytes(content[:-20])
        with pytest.raises(RecordingError, match=f"ends at byte {len(content) - 20}, earlier than when it was opened"):
            file.read()


@pytest.mark.parametrize("sensor", [b"", b"% geometry 1280x720\n"])
def test_a_vector_that_runs_past_the_sensor_is_refused_with_and_without_a_stated_one(tmp_path: Path, sensor: bytes) -> None:
    header = b"% evt 3.0\n" + sensor + b"% end\n"
    start = [evt3_high(0), evt3_row(4), evt3_base(1, 1275)]
    message = "x = 1280: must be below the sensor's 1280"
    assert answer(tmp_path / "events", packed("evt3", [*start, evt3_vector12(0x21)], header)) == f"event 1: {message}"
    endless = [*start, *[evt3_vector12(0)] * 6000, evt3_vector12(1)]
    assert "must be below the sensor's 1280" in answer(tmp_path / "events", packed("evt3", endless, header))
    words = [evt21_high(0), evt21_event(1, 0, 1279, 4, 0b11)]
    header = header.replace(b"3.0", b"2.1")
    assert answer(tmp_path / "events", packed("evt21", words, header)) == f"event 1: {message}"


def test_a_row_beyond_the_sensor_is_refused(tmp_path: Path) -> None:
    words = [evt3_high(0), evt3_row(720), evt3_event(1, 5)]
    assert answer(tmp_path / "events", packed("evt3", words)) == "event 0: y = 720: must be below the sensor's 720"


@pytest.mark.parametrize(
    ("header", "rule"),
    [
        (b"% evt 2.0\n% format EVT3;height=720;width=1280\n", "header: EVT version 2 and 3: evt and format must say the same"),
        (b"% evt 3.0\n% geometry 0x720\n", "sensor 0x720: each side must be from 1 to 65536 pixels"),
        (b"% evt 2.1\n% endianness big\n", "header: endianness = big: must be little or legacy"),
        (
            b"% evt 3.0\n% t0 4611686018427387904\n",
            "header: t0 = 4611686018427387904: must be a whole number of microseconds below 2^62",
        ),
        (
            b"% evt 3.0\n% t0 " + b"9" * 5000 + b"\n",
            f"header: t0 = {'9' * 40}: must be a whole number of microseconds below 2^62",
        ),
        (
            b"% evt 3.0\n% " + b"a" * 70_000 + b"\n",
            "ends within its header, at byte 65536: a header line must end in a newline",
        ),
        (b"% evt 9\x1b[2J\n", "EVT version 9?[2J: must be 2.0, 2.1 or 3.0"),
    ],
)
def test_a_header_that_makes_no_sense_is_refused_by_rule(tmp_path: Path, header: bytes, rule: str) -> None:
    content = header + b"% end\n" + np.array([0x8000, 1, 0x2001, 0], "<u2").tobytes()
    assert answer(tmp_path / "events", content) == rule


NEWER = b"""% camera_integrator_name Prophesee
% date 2023-03-29 16:37:46
% evt 3.0
% format EVT3;height=720;width=1280;sensorname=IMX636
% generation 4.2
% geometry 1280x720
% plugin_name hal_plugin_imx636_evk4
% sensor_generation 4.2
% serial_number 00050423
% system_ID 49
"""


@pytest.mark.parametrize("end", [b"% end\n", b"% END\r\n", b""], ids=["end", "END", "no end"])
@pytest.mark.parametrize("without", [b"", b"% evt 3.0\n", b"% geometry 1280x720\n"], ids=["all", "no evt", "no geometry"])
def test_a_newer_camera_s_file_is_read_without_a_word(tmp_path: Path, end: bytes, without: bytes) -> None:
    """Headers as of an IMX636, whose stream has repeated marks, triggers, and counts of its own in vendors' words."""
    words = [
        *(
            evt3_high(7),
            evt3_low(0xFF0),
            0xE01A,
            0xF123,
            0xF456,
            0x7008,
        ),  # a vendor's word and what continues it
        *(evt3_row(10), evt3_base(1, 100), evt3_vector12(0b1), evt3_vector8(0b10), evt3_vector12(1 << 11)),
        *(evt3_high(7), evt3_low(0xFF8), 0xA001, 0xA000, evt3_event(0, 5)),  # a trigger's two edges
        *(evt3_high(8), evt3_low(2), evt3_row(719), evt3_event(1, 1279), evt3_vector8(1)),  # the base is kept
    ]
    path = tmp_path / "events.raw"
    path.write_bytes(packed("evt3", words, NEWER.replace(without, b"") + end))
    with open_recording(path) as file:
        events = file.read().events
        assert file.sensor == (1280, 720)
        assert not file.left_out
    rows = list(zip(events.t_us.tolist(), events.x.tolist(), events.y.tolist(), events.p.tolist(), strict=True))
    t_us = 7 << 12 | 0xFF0
    assert rows == [
        *((t_us, 100, 10, 1), (t_us, 113, 10, 1), (t_us, 131, 10, 1)),
        *((t_us + 8, 5, 10, 0), (t_us + 18, 1279, 719, 1), (t_us + 18, 132, 719, 1)),
    ]


def test_of_two_sensors_in_a_header_the_larger_is_taken_and_told(tmp_path: Path) -> None:
    path = tmp_path / "events.raw"
    words = [evt3_high(0), evt3_row(700), evt3_event(1, 1200)]
    for geometry, sensor in (("640x480", (1280, 720)), ("1920x1080", (1920, 1080))):
        header = f"% evt 3.0\n% format EVT3;height=720;width=1280\n% geometry {geometry}\n".encode()
        path.write_bytes(packed("evt3", words, header))
        with pytest.warns(RecordingWarning) as caught:
            recording = read_recording(path)
        assert (recording.width, recording.height) == sensor
        message = f"{path}: header: sensor {geometry} and 1280x720: the larger is taken"
        assert [str(each.message) for each in caught] == [message]


def test_what_a_header_says_is_told(tmp_path: Path) -> None:
    path = tmp_path / "events.raw"
    header = b"% Date 2023-03-29 16:37:46\n% evt 2.1\n% plugin_name hal_plugin_imx636_evk4\n% serial_number 00ca0009\n"
    path.write_bytes(packed("evt21", [evt21_high(1), evt21_event(1, 2, 3, 4, 1)], header + b"% geometry 1280x720\n% end\n"))
    with open_recording(path) as file:
        assert (file.format, file.sensor, file.t0_us) == ("Prophesee RAW, EVT 2.1", (1280, 720), 66)
        assert file.details == {
            "camera": "hal_plugin_imx636_evk4",
            "serial": "00ca0009",
            "date": "2023-03-29 16:37:46",
            "words": "2 of 64 bits",
            "order": "little",
        }


def test_a_long_header_is_read_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "events.raw"
    for length in range(900, 1200):
        comment = b"% note " + b"x" * length + b"\n"
        path.write_bytes(packed("evt3", [evt3_high(1), evt3_row(2), evt3_event(1, 3)], comment + b"% evt 3.0\n"))
        assert len(read_recording(path).events) == 1
