# SPDX-License-Identifier: Apache-2.0
"""The rules of docs/published.md as processes that wait from clock to clock: nothing in common with model or RTL.

There are no state codes, no counters and no tables: a tracker is a routine that runs from event to event, and its timers are
differences of clock numbers. One clock is a `yield` of the lines that are asserted (pulled low), which returns the inputs.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.published.model import CASCADE_OUTPUT, TRACKER_OUTPUT, PublishedConfig

__all__ = ["CascadeText", "TrackerText", "library_line", "tracker_clocks"]

Place = tuple[int, int]  # high, low
Given = Mapping[str, int]
Lines = Mapping[str, Place]
"""The asserted lines of a tracker, each with its address: ack, pass, event, centre."""

LineOutputs = tuple[bool, int, int | None]
"""Whether the line requests, its word, and the sender that it acknowledges."""

NOTHING: Place = (0, 0)


def average_step(value: Place, target: Place, k: int) -> Place:
    """floor((target + (2^k - 1) value) / 2^k) on both axes."""
    high, low = ((t + (2**k - 1) * v) // 2**k for v, t in zip(value, target, strict=True))
    return high, low


class TrackerText:
    """One tracker, from reset: `lines` are those of this clock, `clock` ends it."""

    def __init__(self, config: PublishedConfig) -> None:
        self.config = config
        self.now = 0
        self.reset()

    def reset(self) -> None:
        """What a reset does; it takes effect with the clock that follows."""
        self.tc_start = self.now
        self.overdue = False
        self.process = self.lives()
        self.lines = next(self.process)

    def clock(self, given: Given) -> None:
        """End this clock with these inputs."""
        self.now += 1
        if given.get("rst"):
            self.reset()
        else:
            self.lines = self.process.send(given)

    # ---- the timers ----

    def expired(self) -> bool:
        """Whether TC has been MaxTime in a clock of this life, before the one that has just ended."""
        due = self.tc_start + self.config.max_time
        return self.overdue or self.life_start <= due < self.now - 1

    def clear_tc(self) -> None:
        """At the end of a clock; TC is 0 in the next."""
        due = self.tc_start + self.config.max_time
        self.overdue = self.overdue or self.life_start <= due < self.now
        self.tc_start = self.now

    # ---- the life of a tracker ----

    def lives(self) -> Generator[Lines, Given, None]:
        """Life after life."""
        while True:
            while not (yield {"ack": NOTHING})["s_req_n"]:
                pass
            self.begin()
            while (yield from self.event()):
                pass

    def begin(self) -> None:
        config = self.config
        self.centre = self.average = (config.init_cm_high, config.init_cm_low)
        self.g = config.init_radix
        self.n = config.nev_th
        self.count = self.quiet = self.last = self.difference = 0
        self.first_update = True
        self.samples = [0, 0]
        self.life_start, self.overdue = self.now, False

    def event(self) -> Generator[Lines, Given, bool]:
        """From idle to idle; False at the end of the life."""
        while True:
            given = yield {}
            if self.expired():
                return False
            if not given["s_req_n"] and given["m_centre_ack_n"]:
                break
        place = given["s_high"], given["s_low"]
        yield {"ack": NOTHING}
        yield {"ack": NOTHING}
        if not self.inside(place):
            yield from self.offer("pass", place)
            return True
        self.count += 1
        if self.count < self.n:
            yield from self.offer("event", place, averages=True)
            return True
        return (yield from self.update(place))

    def offer(self, line: str, place: Place, averages: bool = False) -> Generator[Lines, Given, None]:
        """Assert a line until it is acknowledged and the request is released in one clock."""
        done = False
        while not done:
            given = yield {"ack": NOTHING, line: place}
            if averages:
                self.average = average_step(self.average, place, self.config.hist_avg)
            done = not given[f"m_{line}_ack_n"] and bool(given["s_req_n"])

    def update(self, place: Place) -> Generator[Lines, Given, bool]:
        """The N-th event; False at the end of the life."""
        self.count = 0
        yield {"ack": NOTHING}
        if self.expired():
            self.clear_tc()
            return False
        self.clear_tc()
        self.update_radius(place)
        age = self.now - self.life_start
        yield {"ack": NOTHING}
        self.update_timing(age % 2**32)
        yield {"ack": NOTHING}
        self.update_n()
        yield from self.offer("event", place)
        self.centre = average_step(self.centre, self.average, self.config.hist_avg)
        while (yield {"centre": self.centre})["m_centre_ack_n"]:
            pass
        return True

    def inside(self, place: Place) -> bool:
        reach = self.g + self.config.radix_th
        return all(
            max(centre - reach, 0) < at < min((centre + reach) % 512, 255)
            for centre, at in zip(self.centre, place, strict=True)
        )

    def update_radius(self, place: Place) -> None:
        config = self.config
        high, low = (at - centre for centre, at in zip(self.centre, place, strict=True))
        if self.first_update:
            self.first_update = False
            self.g = config.init_radix
        elif abs(high) > self.g or low < -self.g:  # not low > g: the blind edge
            self.g = min(self.g + config.radix_step, config.radix_max)
            self.quiet = 0
        elif self.quiet > 6:
            self.g = max(self.g - config.radix_step, config.radix_min)
            self.quiet = 0
        else:
            self.quiet += 1

    def update_timing(self, tc2: int) -> None:
        if tc2 > self.samples[-2]:
            self.difference = tc2 - self.samples[-2]
        self.samples.append(tc2)

    def update_n(self) -> None:
        if self.difference > 2 * self.last % 2**32 and self.n > 1:
            self.n //= 2
        elif self.difference < self.last // 2 and self.n < 128:
            self.n *= 2
        elif self.n <= 1:
            self.n = 2
        elif self.n >= 128:
            self.n = 255
        self.last = self.difference

    def outputs(self, given: Given, out: np.void) -> None:
        """Write the ports of this clock, as the model does."""
        out["s_ack_n"] = "ack" not in self.lines
        lines = {**self.lines}
        if "pass" in lines:
            lines["pass"] = given["s_high"], given["s_low"]  # wired, not latched
        for line in ("pass", "event", "centre"):
            out[f"m_{line}_req_n"] = line not in lines
            out[f"m_{line}_high"], out[f"m_{line}_low"] = lines.get(line, NOTHING)


def library_line(idle: int = 2**25 - 1) -> Generator[LineOutputs, tuple[Mapping[int, int], bool], None]:
    """The library's line, whose word is `idle` while nobody is connected.

    Gets ({sender: word} of all requests, whether the receiver acknowledges).
    """
    word, sender, acknowledged = idle, 0, None
    while True:
        while not (yield False, word, acknowledged)[0]:
            word, acknowledged = idle, None
        word, acknowledged = idle, None
        asks = taken = False
        while not taken:
            requests, taken = yield asks, word, None
            asks = bool(requests)
            if asks:
                sender = min(requests)
                word = requests[sender]
        while True:
            requests, acks = yield asks, word, acknowledged
            asks, acknowledged = False, sender
            if sender not in requests and not acks:
                break


class CascadeText:
    """Four trackers, their registers, and the library's line."""

    DEFAULTS: Mapping[int, int] = {
        79: 80, 80: 3, 81: 64, 82: 20_000_000 & 255, 83: 20_000_000 >> 8 & 255, 84: 20_000_000 >> 16 & 255, 85: 1, 86: 15,
        87: 1, 88: 0, 89: 3, 90: 17, 91: 1,
    }  # fmt: skip
    LOWS = (59, 79, 102, 5)

    def __init__(self) -> None:
        self.trackers = [TrackerText(PublishedConfig()) for _ in range(4)]
        self.reset()

    def reset(self) -> None:
        self.written = [{78: low, **self.DEFAULTS} for low in self.LOWS]
        self.selected: int | None = None
        self.line = library_line()
        self.asks, self.word, self.acked = next(self.line)
        self.told: set[int] = set()  # the trackers whose pattern cell has been told an event
        for i, tracker in enumerate(self.trackers):
            tracker.config = self.config(i)
            tracker.reset()

    def config(self, i: int) -> PublishedConfig:
        at = self.written[i]
        return PublishedConfig(
            init_cm_low=at[78], init_cm_high=at[79], radix_th=at[80], init_radix=at[81],
            max_time=at[82] + 256 * at[83] + 65536 * at[84] + 16777216 * at[85], nev_th=at[86], hist_avg=at[87],
            radix_step=at[89], radix_max=at[90], radix_min=at[91],
        )  # fmt: skip

    def write(self, address: int, data: int) -> None:
        i = self.selected
        if address == 127:
            self.selected = data - 1 if data in (1, 2, 3, 4) else None
        if i is None or address not in self.written[i]:
            return
        if address in (80, 89):
            data %= 8
        if address == 87:
            data = min(max(data, 1), 8)
        if address == 88 and data not in (0, 255):
            return
        self.written[i][address] = data
        self.trackers[i].config = self.config(i)

    def clocks(self, inputs: NDArray[np.void]) -> NDArray[np.void]:
        """The output ports just before each clock edge."""
        told = np.zeros(len(inputs), CASCADE_OUTPUT)
        for at, out in zip(inputs, told, strict=True):
            self.one({name: int(at[name]) for name in inputs.dtype.names or ()}, out)
        return told

    def one(self, given: Given, out: np.void) -> None:
        enabled = [bool(at[88]) for at in self.written]
        requests = [given["s_req_n"]]
        for on, tracker in zip(enabled, self.trackers, strict=True):
            requests.append(int("pass" not in tracker.lines) if on else requests[-1])
        acks = [given["m_pass_ack_n"]]
        for on, tracker in zip(reversed(enabled), reversed(self.trackers), strict=True):
            acks.insert(0, int("ack" not in tracker.lines) if on else acks[0])

        out["s_ack_n"], out["m_pass_req_n"] = acks[0], requests[-1]
        if not requests[-1]:
            out["m_pass_high"], out["m_pass_low"] = given["s_high"], given["s_low"]
        out["m_req_n"], out["m_word"] = not self.asks, self.word

        words = {}
        for i, tracker in enumerate(self.trackers):
            for rank, line, tag in ((i, "centre", i), (4 + i, "event", 16 + i)):
                if line in tracker.lines:
                    high, low = tracker.lines[line]
                    words[rank] = tag << 17 | high << 9 | low << 1 | (line == "event")
        acked, told = self.acked, self.told
        self.told = {i for i, tracker in enumerate(self.trackers) if "event" in tracker.lines}
        self.asks, self.word, self.acked = self.line.send((words, not given["m_ack_n"]))

        held = self.selected
        for i, tracker in enumerate(self.trackers):
            tracker.clock(
                {
                    "rst": given["rst"] or held == i,
                    "s_req_n": requests[i] if enabled[i] else 1,
                    "s_high": given["s_high"],
                    "s_low": given["s_low"],
                    "m_pass_ack_n": acks[i + 1],
                    "m_event_ack_n": int(acked != 4 + i or i not in told),
                    "m_centre_ack_n": int(acked != i),
                }
            )
        if given["cfg_valid"]:
            self.write(given["cfg_addr"], given["cfg_data"])
        if given["rst"]:
            self.reset()


def tracker_clocks(tracker: TrackerText, inputs: NDArray[np.void]) -> NDArray[np.void]:
    """The output ports just before each clock edge."""
    told = np.zeros(len(inputs), TRACKER_OUTPUT)
    names: Sequence[str] = inputs.dtype.names or ()
    for i, at in enumerate(inputs):
        given = {name: int(at[name]) for name in names}
        tracker.outputs(given, told[i])
        tracker.clock(given)
    return told
