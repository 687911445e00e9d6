# SPDX-License-Identifier: Apache-2.0
"""Owned and passed events on AXI4-Stream stand where registers.toml says."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.streams import unpack
from evcot_cosim.stream_device import Bundle, StreamDevice, random_stalls

STREAMS = {
    "owned": ("s_own_", {"slot": 6, "x": 14, "y": 14, "p": 1, "seq": 48}, {"SLOT_W": 6, "REL_W": 14, "SEQ_W": 48}, ("user",)),
    "passed": ("s_pass_", {"x": 16, "y": 16, "p": 1, "seq": 20}, {"X_W": 16, "Y_W": 16, "SEQ_W": 20}, ()),
}


@pytest.mark.parametrize("stream", STREAMS)
def test_events_stand_in_their_words_at_any_pace(stream: str) -> None:
    prefix, widths, parameters, user = STREAMS[stream]
    output = Bundle("m_axis_t", ("data", "keep", "last", *user))
    device = StreamDevice(f"axis_{stream}_out", parameters, inputs=[Bundle(prefix, tuple(widths))], outputs=[output])
    for seed in range(3):
        rng = np.random.default_rng([8, seed])
        device.stalls = random_stalls(rng, [prefix, "m_axis_t"]) if seed else {}
        events = np.stack([rng.integers(0, 1 << bits, 2_000, np.uint64) for bits in widths.values()], 1)
        run = device.run({prefix: events})
        beats = run.words["m_axis_t"]
        found = unpack(stream, beats[:, 0])
        for column, name in enumerate(widths):
            wanted = events[:, column] & np.uint64((1 << 29) - 1 if name == "seq" else (1 << 64) - 1)
            assert np.array_equal(found[name], wanted), name
        assert set(map(tuple, beats[:, 1:3].tolist())) == {(255, 1)}
        if user:
            assert np.array_equal(beats[:, 3], events[:, 0])
    assert set((run.given["m_axis_t"][:50] - run.accepted[prefix][:50]).tolist()) >= {1}
