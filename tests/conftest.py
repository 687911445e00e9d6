# SPDX-License-Identifier: Apache-2.0
"""What the process of the tests does on signals: interrupts reach it and what it starts, and a broken pipe is an error."""

from __future__ import annotations

import signal


def pytest_configure() -> None:
    # A run in the background ignores interrupts, and what tests start would inherit that.
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish() -> None:
    assert signal.getsignal(signal.SIGPIPE) == signal.SIG_IGN, (
        "an import has changed what a broken pipe does (vcdvcd does: evcot_cosim.waves.vcd.parse puts that back); "
        "a test whose peer closes a socket would end the whole run without a word"
    )
