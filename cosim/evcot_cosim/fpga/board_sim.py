# SPDX-License-Identifier: Apache-2.0
"""Simulation of a whole board, with its serial line on a pseudo-terminal, so that host software can talk to it."""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import tempfile
import threading
import tty
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from evcot.templating import templates

from ..rtl.build import PORTS_ONLY_FLAGS, build
from ..rtl.files import copy_rtl
from .board import board_dir
from .serial_host import BAUD

__all__ = ["BOARDS", "Board", "SimulatedBoard", "sources"]

_CLOCKS = 20_000  # between two polls of the line


class Board(NamedTuple):
    """A board: its clock, names of its pins, number of tracker slots, and device.

    Attributes:
        leds: port of the LEDs, and its mask and value when the self-test has passed.
    """

    name: str
    title: str
    clock_hz: int
    clock: str
    rx: str
    tx: str
    button: str
    slots: int
    leds: tuple[str, int, int]
    device: str
    constraints: str


_TABLE = (
    Board(
        "icebreaker", "iCEBreaker", 12_000_000, "clk", "rx", "tx", "btn_n", 1, ("led_green_n", 1, 0), "up5k",
        "icebreaker.pcf",
    ),
    Board(
        "ulx3s", "ULX3S", 25_000_000, "clk_25mhz", "ftdi_txd", "ftdi_rxd", "btn_n", 8, ("led", 3, 1), "ecp5-85",
        "ulx3s.lpf",
    ),
    Board(
        "ecp5_evn", "ECP5 Evaluation Board", 12_000_000, "clk", "rx", "tx", "btn_n", 8, ("led_n", 3, 2), "ecp5-85-5g",
        "ecp5_evn.lpf",
    ),
)  # fmt: skip

BOARDS = {board.name: board for board in _TABLE}


def sources(folder: Path) -> Path:
    """Copy all Verilog sources of the boards to a folder, and return it."""
    copy_rtl(folder)
    for origin in (board_dir(), board_dir() / "boards"):
        for path in origin.glob("*.v*"):
            shutil.copyfile(path, folder / path.name)
    return folder


class SimulatedBoard:
    """A context manager that runs the clock of a simulated board.

    Attributes:
        port: device of its serial line, for `SerialHost`.

    Raises:
        ToolchainError: it cannot be built.
    """

    def __init__(self, board: Board, verilog: Path | None = None) -> None:
        self.board = board
        divisor = round(board.clock_hz / BAUD)
        pins = {"clock": board.clock, "rx": board.rx, "tx": board.tx}
        drive = templates("evcot_cosim.fpga").get_template("board.cpp.j2").render(top=board.name, divisor=divisor, **pins)
        with tempfile.TemporaryDirectory() as folder:
            sources_at = verilog or sources(Path(folder))
            model = build(board.name, {}, {"board.cpp": drive}, extra_flags=PORTS_ONLY_FLAGS, verilog=sources_at)
        self.sim = model.load()
        run = self.sim.lib.evcot_board
        run.restype = ctypes.c_int64
        run.argtypes = (
            ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_char_p, ctypes.c_int64,
            ctypes.POINTER(ctypes.c_int64), ctypes.c_char_p, ctypes.c_int64,
        )  # fmt: skip
        self.sim.lib.evcot_line.restype = ctypes.c_void_p
        self._line = ctypes.c_void_p(self.sim.lib.evcot_line())
        self._ours, theirs = os.openpty()
        self.port = os.ttyname(theirs)
        self._theirs = theirs
        tty.setraw(theirs)
        os.set_blocking(self._ours, False)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        setattr(self.sim.io, board.button, 1)

    def __enter__(self) -> SimulatedBoard:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._stop.set()
        self._thread.join()
        for end in (self._ours, self._theirs):
            os.close(end)
        self.sim.lib.evcot_line_end(self._line)

    @property
    def passed(self) -> bool:
        """Whether the LEDs show exactly that the self-test has passed."""
        port, mask, value = self.board.leds
        return int(getattr(self.sim.io, port)) & mask == value

    def _run(self) -> None:
        """Run the clock and transfer bytes in both directions until the context is left."""
        waiting, taken = b"", ctypes.c_int64()
        out = ctypes.create_string_buffer(4096)
        while not self._stop.is_set():
            with contextlib.suppress(BlockingIOError):
                waiting += os.read(self._ours, 4096)
            given = self.sim.lib.evcot_board(
                self.sim.model, self._line, _CLOCKS, waiting, len(waiting), ctypes.byref(taken), out, len(out)
            )
            waiting = waiting[taken.value :]
            self._send(out.raw[:given])

    def _send(self, data: bytes) -> None:
        """Write to the line; while it is full, the board's clock stops."""
        while data and not self._stop.is_set():
            with contextlib.suppress(BlockingIOError):
                data = data[os.write(self._ours, data) :]
