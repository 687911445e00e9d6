# SPDX-License-Identifier: Apache-2.0
"""evcot_top with the classifier: its verdicts among the records, and its registers and weights on the bus."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.hardware.classifier import CLASSIFIER_REGISTERS, VERDICT_KIND, VERDICT_RECORD, RecognitionRegisters
from evcot.hardware.config import MotionConfig
from evcot.hardware.model import Decisions
from evcot.hardware.motion.contract import MotionRegisters
from evcot.hardware.motion.model import MotionModel
from evcot.hardware.register_access import Registers
from evcot.hardware.registers import BusError, register_map
from evcot.hardware.streams import pack_events
from evcot.recognition.loading import load
from evcot.recognition.model import Classifier, Network, OwnedEvents
from evcot.recognition.weight_memory import memory_words
from evcot.recognition.weights import Weights
from evcot.ticks import TickedEvents
from evcot.tracks.record import last_until
from evcot_cosim.devices.top_device import (
    Command,
    Pace,
    TopDevice,
    TopRun,
    address_of,
    bank_address,
    classifier_weights,
    classifier_writes,
    poll,
    poll_status,
    read,
    slot_address,
    write,
)
from support.classifier_trials import random_network as network_of_ten
from support.classifier_trials import random_registers
from support.moving import QUICK, VARIANTS, scene
from support.top import BUILDS, device_of

BUILD = BUILDS["classifier"]
CONFIG = MotionConfig(BUILD.shape, QUICK, filter_shape=BUILD.filter_shape)
CONTROL, FAULT = address_of("control"), address_of("fault")
ADDRESS, DATA = address_of("weight_address"), address_of("weight_data")
COMMIT, ENABLE = bank_address("classifier"), bank_address("classifier", "enable")
CLAMPED, REFUSED, LOCKED, UNMAPPED = 1, 2, 4, 8
SETTLED = poll_status("pending", 0)
LAST = 2735  # word of the weights
QUIET = 15_000  # clocks: the windows of all slots are evaluated, and the slowest output has given what waits


class Setting(NamedTuple):
    """What the classifier works with from an event on; None: it is off."""

    seq: int
    registers: RecognitionRegisters | None
    network: Network


def random_network(rng: np.random.Generator, classes: int = 10) -> Network:
    found = network_of_ten(rng)
    return Network(found.w1, found.w2[:, :classes].copy())


def words_of(traffic: TickedEvents) -> NDArray[np.uint64]:
    return pack_events(traffic.ticks, traffic.x, traffic.y, traffic.p)


def traffic_of(seed: int, n: int = 40_000) -> TickedEvents:
    found = scene(seed, n)
    return replace(found, ticks=found.ticks - found.ticks[0])


def golden(config: MotionConfig, traffic: TickedEvents, settings: list[Setting]) -> tuple[Decisions, NDArray[np.void]]:
    """Decisions and verdicts of the golden models."""
    model = MotionModel(config)
    decided = model.feed(traffic)
    found = []
    for n, (seq, registers, network) in enumerate(settings):
        end = settings[n + 1].seq if n + 1 < len(settings) else len(traffic)
        if registers is None:
            continue
        classifier = Classifier(registers, network, config.shape.n_slots, config.shape.rel_w)
        raw = classifier.feed(OwnedEvents(*(column[seq:end] for column in (*decided[1:], model.visible))))
        verdicts = np.zeros(len(raw), VERDICT_RECORD)
        for name, column in {"seq": raw["seq"] + seq, "class_index": raw["class"], "kind": VERDICT_KIND}.items():
            verdicts[name] = column
        for name in ("slot", "margin", "windows"):
            verdicts[name] = raw[name]
        records = decided.records
        last = last_until(records["slot"], records["seq"], verdicts["slot"].astype(np.int64), verdicts["seq"].astype(np.int64))
        verdicts["track_id"] = records["track_id"][last]
        found.append(verdicts)
    return decided, np.concatenate([np.zeros(0, VERDICT_RECORD), *found])


def assert_same(played: TopRun, decided: Decisions, verdicts: NDArray[np.void]) -> None:
    for mine, theirs in zip(played.decisions(0, len(decided.owner)), decided, strict=True):
        assert np.array_equal(mine, theirs)
    for n, (got, wanted) in enumerate(zip(played.verdicts.tolist(), verdicts.tolist(), strict=False)):
        assert got == wanted, f"verdict {n} of {len(verdicts)}: {VERDICT_RECORD.names}"
    assert len(played.verdicts) == len(verdicts)


def started(device: TopDevice, registers: RecognitionRegisters, network: Network) -> Setting:
    """The classifier is on before the first event."""
    device.configure()
    device.run(commands=[*classifier_weights(network), *classifier_writes({**asdict(registers), "enable": 1}), SETTLED])
    assert device.read(FAULT) & 15 == 0
    return Setting(0, registers, network)


def fault(device: TopDevice) -> tuple[int, int]:
    """Which faults have happened and where the last one was; clears them."""
    word = device.read(FAULT)
    device.write(FAULT, 15)
    return word & 15, word >> 16


@pytest.mark.parametrize("seed", range(4))
def test_verdicts_and_records_are_exact_under_stalls(seed: int) -> None:
    rng = np.random.default_rng([30, seed])
    device = device_of("classifier", CONFIG, pace=Pace.random(rng) if seed else None)
    registers = random_registers(rng)
    network = random_network(rng, registers.classes)
    traffic = traffic_of(seed)
    setting = started(device, registers, network)
    played = device.run(words_of(traffic), quiet_clocks=QUIET)
    decided, verdicts = golden(CONFIG, traffic, [setting])
    assert_same(played, decided, verdicts)
    print(f"seed {seed}: {len(verdicts)} verdicts of {len(set(verdicts['track_id']))} ids")
    assert len(verdicts) > 10
    counters = Registers(device).counters()
    assert counters["records"] == len(played.records) + len(played.verdicts)
    assert Registers(device).verdicts.lost == 0
    assert Registers(device).status.idle == 1


@pytest.mark.parametrize("variant", ["everything is born", "everything returns", "quick turns"])
def test_id_is_that_of_the_owner_at_the_closing_event(variant: str) -> None:
    """Slots change their tracks all the time, and slow outputs move events and records apart."""
    config = replace(CONFIG, registers=replace(QUICK, **VARIANTS[variant]))
    rng = np.random.default_rng(31)
    device = device_of("classifier", config, pace=Pace({"owned": 60, "records": 90, "passed": 60}))
    registers = replace(random_registers(rng), window_log2=8)
    setting = started(device, registers, random_network(rng, registers.classes))
    traffic = traffic_of(21)
    decided, verdicts = golden(config, traffic, [setting])
    assert_same(device.run(words_of(traffic), quiet_clocks=QUIET), decided, verdicts)
    assert len(set(zip(verdicts["slot"].tolist(), verdicts["track_id"].tolist(), strict=True))) > 6


def rewritten(network: Network, rng: np.random.Generator) -> Network:
    """A few other weights of both layers."""
    w1, w2 = network.w1.copy(), network.w2.copy()
    for array in (w1, w2):
        array.flat[rng.choice(array.size, 5, replace=False)] = rng.integers(-128, 128, 5)
    return Network(w1, w2)


@pytest.mark.parametrize("seed", range(3))
def test_registers_and_weights_change_between_two_events(seed: int) -> None:
    rng = np.random.default_rng([32, seed])
    device = device_of("classifier", CONFIG, pace=Pace.random(rng) if seed else None)
    registers = random_registers(rng)
    network = random_network(rng, registers.classes)
    traffic = traffic_of(10 + seed, 60_000)
    settings = [started(device, registers, network)]
    commands: list[Command] = []
    changes: list[tuple[int, RecognitionRegisters | None, Network]] = []  # command that reads where, and what

    def commits(values: dict[str, int], after: int, now: RecognitionRegisters | None) -> None:
        commands.extend([*classifier_writes(values, after), SETTLED, read(COMMIT)])
        changes.append((len(commands) - 1, now, network))

    for after in np.sort(rng.integers(2_000, 58_000, 9)).tolist():
        registers = replace(random_registers(rng), classes=registers.classes)
        if rng.random() < 0.5:
            commits(asdict(registers), after, registers)
            continue
        new = rewritten(network, rng)
        old_words, words = memory_words(network), memory_words(new)
        commits({"enable": 0}, after, None)
        network = new
        for address in np.flatnonzero(old_words != words).tolist():
            commands.extend([write(ADDRESS, address), write(DATA, int(words[address]))])
        commits({**asdict(registers), "enable": 1}, after, registers)
    played = device.run(words_of(traffic), [*commands, poll_status("idle", 1, len(traffic))], quiet_clocks=QUIET)
    assert device.read(FAULT) & 15 == 0
    settings += [Setting(int(played.commands["result"][at]), now, weights) for at, now, weights in changes]
    assert len({setting.seq for setting in settings}) > 8
    decided, verdicts = golden(CONFIG, traffic, settings)
    assert_same(played, decided, verdicts)
    assert len(verdicts) > 10


def test_a_commit_waits_for_the_windows_that_are_closed() -> None:
    """Right behind the event that closes a window, which takes more than 700 clocks to evaluate."""
    rng = np.random.default_rng(41)
    device = device_of("classifier", CONFIG)
    registers = replace(random_registers(rng), window_log2=8)
    network = random_network(rng, registers.classes)
    settings = [started(device, registers, network)]
    traffic = traffic_of(7)
    words, parts = words_of(traffic), []
    for _ in range(5):
        decided, verdicts = golden(CONFIG, traffic, settings)
        end = int(verdicts["seq"][verdicts["seq"] >= settings[-1].seq][0]) + 1
        registers = replace(random_registers(rng), window_log2=8, classes=registers.classes)
        writes = classifier_writes(asdict(registers))
        device.run(commands=writes[:-1])  # into the shadow
        begin = settings[-1].seq
        taken = poll(address_of("status"), 0xFFFF_0000, 0, end - begin)  # no token is held before the trackers
        parts.append(device.run(words[begin:end], [taken, writes[-1], SETTLED]))
        settings.append(Setting(device.read(COMMIT), registers, network))
        assert settings[-1].seq == end
    parts.append(device.run(words[end:], quiet_clocks=QUIET))
    decided, verdicts = golden(CONFIG, traffic, settings)
    assert np.concatenate([part.verdicts for part in parts]).tolist() == verdicts.tolist()
    assert np.array_equal(np.concatenate([part.records for part in parts]), decided.records)


def test_a_commit_of_other_banks_leaves_windows_and_votes() -> None:
    rng = np.random.default_rng(33)
    device = device_of("classifier", CONFIG)
    registers = replace(random_registers(rng), window_log2=8)
    setting = started(device, registers, random_network(rng, registers.classes))
    traffic = traffic_of(4)
    commits = [write(bank_address("motion"), 1, after) for after in range(1_000, 38_000, 1_500)]
    played = device.run(words_of(traffic), [command for commit in commits for command in (commit, SETTLED)])
    assert_same(played, *golden(CONFIG, traffic, [setting]))


def test_soft_reset_turns_the_classifier_off_and_keeps_weights_and_registers() -> None:
    rng = np.random.default_rng(34)
    device = device_of("classifier", CONFIG, pace=Pace.random(rng))
    registers = replace(random_registers(rng), window_log2=8)
    setting = started(device, registers, random_network(rng, registers.classes))
    traffic = traffic_of(5)
    decided, verdicts = golden(CONFIG, traffic, [setting])
    for at in (20_000, 20_777):
        cut = device.run(words_of(traffic), [write(CONTROL, 1 << 9 | 1, after=at)], quiet_clocks=QUIET).verdicts
        assert 0 < len(cut) < len(verdicts)
        assert np.array_equal(cut, verdicts[: len(cut)])
        device.write(CONTROL, 1 << 9)
        banks = [slot_address(slot) for slot in range(5)] + [bank_address(bank) for bank in ("motion", "tracks")]
        commits = [*(write(address, 1) for address in banks), SETTLED, write(CONTROL, 1)]
        device.run(commands=commits)
        assert len(device.run(words_of(traffic[:25_000]), quiet_clocks=QUIET).verdicts) == 0
        device.write(CONTROL, 1 << 9)
        device.run(commands=[*commits[:-2], write(COMMIT, 1), *commits[-2:]])
    played = device.run(words_of(traffic), quiet_clocks=QUIET)
    assert_same(played, decided, verdicts)


def test_without_room_a_verdict_is_lost_and_a_bit_says_so() -> None:
    """One slot, whose track sends a record in 1,023 events: so verdicts fill the queues before a record stops the tracker."""
    build = BUILDS["classifier of one slot"]
    slow = replace(
        QUICK, step_log2=12, nev_low=1023, nev_high=1023, report_steps=1023, gap_corrections=0,
        birth_support=1, birth_px=0, birth_ticks=0, birth_travel=8,
        detect_ticks=1 << 20, life_ticks=1 << 20, coast_ticks=1 << 23,
    )  # fmt: skip
    config = MotionConfig(build.shape, slow, filter_shape=build.filter_shape)
    rng = np.random.default_rng(35)
    device = device_of("classifier of one slot", config)
    registers = RecognitionRegisters(window_log2=8, shift_1=4, shift_2=4)
    setting = started(device, registers, random_network(rng, registers.classes))
    n = 60_000
    x, y = (middle + rng.integers(-6, 7, n) + np.arange(n) // 4_000 for middle in (40, 20))
    traffic = TickedEvents(np.arange(n) * 2, x.astype(np.uint16), y.astype(np.uint16), np.zeros(n, np.uint8))
    decided, verdicts = golden(config, traffic, [setting])
    assert len(verdicts) > 30
    device.pace = Pace({"records": 0})
    first = device.run(words_of(traffic)[:12_000])
    assert len(first.records) == len(first.verdicts) == 0
    assert Registers(device).verdicts.lost == 1
    device.pace = Pace()
    rest = device.run(words_of(traffic)[12_000:], quiet_clocks=QUIET)
    got = np.concatenate([first.verdicts, rest.verdicts])
    kept = np.isin(verdicts["seq"], got["seq"])
    assert np.array_equal(verdicts[kept], got)
    assert 0 < np.count_nonzero(~kept) < 5
    assert np.array_equal(rest.records, decided.records)
    Registers(device).verdicts.lost = 1
    assert Registers(device).verdicts.lost == 0


class TestBus:
    def test_each_register_clamps_what_is_illegal_and_enable_refuses(self) -> None:
        device = device_of("classifier", CONFIG)
        for name, register in CLASSIFIER_REGISTERS.items():
            address, held = bank_address("classifier", name), register.start
            assert device.read(address) == held
            for value in (register.low, register.high, register.high + 1, 0xFFFF_FFFF, register.low - 1):
                if value >= 0:
                    legal = min(max(value, register.low), register.high)
                    kind = 0 if legal == value else REFUSED if name == "enable" else CLAMPED
                    held = held if kind == REFUSED else legal
                    device.write(address, value)
                    assert (device.read(address), fault(device)[0]) == (held, kind), (name, value)

    def test_words_that_exist_are_those_of_the_map(self) -> None:
        device = device_of("classifier", CONFIG)
        device.write(CONTROL, 4)  # answer with SLVERR
        found = device.run(commands=[read(address) for address in range(0x60, 0x80, 4)] + [
            read(address) for address in range(0x380, 0x400, 4)]).commands  # fmt: skip
        known = {int(row["address"]) for row in found if not row["response"]}
        words = {word.address for word in register_map().words if 0x60 <= word.address < 0x80}
        version = Registers(device).version
        assert (version.major, version.minor) == register_map().version
        assert known == words | {bank_address("classifier", name) for name in (*CLASSIFIER_REGISTERS, "commit")}

    def test_other_registers_have_their_first_values(self) -> None:
        """The first values of the classifier pass through the words of slots: axi_lite_regs.v."""
        device = device_of("classifier", CONFIG)
        assert [device.read(slot_address(slot, "mode")) for slot in range(5)] == [0] * 5
        assert device.read(bank_address("motion", "step_log2")) == MotionRegisters().step_log2

    def test_weights_are_read_back_and_counted(self) -> None:
        device = device_of("classifier", CONFIG)
        rng = np.random.default_rng(36)
        registers = Registers(device)
        words = rng.integers(0, 1 << 18, LAST + 1)
        assert (registers.weights.loaded, registers.weights.needed) == (0, len(words))
        device.run(commands=[write(ADDRESS, 0), *(write(DATA, int(word)) for word in words[:100])])
        assert (registers.weights.loaded, registers.weight_address) == (100, 100)
        device.run(commands=[write(ADDRESS, 101), write(DATA, 5), write(ADDRESS, 3), write(DATA, 6)])
        assert registers.weights.loaded == 100, "in order alone"
        words[3] = 6
        device.run(commands=[write(ADDRESS, 100), *(write(DATA, int(word)) for word in words[100:])])
        assert registers.weights.loaded == len(words)
        reads = [command for address in range(len(words)) for command in (write(ADDRESS, address), read(DATA))]
        assert device.run(commands=reads).commands["result"][1::2].tolist() == words.tolist()
        assert fault(device)[0] == 0

    def test_words_beyond_the_last_and_values_beyond_18_bits_are_faults(self) -> None:
        device = device_of("classifier", CONFIG)
        device.write(ADDRESS, LAST + 1)
        assert (device.read(ADDRESS), *fault(device)) == (LAST, CLAMPED, ADDRESS)
        device.write(DATA, 1 << 18)
        assert fault(device) == (CLAMPED, DATA)
        device.write(DATA, 1)
        assert fault(device) == (REFUSED, DATA)
        device.write(ADDRESS, LAST)
        assert device.read(DATA) == (1 << 18) - 1

    def test_enable_is_refused_until_all_words_are_loaded(self) -> None:
        device = device_of("classifier", CONFIG)
        words = memory_words(random_network(np.random.default_rng(37)))
        device.run(
            commands=[write(ADDRESS, 0), *(write(DATA, int(word)) for word in words[:-1]), write(ENABLE, 1), write(COMMIT, 1)]
        )
        assert fault(device) == (REFUSED, COMMIT)
        assert device.read(address_of("commits")) == 0
        device.run(commands=[write(ENABLE, 0), write(COMMIT, 1), SETTLED])
        assert (fault(device)[0], device.read(address_of("commits"))) == (0, 1)
        device.run(commands=[write(DATA, int(words[-1])), write(ENABLE, 1), write(COMMIT, 1), SETTLED])
        assert (fault(device)[0], device.read(address_of("commits"))) == (0, 2)
        device.reset()
        device.run(commands=[write(ENABLE, 1), write(COMMIT, 1)])
        assert fault(device) == (REFUSED, COMMIT)

    def test_weights_are_locked_while_enabled(self) -> None:
        device = device_of("classifier", CONFIG)
        network = random_network(np.random.default_rng(38))
        started(device, RecognitionRegisters(), network)
        device.write(ADDRESS, 7)
        device.write(DATA, 0x155)
        assert fault(device) == (REFUSED, DATA)
        assert (device.read(DATA), device.read(ADDRESS)) == (0, 7)
        device.run(commands=[write(ENABLE, 0), write(COMMIT, 1), SETTLED])
        assert device.read(DATA) == memory_words(network)[7]

    def test_a_bank_is_locked_while_its_commit_waits(self) -> None:
        device = device_of("classifier", CONFIG)
        started(device, RecognitionRegisters(), random_network(np.random.default_rng(39)))
        device.run(words_of(traffic_of(1)[:40]), quiet_clocks=50, take_outputs=False)
        device.write(COMMIT, 1)
        assert Registers(device).status.pending == 1
        device.write(ENABLE, 0)
        assert fault(device) == (LOCKED, ENABLE)

    def test_hardware_without_a_classifier_has_none_of_it(self) -> None:
        device = device_of("motion")
        for address in (ADDRESS, DATA, address_of("weights"), address_of("verdicts"), ENABLE, COMMIT):
            device.write(address, 1)
            assert fault(device) == (UNMAPPED, address)
            assert (device.read(address), fault(device)) == (0, (UNMAPPED, address))
        assert Registers(device).build.classifier == 0
        with pytest.raises(ConfigError) as caught:
            _ = Registers(device).classifier
        assert str(caught.value) == (
            "the hardware has no registers classifier: it was built with CLASSIFY = 0; CLASSIFY = 1 builds the classifier"
        )


def test_a_weights_file_is_loaded_over_the_bus() -> None:
    rng = np.random.default_rng(40)
    device = device_of("classifier", CONFIG)
    device.configure()
    recognition = replace(random_registers(rng), classes=4)
    weights = Weights(random_network(rng, 4), recognition, (3, 1, 7, 0))
    registers = Registers(device)
    for _ in range(2):  # again while it is on
        load(registers, weights)
    traffic = traffic_of(6)
    assert_same(
        device.run(words_of(traffic), quiet_clocks=QUIET),
        *golden(CONFIG, traffic, [Setting(0, recognition, weights.network)]),
    )
    assert registers.classifier.enable == 1
    with pytest.raises(BusError, match="write of 0x1 at 0x0068: a value was refused"):
        registers.weight_data = 1
    values: dict[str, Any] = {name: getattr(registers.classifier, name) for name in asdict(recognition)}
    assert RecognitionRegisters(**values) == recognition
