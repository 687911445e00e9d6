# SPDX-License-Identifier: Apache-2.0
"""`evcot board`: distinguishes a working simulated board from a broken one, over its serial line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from evcot.hardware.register_access import Registers
from evcot_cosim.cli import main
from evcot_cosim.commands.actions import board
from evcot_cosim.fpga.board import expected_records
from evcot_cosim.fpga.board_sim import BOARDS, SimulatedBoard
from evcot_cosim.fpga.serial_host import SerialHost

from ..conftest import Refused

pytest.importorskip("serial", reason="needs pyserial")

Capture = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def no_long_life(monkeypatch: pytest.MonkeyPatch) -> None:
    """The golden model makes the records of a minute of a board's life, which takes a simulation a quarter of an hour."""
    monkeypatch.setattr(board, "_EVENTS", 500_000)


@pytest.mark.parametrize(("name", "slots", "tracker"), [("icebreaker", 1, "cot_array"), ("ulx3s", 8, "cot_array")])
def test_a_board_says_what_it_is_and_gives_the_models_records(name: str, slots: int, tracker: str, capsys: Capture) -> None:
    with SimulatedBoard(BOARDS[name]) as simulated:
        assert main(["board", simulated.port, "--records", "40"]) == 0
        text = capsys.readouterr().out
        assert main(["board", simulated.port, "--json"]) == 0
    assert f"tracker:  {tracker}\n" in text
    assert f"slots:    {slots}\n" in text
    assert "40 records from number " in text
    result = json.loads(capsys.readouterr().out)
    assert result["records"] == 256
    assert result["first_record"] > 0
    assert result["difference"] is None
    assert result["counters"]["records"] > 0
    assert (
        result["counters"]["owned"] + result["counters"].get("passed", 0) <= result["counters"]["events"]
    )  # read at one clock


def test_a_record_that_differs_is_named_with_both_values() -> None:
    expected = expected_records(1)
    records = expected[100:110].copy()
    assert board._compared(records, expected) == (100, "")
    records["cm_y"][7] += 1
    right = int(expected[107]["cm_y"])
    assert board._compared(records, expected) == (
        100, f"record 107, cm_y: the board has {right + 1}, the golden model {right}"
    )  # fmt: skip


def test_a_board_whose_registers_were_written_is_no_twin(capsys: Capture) -> None:
    with SimulatedBoard(BOARDS["ulx3s"]) as simulated:
        with SerialHost(simulated.port, timeout_s=60) as host:
            registers = Registers(host)
            for slot in registers.slot:
                slot.clust_nev = 5
                slot.mode = 1
                slot.commit()
            host.records(300)
        assert main(["board", simulated.port, "--records", "40"]) == 1
    assert "record is none of the golden model's; was a register written since reset?" in capsys.readouterr().err


def test_a_board_that_has_run_for_long_is_to_be_reset(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(board, "_EVENTS", 2_000)
    with SimulatedBoard(BOARDS["icebreaker"]) as simulated:
        assert main(["board", simulated.port, "--records", "100"]) == 2
    assert "as many as the golden model makes here; reset the board" in capsys.readouterr().err


def test_what_a_user_may_get_wrong_is_one_line(home: Path, refused: Refused) -> None:
    assert refused("board", "/dev/ttyUSB77").startswith("/dev/ttyUSB77: cannot be opened: ")
    assert refused("board", "/dev/ttyUSB77", "--records", "0") == "--records 0: must be from 1 to 10,000"
