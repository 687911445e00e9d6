# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Drive the RTL by hand
#
# One tracker in Verilog as a Python object: pins and a clock, a waveform that answers questions, and the same events again
# through the fast drive.

# %%
from pathlib import Path

import numpy as np

from evcot import CotConfig, Kind, Mode, Shape, SlotConfig, State, TickedEvents
from evcot_cosim import Device
from evcot_cosim.waves import Wave, after, handshake_stable, recorded, transitions, write_view

# %% [markdown]
# ## A tracker
#
# `cot` is a single Cluster Object Tracker. Its window of 13 x 13 pixels waits at (64, 64), and it says where its centre is
# after every second event (`clust_nev`). The first call compiles the Verilog; after that the model comes from a cache.

# %%
shape = Shape(n_slots=1, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=8, seq_w=16, time_w=20)
slot = SlotConfig(
    mode=Mode.FIXED, init_cm_x=64, init_cm_y=64, init_radix=4, radix_th=2, radix_step=0, radix_min=4, radix_max=4,
    hist_avg=1, max_ticks=20, clust_nev=2, nev_min=2, nev_max=2, nev_th=0, detect_ticks=100,
)  # fmt: skip
device = Device(CotConfig(shape, (slot,), module="cot"))
pins, clock = device.sim.io, device.sim.clock

# %% [markdown]
# ## Events in, a record out
#
# Every stream is a ready/valid handshake. An event is taken at the clock at which `s_valid` and `s_ready` are both high; a
# record is offered with `m_cm_valid`. `recorded` writes all of it into a waveform.

# %%
events = [(1, 66, 64), (2, 66, 66), (3, 90, 20)]  # tick, x, y: two in the window, one far outside
records, owned, passed = [], [], []


def tick() -> bool:
    """One clock; note what the tracker gives, and return whether it took an event."""
    taken = bool(pins.s_valid and pins.s_ready)
    if pins.m_cm_valid:
        records.append((Kind(int(pins.m_cm_kind)).name, pins.m_cm_x / 16, pins.m_cm_y / 16, int(pins.m_cm_seq)))
    if pins.m_own_valid:
        owned.append((int(pins.m_own_x), int(pins.m_own_y)))
    if pins.m_pass_valid and pins.m_pass_event:
        passed.append((int(pins.m_pass_x), int(pins.m_pass_y)))
    clock.tick()
    return taken


with recorded(device.sim, Path("cot.vcd")):
    pins.m_cm_ready = pins.m_own_ready = pins.m_pass_ready = 1
    before = 0
    for seq, (at, x, y) in enumerate(events):
        pins.s_valid, pins.s_event, pins.s_tick, pins.s_seq = 1, 1, at - before, seq
        pins.s_x, pins.s_y, before = x, y, at
        while not tick():
            pass
    pins.s_valid = 0
    for _ in range(8):
        tick()
print("records:", *records)
print("owned:  ", *owned)
print("passed: ", *passed)

# %% [markdown]
# Two events make the birth: the mean of their places has moved from (64, 64) towards them. Owned events leave with their
# address in the window, the third passes on as it came.
#
# ## State by name

# %%
wave = Wave.open("cot.vcd")
s = wave.sampled("TOP.clk")
states = [State(int(value)).name for value in s["state"].values]
print(*(state for state, previous in zip(states, [None, *states], strict=False) if state != previous), sep=" > ")

# %% [markdown]
# ## Ask the waveform
#
# A property that holds says in how many cases; one that does not raises an error that shows the signals around the first
# failure. [waveforms.md](../waveforms.md) has all of them.

# %%
rules = {
    State.INIT_CELL: {State.IDLE},
    State.IDLE: {State.EV_DISCRI, State.INIT_CELL},
    State.EV_DISCRI: {State.EV_PASS_TH, State.EV_NO_PROC, State.EV_PROC},
    State.EV_PASS_TH: {State.EV_PROC, State.IDLE},
    State.EV_NO_PROC: {State.IDLE},
    State.EV_PROC: {State.IDLE},
}
print(transitions(s["state"], rules), "state changes, all legal")
print(handshake_stable(*s.stream("TOP.s"), where=~s["TOP.rst"]), "cases in which the input keeps what it offers")
taken = s["TOP.s_valid"] & s["TOP.s_ready"]
answer = s["TOP.m_own_valid"] | s["TOP.m_pass_valid"]
print(after(taken).within(3).expect(answer), "events, each owned or passed within 3 clocks")

# %% [markdown]
# ## See it
#
# `gtkwave cot.vcd cot.gtkw` opens the waveform with its signals grouped, states by name and centres as curves.

# %%
write_view(Path("cot.vcd"), Path("cot.gtkw"))

# %% [markdown]
# ## The same at full speed
#
# `stream` drives arrays of events through the same hardware in C++, millions a second. After a reset it must decide as the
# pins did.

# %%
device.reset()
ticks, x, y = (np.array(column) for column in zip(*events, strict=True))
streamed = device.stream(TickedEvents(ticks, x, y, np.zeros_like(ticks)))
again = [(Kind(int(r["kind"])).name, float(r["cm_x"] / 16), float(r["cm_y"] / 16), int(r["seq"])) for r in streamed.records]
assert again == records
took = streamed.owner >= 0
assert list(zip(streamed.rel_x[took], streamed.rel_y[took], strict=True)) == owned
assert list(zip(x[~took], y[~took], strict=True)) == passed
print("streaming and pins agree:", *again)
