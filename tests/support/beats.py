# SPDX-License-Identifier: Apache-2.0
"""Support for tests of axis_owned_out.v and axis_passed_out.v: random events must be packed as the register map defines."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from evcot.hardware.registers import register_map
from evcot.hardware.streams import unpack

from .stream_device import Bundle, StreamDevice, random_stalls

__all__ = ["event_beats"]


def event_beats(stream: str, prefix: str, widths: Mapping[str, int], parameters: Mapping[str, int], user: str = "") -> None:
    """Stream random events through `axis_<stream>_out`, first without stalls and then with random ones.

    Args:
        stream: the layout's name in the register map.
        prefix: prefix of the event ports.
        widths: bits of each port; a narrower field of the beat drops the high bits.
        parameters: Verilog parameters of the module.
        user: the field that tuser repeats, if any.

    Raises:
        AssertionError: a field is not where the map puts it, or an event is not sent as one packet a clock later.
    """
    output = Bundle("m_axis_t", ("data", "keep", "last", *(["user"] if user else [])))
    device = StreamDevice(f"axis_{stream}_out", parameters, inputs=[Bundle(prefix, tuple(widths))], outputs=[output])
    layout = next(word for word in register_map().streams if word.name == stream)
    bits = {field.name: field.bits for field in layout.fields}
    for seed in range(3):
        rng = np.random.default_rng([8, seed])
        device.stalls = random_stalls(rng, [prefix, "m_axis_t"]) if seed else {}
        events = np.stack([rng.integers(0, 1 << width, 2_000, np.uint64) for width in widths.values()], 1)
        run = device.run({prefix: events})
        beats = run.words["m_axis_t"]
        found = unpack(stream, beats[:, 0])
        for column, name in enumerate(widths):
            wanted = events[:, column] & np.uint64((1 << bits[name]) - 1)
            assert np.array_equal(found[name], wanted), name
            assert name != user or np.array_equal(beats[:, 3], wanted)
        assert set(map(tuple, beats[:, 1:3].tolist())) == {(255, 1)}
        if not seed:
            assert set((run.given["m_axis_t"] - run.accepted[prefix]).tolist()) == {1}
            assert set(np.diff(run.given["m_axis_t"]).tolist()) == {1}
