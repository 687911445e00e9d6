# SPDX-License-Identifier: Apache-2.0
"""Streams out of `evcot_top`: records, owned events, passed events."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.hardware.classifier import VERDICT_KIND, VERDICT_RECORD
from evcot.hardware.contract import RECORD
from evcot.hardware.motion.contract import MOTION_RECORD
from support.beats import event_beats
from support.stream_device import Bundle, StreamDevice, StreamRun, check_reset, random_stalls

COMMON = {"kind": 2, "slot": 3, "id": 32, "other": 32}
REST = {"support": 16, "seq": 48, "time": 48}
FIELDS = {**COMMON, "x": 13, "y": 13, "radius": 9, "n_ev": 10, **REST}
OF_MOTION = {**COMMON, "x": 25, "y": 25, "width": 25, "height": 25, "v_x": 16, "v_y": 16, "n_ev": 10, **REST}
SIGNED = ("x", "y", "v_x", "v_y")
OF_RECORD = {"id": "track_id", "other": "other_id", "x": "cm_x", "y": "cm_y"}
INPUT = Bundle("s_cm_", tuple(FIELDS))


def device_of(width: int, depth: int = 4, *, motion: bool = False, packet: int = 1, wait: int = 0) -> StreamDevice:
    """Beats of up to 64 bits: wider ones are seen by evcot_top's own drive."""
    outputs = [Bundle("m_axis_t", ("data", "keep", "last"))]
    parameters = {"DATA_W": width, "DEPTH": depth} | ({"MOTION": 1, "X_W": 25, "Y_W": 25} if motion else {})
    given = Bundle("s_cm_", tuple(OF_MOTION)) if motion else INPUT
    ports = {"packet_records": packet, "packet_wait": wait}
    return StreamDevice("axis_records_out", parameters, inputs=[given], outputs=outputs, ports=ports, has_idle=True)


def random_records(rng: np.random.Generator, n: int, *, motion: bool = False) -> tuple[NDArray[np.uint64], NDArray[np.void]]:
    """Words of the input, and the records that they are."""
    fields = OF_MOTION if motion else FIELDS
    words = np.stack([rng.integers(0, 1 << bits, n, np.uint64, endpoint=False) for bits in fields.values()], 1)
    records = np.zeros(n, MOTION_RECORD if motion else RECORD)
    for column, (name, bits) in enumerate(fields.items()):
        values = words[:, column].astype(np.int64)
        if motion and name in SIGNED:
            values -= (values >> (bits - 1)) << bits
        records[OF_RECORD.get(name, name)] = values
    return words, records


def joined(run: StreamRun, width: int, record: np.dtype[np.void] = RECORD, packet: int = 1) -> NDArray[np.void]:
    """The bytes that tkeep lets stand, as records, in packets of so many."""
    beats = run.words["m_axis_t"]
    data = beats[:, 0].astype(f"<u{width // 8}").view(np.uint8).reshape(len(beats), width // 8)
    keep = np.unpackbits(beats[:, 1].astype(np.uint8)[:, None], axis=1, bitorder="little")[:, : width // 8].astype(bool)
    length = packet * -(-8 * record.itemsize // width)
    assert beats[:, 2].tolist() == [int(i % length == length - 1) for i in range(len(beats))]
    return np.frombuffer(data[keep].tobytes(), record)


@pytest.mark.parametrize("width", [32, 64])
def test_verdicts_come_out_byte_for_byte(width: int) -> None:
    fields = {"slot": 3, "id": 32, "seq": 48, "class": 4, "margin": 15, "windows": 8}
    given, outputs = Bundle("s_verdict_", tuple(fields)), [Bundle("m_axis_t", ("data", "keep", "last"))]
    parameters = {"DATA_W": width, "DEPTH": 4, "MOTION": 1, "CLASSIFY": 1, "X_W": 25, "Y_W": 25}
    ports = {"packet_records": 1, "packet_wait": 0}
    device = StreamDevice("axis_records_out", parameters, inputs=[given], outputs=outputs, ports=ports, has_idle=True)
    rng = np.random.default_rng(2)
    words = np.stack([rng.integers(0, 1 << bits, 50, np.uint64) for bits in fields.values()], 1)
    wanted = np.zeros(50, VERDICT_RECORD)
    wanted["kind"] = VERDICT_KIND
    for name, column in zip(("slot", "track_id", "seq", "class_index", "margin", "windows"), words.T, strict=True):
        wanted[name] = column
    assert np.array_equal(joined(device.run({"s_verdict_": words}), width, wanted.dtype), wanted)


@pytest.mark.parametrize("packet", [1, 3])
def test_reset_amid_records_leaves_nothing(packet: int) -> None:
    check_reset(device_of(64, packet=packet, wait=1), {"s_cm_": random_records(np.random.default_rng(1), 60)[0]})


@pytest.mark.parametrize("motion", [False, True], ids=["radius", "motion"])
@pytest.mark.parametrize("width", [32, 64])
def test_records_come_out_byte_for_byte_at_any_pace(width: int, motion: bool) -> None:
    device = device_of(width, motion=motion)
    for seed in range(4):
        rng = np.random.default_rng([5, seed])
        device.stalls = random_stalls(rng, [INPUT.prefix, "m_axis_t"]) if seed else {}
        words, records = random_records(rng, 500, motion=motion)
        assert np.array_equal(joined(device.run({INPUT.prefix: words}), width, records.dtype), records)


@pytest.mark.parametrize(("packet", "wait"), [(3, 0), (7, 60_000), (500, 0)])
def test_tlast_ends_packets_of_so_many_records(packet: int, wait: int) -> None:
    device = device_of(64, packet=packet, wait=wait)
    rng = np.random.default_rng([6, packet])
    device.stalls = random_stalls(rng, [INPUT.prefix, "m_axis_t"])
    words, records = random_records(rng, 42 * packet if packet < 100 else packet)
    assert np.array_equal(joined(device.run({INPUT.prefix: words}), 64, packet=packet), records)


def test_a_packet_ends_when_its_time_is_over() -> None:
    """The last beat of a record waits for the next record, or for the end of the time."""
    device = device_of(64, packet=100, wait=2)
    words = random_records(np.random.default_rng(1), 5)[0]
    two = device.run({INPUT.prefix: words[:2]})
    assert two.words["m_axis_t"][:, 2].tolist() == [0] * 11 + [1]
    given = two.given["m_axis_t"]
    assert given[5] - given[4] == 1  # the second record is there
    assert 512 - 20 < given[11] - given[5] < 512 + 20
    three = device.run({INPUT.prefix: words[2:]})
    assert three.words["m_axis_t"][:, 2].tolist() == [0] * 17 + [1]


def test_a_record_that_is_not_accepted_before_the_source_starts_again_is_left_out() -> None:
    device = device_of(64)
    sim, io = device.sim, device.sim.io
    io.s_cm_valid, io.s_cm_seq = 1, 1
    for _ in range(3):
        sim.clock.tick()
    assert io.s_cm_ready == 0
    io.s_cm_valid, io.s_rst = 0, 1
    sim.clock.tick()
    io.s_rst = 0
    words, records = random_records(np.random.default_rng(1), 3)
    assert np.array_equal(joined(device.run({INPUT.prefix: words}), 64), records)


def test_a_record_takes_3_clocks_to_its_first_beat_and_then_a_beat_per_clock() -> None:
    device = device_of(64)
    run = device.run({INPUT.prefix: random_records(np.random.default_rng(1), 3)[0]})
    assert run.given["m_axis_t"][0] - run.accepted[INPUT.prefix][0] == 3
    assert set(np.diff(run.given["m_axis_t"]).tolist()) == {1}


def test_records_wait_for_a_receiver_that_does_not_listen() -> None:
    device = device_of(64, 4)
    device.stalls = {"m_axis_t": np.array([0] * 4095 + [1], np.uint8)}
    run = device.run({INPUT.prefix: random_records(np.random.default_rng(1), 20)[0]}, clocks=100)
    assert len(run.accepted[INPUT.prefix]) == 4


def test_is_idle_when_the_last_beat_has_gone() -> None:
    sim = device_of(64).sim
    io = sim.io
    io.s_cm_valid, io.m_axis_tready = 1, 1
    for _ in range(6):
        sim.clock.tick()
    io.s_cm_valid = 0
    for _ in range(7):  # 3 clocks to the first of 6 beats
        sim.clock.tick()
    io.m_axis_tready = 0
    for _ in range(3):
        sim.clock.tick()
        assert (io.m_axis_tvalid, io.m_axis_tlast, io.idle) == (1, 1, 0)
    io.m_axis_tready = 1
    sim.clock.tick()
    assert (io.m_axis_tvalid, io.idle) == (0, 1)


def test_events_stand_in_their_beats_at_any_pace() -> None:
    widths = {"slot": 6, "x": 14, "y": 14, "p": 1, "seq": 48}
    event_beats("owned", "s_own_", widths, {"SLOT_W": 6, "REL_W": 14, "SEQ_W": 48}, user="slot")


def test_axis_passed_out_events_stand_in_their_beats_at_any_pace() -> None:
    widths = {"x": 16, "y": 16, "p": 1, "seq": 48}
    event_beats("passed", "s_pass_", widths, {"X_W": 16, "Y_W": 16, "SEQ_W": 48})
