# SPDX-License-Identifier: Apache-2.0
"""Hardware and model against a second reading of docs/published.md, tests/support/published_text.py, clock by clock.

Senders and receivers follow the second reading, in closed loop; what they drove is then replayed to hardware and model.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.hardware.published.model import PublishedCascade, PublishedConfig, PublishedTracker
from evcot_cosim.devices.published_device import LIBRARY, TRACKER, equal, quiet, reset_cascade, rtl
from support.published import noise, reset_tracker, some_registers, wandering
from support.published_text import CascadeText, TrackerText, tracker_clocks

Lines = dict[str, int]


class Partner:
    """One side of a 4-phase handshake that answers after random delays: a receiver of `line`, or, without, the sender."""

    def __init__(self, rng: np.random.Generator, slow: int) -> None:
        self.delays = rng.integers(0, slow, 4096, endpoint=True).tolist()
        self.waits = 0
        self.low = False

    def answer(self, wanted: bool) -> int:
        """The line in this clock: low as soon as `wanted` has lasted for the delay, and high again likewise."""
        if wanted != self.low:
            if self.waits == 0:
                self.low = wanted
                self.waits = self.delays.pop() if self.delays else 0
            else:
                self.waits -= 1
        return int(not self.low)


def driven(rng: np.random.Generator, n: int, config: PublishedConfig) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """Inputs of n clocks of the single tracker between partners of any speed, and the outputs by the text."""
    pace, *slow = (int(value) for value in rng.choice([0, 0, 2, 7, 30], 4))
    sender = Partner(rng, pace)
    receivers = {line: Partner(rng, delay) for line, delay in zip(("pass", "event", "centre"), slow, strict=True)}
    near = rng.integers(-config.init_radix - 9, config.init_radix + 10, (2, n)) // int(rng.choice([1, 3]))
    high, low = np.clip(near + np.array([[config.init_cm_high], [config.init_cm_low]]), 0, 255)
    inputs = quiet(TRACKER, n)
    text = TrackerText(config)
    told = np.zeros(n, TRACKER.read)
    for i in range(n):
        given = {"s_req_n": sender.answer("ack" not in text.lines), "s_high": int(high[i // 8]), "s_low": int(low[i // 8])}
        given |= {f"m_{line}_ack_n": partner.answer(line in text.lines) for line, partner in receivers.items()}
        text.outputs(given, told[i])
        text.clock(given)
        for name, value in given.items():
            inputs[name][i] = value
    return inputs, told


@pytest.mark.parametrize("seed", range(24))
def test_the_lone_tracker_between_partners_of_any_speed(seed: int) -> None:
    rng, n = np.random.default_rng([30, seed]), 8_000
    config = replace(
        some_registers(rng), init_radix=int(rng.integers(4, 120)), nev_th=int(rng.choice([0, 1, 3, 15, 40])),
        max_time=int(rng.choice([132, 400, 1500, 2**32 - 1])),
    )  # fmt: skip
    inputs, told = driven(rng, n, config)
    reset_tracker(config)
    equal(rtl(TRACKER, inputs), told, inputs, seed)
    equal(PublishedTracker(config).clocks(inputs), told, inputs, seed)
    assert (told["s_ack_n"] == 0).sum() > n // 10


def test_what_happens_under_these_partners() -> None:
    """The runs above visit every line and life after life."""
    counts = np.zeros(4, np.int64)
    for seed in range(6):
        rng = np.random.default_rng([31, seed])
        config = replace(some_registers(rng), init_radix=40, radix_max=60, radix_min=20, nev_th=5, max_time=400)
        _, told = driven(rng, 4_000, config)
        lines = [told[name] == 0 for name in ("m_pass_req_n", "m_event_req_n", "m_centre_req_n")]
        starts = [int((np.diff(line.astype(int)) == 1).sum()) for line in lines]
        dead = (told["s_ack_n"] == 0) & ~lines[0] & ~lines[1]
        counts += [*starts, int(dead.sum())]
    assert (counts > 100).all(), counts


@pytest.mark.parametrize("seed", range(12))
def test_the_lone_tracker_under_lines_that_keep_no_protocol(seed: int) -> None:
    rng, n = np.random.default_rng([32, seed]), 10_000
    config = some_registers(rng)
    inputs = quiet(TRACKER, n)
    for name in ("s_req_n", "m_pass_ack_n", "m_event_ack_n", "m_centre_ack_n"):
        inputs[name] = noise(rng, n)
    inputs["s_high"], inputs["s_low"] = wandering(rng, n, config.init_cm_high), wandering(rng, n, config.init_cm_low)
    inputs["rst"] = rng.random(n) < rng.choice([0, 1e-3])
    told = tracker_clocks(TrackerText(config), inputs)
    reset_tracker(config)
    equal(rtl(TRACKER, inputs), told, inputs, seed)


class TestLibrary:
    @pytest.mark.parametrize("seed", range(8))
    def test_under_lines_that_keep_no_protocol_and_registers_written_at_any_time(self, seed: int) -> None:
        rng, n = np.random.default_rng([33, seed]), 6_000
        configs = [replace(some_registers(rng), enable=bool(rng.random() < 0.8)) for _ in range(4)]
        writes = [write for i, config in enumerate(configs) for write in config.writes(i)] + [(127, 0)]
        inputs = quiet(LIBRARY, n)
        for name in ("s_req_n", "m_pass_ack_n", "m_ack_n"):
            inputs[name] = noise(rng, n)
        inputs["s_high"] = wandering(rng, n, configs[seed % 4].init_cm_high)
        inputs["s_low"] = wandering(rng, n, configs[seed % 4].init_cm_low)
        inputs["cfg_valid"][: len(writes)] = 1
        inputs["cfg_addr"][: len(writes)], inputs["cfg_data"][: len(writes)] = np.array(writes).T
        late = np.arange(n) > n // 2
        inputs["cfg_valid"] |= late & (rng.random(n) < 0.02)
        addresses = np.where(rng.random(n) < 0.3, 127, rng.integers(76, 94, n))
        values = np.where(addresses == 127, rng.integers(0, 8, n), rng.choice([0, 1, 9, 255, 77], n))
        inputs["cfg_addr"], inputs["cfg_data"] = (
            np.where(late, new, inputs[name]) for name, new in (("cfg_addr", addresses), ("cfg_data", values))
        )
        reset_cascade(LIBRARY, [])
        told = CascadeText().clocks(inputs)
        equal(rtl(LIBRARY, inputs), told, inputs, seed)

    @pytest.mark.parametrize("seed", range(8))
    def test_between_partners_of_any_speed(self, seed: int) -> None:
        """The receivers release at once; the model's bench drives, hardware and text follow."""
        rng, n = np.random.default_rng([34, seed]), 600
        centre = rng.integers(40, 216, (4, 2))
        configs = [
            replace(some_registers(rng), init_cm_high=int(high), init_cm_low=int(low), init_radix=int(rng.integers(5, 30)))
            for high, low in centre
        ]
        high, low = np.clip(centre[rng.integers(4, size=n)].T + rng.integers(-20, 21, (2, n)), 0, 255)
        model = PublishedCascade(configs)
        clock = model.clock + np.cumsum(rng.integers(rng.choice([2, 20, 60]), size=n))
        played = model.play(clock, high, low, trace=True)
        reset_cascade(LIBRARY, configs)
        equal(rtl(LIBRARY, played.inputs), played.outputs, played.inputs, seed)

        text = CascadeText()
        before = quiet(LIBRARY, model.clock - len(played.inputs) - 1)
        writes = [write for i, config in enumerate(configs) for write in config.writes(i)] + [(127, 0)]
        before["cfg_valid"][: len(writes)] = 1
        before["cfg_addr"][: len(writes)], before["cfg_data"][: len(writes)] = np.array(writes).T
        text.clocks(before)
        equal(text.clocks(played.inputs), played.outputs, played.inputs, seed)

    @pytest.mark.parametrize("seed", range(6))
    @pytest.mark.parametrize("receiver", ["late", "early", "random"])
    def test_receivers_that_acknowledge_late_early_or_at_random_with_all_trackers_competing(
        self, receiver: str, seed: int
    ) -> None:
        """Late ones release late as well, so that trackers meet a stale acknowledge; early ones acknowledge without a word."""
        rng, n = np.random.default_rng([35, seed, len(receiver)]), 5_000
        places = np.array([(60, 60), (60, 190), (190, 60), (190, 190)])
        configs = [
            PublishedConfig(
                init_cm_high=int(high), init_cm_low=int(low), init_radix=12, radix_max=20, radix_min=8,
                nev_th=int(rng.integers(1, 6)), hist_avg=int(rng.integers(1, 4)), max_time=int(rng.choice([900, 10_000_000])),
            )
            for high, low in places
        ]  # fmt: skip
        high, low = (places[rng.integers(4, size=n)] + rng.integers(-9, 10, (n, 2))).T
        text, inputs, told = CascadeText(), quiet(LIBRARY, n), np.zeros(n, LIBRARY.read)
        writes = [write for i, config in enumerate(configs) for write in config.writes(i)] + [(127, 0)]
        before = quiet(LIBRARY, len(writes) + 1)
        before["cfg_valid"][:-1] = 1
        before["cfg_addr"][:-1], before["cfg_data"][:-1] = np.array(writes).T
        text.clocks(before)
        sender, partner = Partner(rng, int(rng.choice([0, 2, 7]))), Partner(rng, int(rng.choice([2, 7, 30])))
        toggling = noise(rng, n)
        event = 0
        for i in range(n):
            wanted = {"late": text.asks, "early": not partner.low, "random": not toggling[i]}[receiver]
            inputs["m_ack_n"][i] = toggling[i] if receiver == "random" else partner.answer(wanted)
            requested = sender.low
            inputs["s_req_n"][i] = sender.answer("ack" not in text.trackers[0].lines)
            event += sender.low and not requested
            inputs["s_high"][i], inputs["s_low"][i] = high[event], low[event]
            inputs["m_pass_ack_n"][i] = 0
            told[i : i + 1] = text.clocks(inputs[i : i + 1])
        reset_cascade(LIBRARY, configs)
        equal(rtl(LIBRARY, inputs), told, inputs, seed)
        equal(PublishedCascade(configs).clocks(inputs), told, inputs, seed)

        acks = (told["m_req_n"] == 0) & (inputs["m_ack_n"] == 0)
        replaced = acks[:-1] & (told["m_req_n"][1:] == 0) & (told["m_word"][1:] != told["m_word"][:-1])
        owners = {int(word) >> 17 for word in told["m_word"][acks]}
        print(f"{receiver}, seed {seed}: {event} events, {int(replaced.sum())} replaced in the clock of the acknowledge")
        assert event > 20
        assert len(owners) > 2
        assert replaced.any() or receiver == "random"
