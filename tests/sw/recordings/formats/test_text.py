# SPDX-License-Identifier: Apache-2.0
"""Events in text files, as written by people and tools."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording, write_events
from evcot.recordings.formats import text

from .fuzzing import fuzz
from .reading import assert_same, by_others, read, refusal, rows_of, written_by_faery

EPOCH_US = 1_718_925_184_590_631


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "events.csv"


EVENTS = [(10, 1, 2, 1), (12, 3, 14, 0)]


@pytest.mark.parametrize(
    "content",
    [
        "10,1,2,1\n12,3,14,0\n",
        "10,1,2,1\r\n12,3,14,0",
        "10,1,2,1\n12,3,14,-1",
        "t,x,y,p\n10,1,2,1\n12,3,14,0\n",
        "\ufefft,x,y,p\n10,1,2,1\n12,3,14,0\n",
        "# t x y p\n10 1 2 1\n12 3 14 -1\n",
        "  10   1 2\t 1 \n12\t3  14 0\t\n",
        "timestamp;x;y;polarity\n10;1;2;1\n12;3;14;0\n",
        "x\ty\tp\tt_us\n1\t2\t1\t10\n3\t14\t0\t12\n",
        "x\tnote\ty\tp\tt_us\n1\t\t2\t1\t10\n3\ta b\t14\t0\t12\n",
        "on, note, t, y, x\n1, 9, 10, 2, 1\n0, µ\t, 12, 14, 3\n",
        "x,y,p,t\n1,2,1,10\n3,14,0,12\n",
        '"","x","y","Pol","TS"\n0,1,2,1,10\n1,3,14,0,12\n',
        "\n% a comment, of µs\n10,1,2,1\n\n  # and, 1 2 3 4\n12,3,14,0\n\n",
        "t_us,x,y,p\n+10,1.0,2.,01\n1.2e1,3e0,14.000,-0\n",
        "t_s,x,y,p\n0.00001,1,2,1\n0.000012,3,14,0\n",
        "t[ms];x;y;p\n0.01;1;2;1\n0.012;3;14;0\n",
        "time (ns),x,y,p\n10000,1,2,1\n12000,3,14,0\n",
        "t_us,x,y,p\n9.5,1,2,1\n12.4999999,3,14,0\n",
        "0.000010 1 2 1\n0.000012 3 14 0\n",
        "1e-05 1 2 1\n1.2E-05 3 14 0\n",
        "9.999999999999999e-06 1 2 1\n.000012 3 14 0\n",
        "1.000000000000000000e-05 1.0e+00 2.000000000000000000e+00 1.0e+00\n1.2000000000000000000000e-05 3 1.4e1 0\n",
        "240 180\n0.000010 1 2 1\n0.000012 3 14 0\n",
        "# from a simulator\n240 180\n10 1 2 1\n12 3 14 0\n",
    ],
)  # fmt: skip
def test_every_usual_layout_gives_the_same_events(path: Path, content: str) -> None:
    assert read(path, content) == EVENTS


def test_the_sensor_is_given_or_stated_or_the_smallest_that_holds_every_event(path: Path) -> None:
    path.write_text("10,1,2,1\n12,3,4,0\n")
    small, given = read_recording(path), read_recording(path, sensor=(128, 64))
    assert (small.width, small.height) == (4, 5)
    assert (given.width, given.height) == (128, 64)
    for content in ("t,x@346,y@260,on\n10,1,2,1\n", "y@260,x@346,on,t\n2,1,1,10\n", "346 260\n10 1 2 1\n"):
        path.write_text(content)
        stated = read_recording(path)
        assert (stated.width, stated.height) == (346, 260)


def test_the_file_s_layout_is_told(path: Path) -> None:
    path.write_text("0.5;1;2;1\n")
    with open_recording(path) as file:
        assumed = "t, x, y, p, assumed by their values; a first line such as x,y,t,p names them"
        assert file.details == {"separator": "semicolon", "times in": "seconds", "columns": assumed}


@pytest.mark.parametrize(
    ("content", "t_us"),
    [
        ("0.0000004 0 0 0\n0.0000005 0 0 0\n0.0000014999 0 0 0\n", [0, 1, 1]),
        ("-0.0000015 0 0 0\n-0.0000005 0 0 0\n-0.00000049 0 0 0\n", [-2, -1, 0]),
        (f"{EPOCH_US // 10**6}.{EPOCH_US % 10**6:06d} 0 0 0\n", [EPOCH_US]),
        (f"{EPOCH_US // 10**6}.{EPOCH_US % 10**6:06d}499 0 0 0\n", [EPOCH_US]),
        (f"{EPOCH_US // 10**6}.{EPOCH_US % 10**6:06d}500 0 0 0\n", [EPOCH_US + 1]),
        (f"{EPOCH_US // 10**6}.{EPOCH_US % 10**6:06d}500000000000000000000001 0 0 0\n", [EPOCH_US + 1]),
        ("0.0 0 0 0\n12 0 0 0\n", [0, 12_000_000]),
        ("9223372036854.775807 0 0 0\n", [2**63 - 1]),
        ("-9223372036854775807 0 0 0\n9223372036854775807 0 0 0\n", [-(2**63) + 1, 2**63 - 1]),
    ],
)
def test_times_are_rounded_to_the_nearest_microsecond(path: Path, content: str, t_us: list[int]) -> None:
    assert [row[0] for row in read(path, content)] == t_us


WHOLE_US = "must be a whole number of microseconds, below 2^63 us"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("10010,1,2,1\n9,1,2,1\n", "event 1: t = 9 us follows t = 10010 us: time must not run back"),
        ("10,1,2,1\n11,1,2,3\n", "event 1: p = 3: must be 0 or 1"),
        ("10,-1,2,1\n", "line 1: x = '-1': must be a whole number from 0 to 65535"),
        ("#\n\nt,x,y,p\n10,1,70000,1\n", "line 4: y = '70000': must be a whole number from 0 to 65535"),
        ("10,65536,2,1\n", "line 1: x = '65536': must be a whole number from 0 to 65535"),
        ("10,1,2,1\n10,1,2.0000000000000000000001,1\n",
         "line 2: y = '2.0000000000000000000001': must be a whole number from 0 to 65535"),
        ("10,1,2,1\n10,1,2.5,1\n", "line 2: y = '2.5': must be a whole number from 0 to 65535"),
        ("10,1,2,-2\n", "line 1: p = '-2': must be 0, 1 or -1, or true or false"),
        ("10,1,2,256\n", "line 1: p = '256': must be 0, 1 or -1, or true or false"),
        ("10,1,2,\n", "line 1: p = '': must be 0, 1 or -1, or true or false"),
        ("10,a,2,1\n", "line 1: x = 'a': must be a whole number from 0 to 65535"),
        ("10,1 1,2,1\n", "line 1: x = '1 1': must be a whole number from 0 to 65535"),
        ("10,1,2,1\n0x11,1,2,1\n", f"line 2: t = '0x11': {WHOLE_US}"),
        ("10,1,2,1\n11.5,1,2,1\n", f"line 2: t = '11.5': {WHOLE_US}"),
        ("10,1,2,1\n1e,1,2,1\n", f"line 2: t = '1e': {WHOLE_US}"),
        ("10,1,2,1\n9223372036854775808,1,2,1\n", f"line 2: t = '9223372036854775808': {WHOLE_US}"),
        ("10,1,2,1\n" + "9" * 30 + ",1,2,1\n", f"line 2: t = '{'9' * 30}': {WHOLE_US}"),
        ("0.5,1,2,1\n1e300,1,2,1\n", "line 2: t = '1e300': must be a number of seconds, below 2^63 us"),
        ("0.5,1,2,1\nnan,1,2,1\n", "line 2: t = 'nan': must be a number of seconds, below 2^63 us"),
        ("10,1,2\n", "line 1: '10,1,2': must have 4 cells, as the first event; it has 3"),
        ("10,1,2,1\n11,1\n", "line 2: '11,1': must have 4 cells, as the first event; it has 2"),
        ("10,1,2,1\n11,1,2,1,12,1,2,1\n", "line 2: '11,1,2,1,12,1,2,1': must have 4 cells, as the first event; it has 8"),
        ("10 1 2 1\n11 1 2 1 12 1 2 1\n", "line 2: '11 1 2 1 12 1 2 1': must have 4 cells, as the first event; it has 8"),
        ("10,1,2,1\r11,1,2,1\r", "line 1: holds a byte of 0x0d: must be text"),
        ("10,1,2,1\n11,1,2,1\r12,1,2,1\n", "line 2: holds a byte of 0x0d: must be text"),
        (b"10,1,2,1" + 400 * b"\n10,1,2,1" + b"\0\n", "line 401: holds a byte of 0x00: must be text"),
        (b"10,1,2,1\n# " + bytes(2000 * [65]) + b"\x01\n", "line 2: holds a byte of 0x01: must be text"),
        ("10,1,2,1,a\n11,1,2,1,a" + 2000 * "b" + "\x01\n", "line 2: holds a byte of 0x01: must be text"),
        ("t,x,y,p\n", "holds no events"),
        ("# all, of, it\n# comment", "holds no events"),
        ("t,x,y\n1,2,3\n", "line 1: 't,x,y': is not an event: must name each of t, x, y, p once; p is not"),
        ("t,x,x,y,p\n1,2,3,4,1\n", "line 1: 't,x,x,y,p': is not an event: must name each of t, x, y, p once; x is not"),
        ("# Title\n\nSome prose.\n", "line 3: 'Some prose.': is not an event: must name each of t, x, y, p once; t is not"),
        ("p,x,y,t\n1,2,3,1000", "the last line must end in a newline; is it cut off?"),
        ("10,1,2,1\n" + "1" * 70_000, "byte 70009: no line ends in the 65536 bytes before: must be text"),
        ("99999 99999\n10 1 2 1\n", "sensor 99999x99999: each side must be from 1 to 65536 pixels"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_its_line(path: Path, content: str | bytes, message: str) -> None:
    assert refusal(path, content) == message


def random_events(count: int, start_us: int = EPOCH_US) -> Events:
    random = np.random.default_rng(count)
    return Events(
        start_us + np.cumsum(random.choice([0, 1, 60_000_000], count, p=[0.5, 0.49, 0.01])),
        random.integers(0, 65536, count).astype(np.uint16),
        random.integers(0, 10, count).astype(np.uint16),
        random.integers(0, 2, count).astype(np.uint8),
    )


@pytest.mark.parametrize("chunk_bytes", [90, 91, 100, 128, 1000])
@pytest.mark.parametrize("end", ["\n", "\r\n", "  \n", "\n# a comment, in between\n\n"])
def test_where_chunks_are_cut_does_not_matter(path: Path, monkeypatch: pytest.MonkeyPatch, chunk_bytes: int, end: str) -> None:
    write_events(path, (65536, 10), [random_events(500, start_us=-EPOCH_US)])
    path.write_bytes(path.read_bytes().replace(b"\n", end.encode()).rstrip())
    whole = rows_of(read_recording(path).events)
    assert len(whole) == 500
    monkeypatch.setattr(text, "_CHUNK_BYTES", chunk_bytes)
    assert rows_of(read_recording(path).events) == whole
    wrong = path.read_bytes() + b"\n1,2,3,a"
    assert refusal(path, wrong).startswith(f"line {wrong.count(10) + 1}: p = 'a': must be 0, 1 or -1")


def test_text_is_written_to_the_digit(path: Path) -> None:
    events = Events(
        np.array([-(2**62), -10, 0, 9, 10, 99_999, 2**62]),
        *(np.array([0, 9, 10, 99, 345, 9999, 65535], np.uint16) for _ in "xy"),
        np.array([0, 1, 0, 1, 0, 1, 0], np.uint8),
    )
    assert write_events(path, (65536, 65536), [events]) == 7
    lines = path.read_text().splitlines()
    assert lines[:3] == ["t_us,x@65536,y@65536,p", "-4611686018427387904,0,0,0", "-10,9,9,1"]
    assert lines[3:] == ["0,10,10,0", "9,99,99,1", "10,345,345,0", "99999,9999,9999,1", "4611686018427387904,65535,65535,0"]


def test_faery_reads_what_was_written_and_its_files_are_read(path: Path) -> None:
    events = random_events(1000)
    events = Events(events.t_us, events.x % 1280, events.y, events.p)
    write_events(path, (1280, 10), [events])
    assert_same(by_others("faery", path), events)
    assert_same(read_recording(written_by_faery(path, events, (1280, 10)), (1280, 10)).events, events)


def test_a_file_that_shrinks_while_it_is_read_is_refused(path: Path) -> None:
    write_events(path, (65536, 10), [random_events(1000)])
    with open_recording(path) as file:
        path.write_bytes(path.read_bytes()[:1000])
        with pytest.raises(RecordingError, match=r"ends at byte 1000: held \d+ bytes when it was opened"):
            file.read()


def test_a_damaged_file_is_refused_or_read(tmp_path: Path) -> None:
    write_events(tmp_path / "events.csv", (65536, 10), [random_events(40)])
    seconds = "346 260\n" + "".join(f"{i / 7:.6f} {i} {i} {i % 2}\n" for i in range(50))
    for seed, content in ((1, (tmp_path / "events.csv").read_bytes()), (2, seconds.encode())):
        outcomes = fuzz(tmp_path / f"{seed}.txt", content, usual=1_000, seed=seed)
        assert min(outcomes.refused, outcomes.read) > 100


def test_decimal_commas_between_semicolons(path: Path) -> None:
    for head in ("t;x;y;p\n", ""):
        assert read(path, head + "0,000019;50;102;0\n0,000205;52;104;1\n") == [(19, 50, 102, 0), (205, 52, 104, 1)]
        with open_recording(path) as file:
            assert file.details["decimal mark"] == "comma"
    assert refusal(path, "t;x;y;p\n0,000019;50;1,5;0\n").startswith("line 2: y = '1.5': must be a whole number")


def test_a_pointer_of_git_lfs_is_named(path: Path) -> None:
    pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 12345\n"
    assert "is a pointer of Git LFS, without the data: get these with `git lfs pull`" in refusal(path, pointer)
