# SPDX-License-Identifier: Apache-2.0
"""The registers of `evcot_top.v` by name, over any transport.

    regs = Registers(transport)
    regs.slot[3].radix_max = 12      # checked, then written into the shadow
    regs.slot[3].commit()            # in effect at one point between two events: regs.slot[3].commit_seq

Generated from sw/evcot/hardware/registers.toml and contract.py by `python -m evcot.hardware.generate`: edit there.
"""

from __future__ import annotations

from ..errors import ConfigError
from ..filters.contract import FilterShape
from .contract import Shape
from .registers import BankGroup, BankRegister, Bits, Group, Transport

__all__ = ["Registers"]

# fmt: off


class _Version(Group):
    """Version of this map."""

    __slots__ = ()
    minor = Bits("version", "minor")
    major = Bits("version", "major")


class _Shape0(Group):
    """Shape of the trackers."""

    __slots__ = ()
    n_slots = Bits("shape0", "n_slots")
    frac = Bits("shape0", "frac")
    x_w = Bits("shape0", "x_w")
    y_w = Bits("shape0", "y_w")


class _Shape1(Group):
    """Shape of the trackers."""

    __slots__ = ()
    tick_w = Bits("shape1", "tick_w")
    radix_w = Bits("shape1", "radix_w")
    nev_w = Bits("shape1", "nev_w")
    tc_w = Bits("shape1", "tc_w")


class _Shape2(Group):
    """Shape of the trackers."""

    __slots__ = ()
    sup_w = Bits("shape2", "sup_w")
    id_w = Bits("shape2", "id_w")
    seq_w = Bits("shape2", "seq_w")
    time_w = Bits("shape2", "time_w")


class _Build(Group):
    """Build options of the hardware."""

    __slots__ = ()
    filters = Bits("build", "filters")
    sources = Bits("build", "sources")
    ticks = Bits("build", "ticks")
    tracker = Bits("build", "tracker")
    classifier = Bits("build", "classifier")
    cell_px = Bits("build", "cell_px")


class _Sensor(Group):
    """Size of the sensor."""

    __slots__ = ()
    last_x = Bits("sensor", "last_x")
    last_y = Bits("sensor", "last_y")


class _Memory(Group):
    """Memories."""

    __slots__ = ()
    stamp_w = Bits("memory", "stamp_w")
    recent_last = Bits("memory", "recent_last")
    fifo_depth = Bits("memory", "fifo_depth")


class _Control(Group):
    """Control."""

    __slots__ = ()
    enable = Bits("control", "enable")
    drop = Bits("control", "drop")
    slverr = Bits("control", "slverr")
    latch = Bits("control", "latch")
    soft_reset = Bits("control", "soft_reset")


class _Source(Group):
    """Source of events; takes effect with `soft_reset`."""

    __slots__ = ()
    select = Bits("source", "select")
    clock_time = Bits("source", "clock_time")
    swap_bytes = Bits("source", "swap_bytes")
    swap_halves = Bits("source", "swap_halves")
    active_low = Bits("source", "active_low")
    word_serial = Bits("source", "word_serial")


class _Prescale(Group):
    """Length of a tick and of a microsecond in clocks; takes effect with `soft_reset`."""

    __slots__ = ()
    tick = Bits("prescale", "tick")
    us = Bits("prescale", "us")


class _LfsrX(Group):
    """Self-test source: columns."""

    __slots__ = ()
    min = Bits("lfsr_x", "min")
    span = Bits("lfsr_x", "span")


class _LfsrY(Group):
    """Self-test source: rows."""

    __slots__ = ()
    min = Bits("lfsr_y", "min")
    span = Bits("lfsr_y", "span")


class _Status(Group):
    """State of the hardware."""

    __slots__ = ()
    idle = Bits("status", "idle")
    pending = Bits("status", "pending")
    open = Bits("status", "open")
    cleared = Bits("status", "cleared")
    held = Bits("status", "held")


class _Fault(Group):
    """Accesses that were clamped or refused."""

    __slots__ = ()
    clamped = Bits("fault", "clamped")
    refused = Bits("fault", "refused")
    pending = Bits("fault", "pending")
    unmapped = Bits("fault", "unmapped")
    address = Bits("fault", "address")


class _IrqStatus(Group):
    """Interrupt events since they were last cleared."""

    __slots__ = ()
    birth = Bits("irq_status", "birth")
    loss = Bits("irq_status", "loss")
    merge = Bits("irq_status", "merge")
    overflow = Bits("irq_status", "overflow")
    commit = Bits("irq_status", "commit")


class _Packet(Group):
    """Packets of `m_axis_records`: where tlast is 1."""

    __slots__ = ()
    records = Bits("packet", "records")
    wait = Bits("packet", "wait")


class _Weights(Group):
    """Words of the classifier's weights."""

    __slots__ = ()
    loaded = Bits("weights", "loaded")
    needed = Bits("weights", "needed")


class _Verdicts(Group):
    """Verdicts of the classifier."""

    __slots__ = ()
    lost = Bits("verdicts", "lost")


class _Slot(BankGroup):
    """The registers of one tracker slot, whose life goes on at a commit unless `mode` was written."""

    __slots__ = ()
    mode = BankRegister("slot", "mode")
    init_cm_x = BankRegister("slot", "init_cm_x")
    init_cm_y = BankRegister("slot", "init_cm_y")
    init_radix = BankRegister("slot", "init_radix")
    radix_th = BankRegister("slot", "radix_th")
    radix_step = BankRegister("slot", "radix_step")
    radix_min = BankRegister("slot", "radix_min")
    radix_max = BankRegister("slot", "radix_max")
    hist_avg = BankRegister("slot", "hist_avg")
    max_ticks = BankRegister("slot", "max_ticks")
    clust_nev = BankRegister("slot", "clust_nev")
    nev_min = BankRegister("slot", "nev_min")
    nev_max = BankRegister("slot", "nev_max")
    nev_th = BankRegister("slot", "nev_th")
    detect_ticks = BankRegister("slot", "detect_ticks")


class _Filters(BankGroup):
    """The registers of the filters. `mask` marks a pixel at once, after `status.cleared`: write `contract.mask_word`."""

    __slots__ = ()
    enable = BankRegister("filter", "enable")
    region_x0 = BankRegister("filter", "region_x0")
    region_x1 = BankRegister("filter", "region_x1")
    region_y0 = BankRegister("filter", "region_y0")
    region_y1 = BankRegister("filter", "region_y1")
    polarity = BankRegister("filter", "polarity")
    refractory_ticks = BankRegister("filter", "refractory_ticks")
    activity_ticks = BankRegister("filter", "activity_ticks")
    activity_support = BankRegister("filter", "activity_support")
    recent_ticks = BankRegister("filter", "recent_ticks")
    recent_radius = BankRegister("filter", "recent_radius")
    recent_support = BankRegister("filter", "recent_support")
    decay_rate = BankRegister("filter", "decay_rate")
    decay_epsilon = BankRegister("filter", "decay_epsilon")
    decay_support = BankRegister("filter", "decay_support")
    mask = BankRegister("filter", "mask")
    rowcol_ticks = BankRegister("filter", "rowcol_ticks")
    rowcol_radius = BankRegister("filter", "rowcol_radius")
    rowcol_support = BankRegister("filter", "rowcol_support")
    stamp_shift = BankRegister("filter", "stamp_shift")
    noise_log2 = BankRegister("filter", "noise_log2")
    noise_2 = BankRegister("filter", "noise_2")
    noise_3 = BankRegister("filter", "noise_3")
    noise_4 = BankRegister("filter", "noise_4")
    noise_5 = BankRegister("filter", "noise_5")
    noise_6 = BankRegister("filter", "noise_6")


class _Motion(BankGroup):
    """The registers of boxes and velocities, of cot_motion."""

    __slots__ = ()
    step_log2 = BankRegister("motion", "step_log2")
    side_step = BankRegister("motion", "side_step")
    side_share = BankRegister("motion", "side_share")
    side_shrink = BankRegister("motion", "side_shrink")
    side_max = BankRegister("motion", "side_max")
    gain_log2 = BankRegister("motion", "gain_log2")
    gain_slow = BankRegister("motion", "gain_slow")
    gain_fast = BankRegister("motion", "gain_fast")
    settle = BankRegister("motion", "settle")
    speed_max = BankRegister("motion", "speed_max")
    friction = BankRegister("motion", "friction")
    coast_slow = BankRegister("motion", "coast_slow")
    nev_low = BankRegister("motion", "nev_low")
    nev_high = BankRegister("motion", "nev_high")
    seed_px = BankRegister("motion", "seed_px")
    ring_px = BankRegister("motion", "ring_px")
    ring_max = BankRegister("motion", "ring_max")
    ring_across = BankRegister("motion", "ring_across")
    ring_along = BankRegister("motion", "ring_along")
    ring_any = BankRegister("motion", "ring_any")
    elongation = BankRegister("motion", "elongation")


class _Tracks(BankGroup):
    """The registers of lives, of cot_motion."""

    __slots__ = ()
    detect_ticks = BankRegister("tracks", "detect_ticks")
    life_log2 = BankRegister("tracks", "life_log2")
    life_ticks = BankRegister("tracks", "life_ticks")
    coast_ticks = BankRegister("tracks", "coast_ticks")
    return_ticks = BankRegister("tracks", "return_ticks")
    birth_support = BankRegister("tracks", "birth_support")
    birth_px = BankRegister("tracks", "birth_px")
    birth_ticks = BankRegister("tracks", "birth_ticks")
    birth_travel = BankRegister("tracks", "birth_travel")
    gap_corrections = BankRegister("tracks", "gap_corrections")
    gap_share = BankRegister("tracks", "gap_share")
    gap_px = BankRegister("tracks", "gap_px")
    join_steps = BankRegister("tracks", "join_steps")
    join_life = BankRegister("tracks", "join_life")
    join_speed = BankRegister("tracks", "join_speed")
    join_reach = BankRegister("tracks", "join_reach")
    join_px = BankRegister("tracks", "join_px")
    keep_older = BankRegister("tracks", "keep_older")
    report_steps = BankRegister("tracks", "report_steps")


class _Classifier(BankGroup):
    """The registers of the classifier."""

    __slots__ = ()
    enable = BankRegister("classifier", "enable")
    window_log2 = BankRegister("classifier", "window_log2")
    scale_start = BankRegister("classifier", "scale_start")
    shift_1 = BankRegister("classifier", "shift_1")
    shift_2 = BankRegister("classifier", "shift_2")
    classes = BankRegister("classifier", "classes")
    margin_min = BankRegister("classifier", "margin_min")


class Registers(Group):
    """All registers. `shape`, `filter_shape` and the number of slots are read from the hardware.

    Raises:
        ConfigError: what answers is no evcot_top, or has a map of another major version.
    """

    __slots__ = (
        "_classifier",
        "_motion",
        "_tracks",
        "build",
        "control",
        "fault",
        "filters",
        "irq_status",
        "lfsr_x",
        "lfsr_y",
        "memory",
        "packet",
        "prescale",
        "sensor",
        "shape0",
        "shape1",
        "shape2",
        "slot",
        "source",
        "status",
        "verdicts",
        "version",
        "weights",
    )
    id = Bits("id")
    tick_us = Bits("tick_us")
    lfsr_seed = Bits("lfsr_seed")
    lfsr_gap = Bits("lfsr_gap")
    irq_enable = Bits("irq_enable")
    irq_clear = Bits("irq_clear")
    commit_seq_low = Bits("commit_seq_low")
    commit_seq_high = Bits("commit_seq_high")
    commits = Bits("commits")
    weight_address = Bits("weight_address")
    weight_data = Bits("weight_data")
    events_in = Bits("events_in")
    events_dropped = Bits("events_dropped")
    malformed = Bits("malformed")
    events = Bits("events")
    filtered = Bits("filtered")
    owned = Bits("owned")
    passed = Bits("passed")
    records = Bits("records")
    stalls = Bits("stalls")
    backward = Bits("backward")

    def __init__(self, transport: Transport) -> None:
        super().__init__(transport, 0, Shape(), FilterShape())
        if self.id != 0x45564354:
            raise ConfigError(f"the hardware says that it is {self.id:#010x}: must be 0x45564354, an evcot_top")
        version = _Version(transport, 0, self.shape, self.filter_shape)
        if version.major != 3:
            raise ConfigError(
                f"the hardware has version {version.major}.{version.minor} of the registers: must be 3.x"
            )
        sensor = _Sensor(transport, 0, self.shape, self.filter_shape)
        memory = _Memory(transport, 0, self.shape, self.filter_shape)
        cell_px = _Build(transport, 0, self.shape, self.filter_shape).cell_px
        self.shape = self._shape()
        self.filter_shape = FilterShape(sensor.last_x + 1, sensor.last_y + 1, memory.stamp_w, memory.recent_last + 1, cell_px)
        shapes = self.shape, self.filter_shape
        self.version = _Version(transport, 0, *shapes)
        self.shape0 = _Shape0(transport, 0, *shapes)
        self.shape1 = _Shape1(transport, 0, *shapes)
        self.shape2 = _Shape2(transport, 0, *shapes)
        self.build = _Build(transport, 0, *shapes)
        self.sensor = _Sensor(transport, 0, *shapes)
        self.memory = _Memory(transport, 0, *shapes)
        self.control = _Control(transport, 0, *shapes)
        self.source = _Source(transport, 0, *shapes)
        self.prescale = _Prescale(transport, 0, *shapes)
        self.lfsr_x = _LfsrX(transport, 0, *shapes)
        self.lfsr_y = _LfsrY(transport, 0, *shapes)
        self.status = _Status(transport, 0, *shapes)
        self.fault = _Fault(transport, 0, *shapes)
        self.irq_status = _IrqStatus(transport, 0, *shapes)
        self.packet = _Packet(transport, 0, *shapes)
        self.weights = _Weights(transport, 0, *shapes)
        self.verdicts = _Verdicts(transport, 0, *shapes)
        self.slot = tuple(
            _Slot(transport, 0x2000 + 128 * i, *shapes) for i in range(self.shape.n_slots)
        )
        self.filters = _Filters(transport, 0x0200, *shapes)
        self._motion = _Motion(transport, 0x0280, *shapes)
        self._tracks = _Tracks(transport, 0x0300, *shapes)
        self._classifier = _Classifier(transport, 0x0380, *shapes)

    def _shape(self) -> Shape:
        words = self._transport, 0, self.shape, self.filter_shape
        values: dict[str, int] = {}
        shape0 = _Shape0(*words)
        values["n_slots"] = shape0.n_slots
        values["frac"] = shape0.frac
        values["x_w"] = shape0.x_w
        values["y_w"] = shape0.y_w
        shape1 = _Shape1(*words)
        values["tick_w"] = shape1.tick_w
        values["radix_w"] = shape1.radix_w
        values["nev_w"] = shape1.nev_w
        values["tc_w"] = shape1.tc_w
        shape2 = _Shape2(*words)
        values["sup_w"] = shape2.sup_w
        values["id_w"] = shape2.id_w
        values["seq_w"] = shape2.seq_w
        values["time_w"] = shape2.time_w
        return Shape(**values)

    @property
    def motion(self) -> _Motion:
        """The registers of boxes and velocities, of cot_motion.

        Raises:
            ConfigError: the hardware has none.
        """
        self._must_have("motion", "TRACKER", self.build.tracker, 2, "cot_motion")
        return self._motion

    @property
    def tracks(self) -> _Tracks:
        """The registers of lives, of cot_motion.

        Raises:
            ConfigError: the hardware has none.
        """
        self._must_have("tracks", "TRACKER", self.build.tracker, 2, "cot_motion")
        return self._tracks

    @property
    def classifier(self) -> _Classifier:
        """The registers of the classifier.

        Raises:
            ConfigError: the hardware has none.
        """
        self._must_have("classifier", "CLASSIFY", int(self.build.classifier > 0), 1, "the classifier")
        return self._classifier

    def _must_have(self, bank: str, parameter: str, built: int, needed: int, what: str) -> None:
        if built != needed:
            raise ConfigError(
                f"the hardware has no registers {bank}: it was built with {parameter} = {built}; "
                f"{parameter} = {needed} builds {what}"
            )

    @property
    def commit_seq(self) -> int:
        """Number of the first event processed after the last commit."""
        return self.commit_seq_high << 32 | self.commit_seq_low

    def counters(self) -> dict[str, int]:
        """All counters as they stood at one clock, by name; each wraps at 2^32."""
        self.control.latch = 1
        return {name: self._read(address) for name, address in _COUNTERS.items()}


_COUNTERS = {
    "events_in": 0x080,
    "events_dropped": 0x084,
    "malformed": 0x088,
    "events": 0x08C,
    "filtered": 0x090,
    "owned": 0x094,
    "passed": 0x098,
    "records": 0x09C,
    "stalls": 0x0A0,
    "backward": 0x0A4,
}
