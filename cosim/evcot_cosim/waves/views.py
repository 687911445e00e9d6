# SPDX-License-Identifier: Apache-2.0
"""Contents of the waveform view of each hardware module: groups of signals, each with a label, a format and a colour."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, IntEnum

from evcot.hardware.contract import REGISTERS, Mode, State
from evcot.tracks.log import Kind

__all__ = ["VIEWS", "WITH_MOTION", "Codes", "Colour", "Form", "Group", "Row"]


class Form(Enum):
    """Display format of a number. A single bit is always shown as a level."""

    DECIMAL = "decimal"
    PIXELS = "decimal, with the fractional bits of a centre"
    PLOT = "curve"
    PLOT_PIXELS = "curve, with the fractional bits of a centre"
    SIGNED = "signed decimal"
    SIGNED_PIXELS = "signed decimal, with the fractional bits of a side"
    SIGNED_PLOT = "curve, signed"


class Colour(Enum):
    """The colour of a row, by the role of its signal."""

    PLAIN = "green"
    TIME = "indigo"
    CONTROL = "orange"
    PLACE = "violet"
    EVENT = "yellow"


@dataclass(frozen=True)
class Codes:
    """Names of the values of a signal.

    Attributes:
        name: name of the translation file.
        values: (name, code) pairs; a code of None stands for the value of the module's constant of that name.
    """

    name: str
    values: tuple[tuple[str, int | None], ...]

    @classmethod
    def of(cls, enum: type[IntEnum]) -> Codes:
        """The members of an enum of the contract."""
        return cls(enum.__name__.lower(), tuple((member.name, int(member)) for member in enum))


@dataclass(frozen=True)
class Row:
    """One signal.

    Attributes:
        signal: its name within the module, or a path below it; `{slot}` stands for the slot, `{place}` for the place of
            its average in memory.
        label: the name that is shown; by default the last part of `signal`.
        form, colour: format and colour of the row.
        codes: names for its values.
        packed: whether the vector holds an equal part for every slot, of which this slot's is shown.
        field: selects a field of a packed signal: the module's constants for the width of the field and the widths of the
            fields below it.
    """

    signal: str
    label: str = ""
    form: Form = Form.DECIMAL
    colour: Colour = Colour.PLAIN
    codes: Codes | None = None
    packed: bool = False
    field: tuple[str, ...] = ()


@dataclass(frozen=True)
class Group:
    """Rows under a title. A `{slot}` in the title repeats the group for every slot that has one of its signals."""

    title: str
    rows: tuple[Row, ...]
    closed: bool = False


_STATE, _KIND, _MODE = (Codes.of(enum) for enum in (State, Kind, Mode))
_PHASE = Codes("phase", tuple((name, None) for name in ("RUN", "WALK", "FETCH", "REPORT", "CLEAR", "SETTLE", "JOIN")))


def _rows(names: str, colour: Colour = Colour.PLAIN, form: Form = Form.DECIMAL) -> tuple[Row, ...]:
    return tuple(Row(name, colour=colour, form=form) for name in names.split())


_INPUT = Group(
    "events in",
    (
        *_rows("clk rst"),
        *_rows("s_valid s_ready", Colour.CONTROL),
        *_rows("s_tick", Colour.TIME),
        *_rows("s_event s_skip s_x s_y s_p", Colour.EVENT),
    ),
)


def _records(*places: Row) -> Group:
    return Group(
        "records out",
        (
            *_rows("m_cm_valid m_cm_ready", Colour.CONTROL),
            Row("m_cm_kind", codes=_KIND, colour=Colour.CONTROL),
            *_rows("m_cm_slot m_cm_id m_cm_other"),
            *places,
            *_rows("m_cm_n_ev m_cm_support"),
            *_rows("m_cm_seq m_cm_time", Colour.TIME),
        ),
    )


_RECORDS = _records(*_rows("m_cm_x m_cm_y", Colour.PLACE, Form.PIXELS), *_rows("m_cm_radius", Colour.PLACE))
_BOXES = _records(
    *_rows("m_cm_x m_cm_y", Colour.PLACE, Form.SIGNED_PIXELS),
    *_rows("m_cm_width m_cm_height", Colour.PLACE, Form.PIXELS),
    *_rows("m_cm_v_x m_cm_v_y", Colour.PLACE, Form.SIGNED_PIXELS),
)
_OWNED = Group(
    "owned events out",
    (
        *_rows("m_own_valid m_own_ready", Colour.CONTROL),
        *_rows("m_own_slot"),
        *_rows("m_own_x m_own_y m_own_p", Colour.EVENT),
        *_rows("m_own_seq", Colour.TIME),
    ),
)
_PASSED = Group(
    "passed events out",
    (
        *_rows("m_pass_valid m_pass_ready", Colour.CONTROL),
        *_rows("m_pass_tick", Colour.TIME),
        *_rows("m_pass_event m_pass_x m_pass_y m_pass_p", Colour.EVENT),
        *_rows("m_pass_seq", Colour.TIME),
    ),
)
_REGISTERS = " ".join(name for name in REGISTERS if name != "mode")


def _below(scope: str, group: Group) -> Group:
    """The same group for a module below a scope."""
    return replace(group, rows=tuple(replace(row, signal=scope + row.signal) for row in group.rows))


_TRACKER = Group(
    "tracker",
    (
        Row("state", codes=_STATE, colour=Colour.CONTROL),
        *_rows("active ring s_valid s_ready", Colour.CONTROL),
        *_rows("cm_x cm_y", Colour.PLACE, Form.PLOT_PIXELS),
        Row("radius", form=Form.PLOT, colour=Colour.PLACE),
        *(Row(f"u_{axis}.hi_reg", f"hi_{axis}", colour=Colour.PLACE) for axis in "xy"),
        *_rows("av_x av_y", Colour.PLACE, Form.PIXELS),
        *_rows("tc tc2 last_tc2", Colour.TIME),
        *_rows("n_ev count support id"),
        *_rows("token_x token_y", Colour.EVENT),
        Row("mode", codes=_MODE),
    ),
)
_CHAIN_SLOT = replace(_below("tracker[{slot}].u_cot.", _TRACKER), title="tracker {slot}")
_FILTERED = Group(
    "behind the filters",
    (
        *_rows("valid ready", Colour.CONTROL),
        *_rows("tick", Colour.TIME),
        *_rows("is_event skip x y p", Colour.EVENT),
    ),
)
_ARRAY_DECISION = Group(
    "decision",
    (
        Row("phase", codes=_PHASE, colour=Colour.CONTROL),
        *_rows("commit", Colour.CONTROL),
        *_rows("u_time", Colour.TIME),
        *_rows("u_x u_y u_p", Colour.EVENT),
        *_rows("u_takes u_passes", Colour.CONTROL),
        *_rows("u_update.u_slot"),
        *_rows("u_update.u_last u_special u_ends restarts found", Colour.CONTROL),
        *_rows("moved found_slot stays goes"),
        *_rows("now seq", Colour.TIME),
        *_rows("u_update.births"),
    ),
)
_ARRAY_PIPELINE = Group(
    "pipeline",
    (
        *_rows("token_valid issue m_valid m_check e_valid d_valid c_valid u_valid rewind", Colour.CONTROL),
        *_rows("m_hi_x m_hi_y", Colour.EVENT),
        *_rows("d_slot u_update.c_slot v_slot w_slot"),
        *_rows("w_checks stalled closed", Colour.CONTROL),
    ),
)
_CM = "POS_X", "POS_Y", "RADIX_W"  # what lies in u_update.cm, from the top
_ARRAY_SLOT = Group(
    "slot {slot}",
    (
        Row("active", packed=True, colour=Colour.CONTROL),
        *(Row(f"u_match.{name}", packed=True, colour=Colour.CONTROL) for name in ("candidate", "free")),
        *(Row("u_update.cm[{slot}]", f"cm_{at}", Form.PLOT_PIXELS, Colour.PLACE, field=_CM[i:]) for i, at in enumerate("xy")),
        Row("u_update.cm[{slot}]", "g", Form.PLOT, Colour.PLACE, field=_CM[2:]),
        *(Row(f"u_match.{name}[{{slot}}]", name, colour=Colour.PLACE) for name in ("lo_x_not", "hi_x", "lo_y_not", "hi_y")),
        *(Row(f"u_update.{name}[{{place}}]", name, Form.PIXELS, Colour.PLACE) for name in ("av_x", "av_y")),
        *(Row(f"u_update.{name}[{{slot}}]", name, colour=Colour.TIME) for name in ("timed", "deadline", "start", "last_tc2")),
        *(Row(f"u_update.{name}[{{slot}}]", name) for name in ("ring", "n_ev")),
        Row("u_update.rest[{slot}]", "rest", field=("NEV_W",)),
        *(Row(f"u_update.{name}[{{slot}}]", name) for name in ("support", "id")),
        Row("u_update.u_regs.mode_mem[{slot}]", "mode", codes=_MODE),
    ),
)
_ARRAY = (_ARRAY_DECISION, _ARRAY_SLOT, _ARRAY_PIPELINE)
_OUTPUTS = (_RECORDS, _OWNED, _PASSED)

_TURN = Codes("turn", tuple((name, None) for name in ("RUN", "BEGUN", "BUSY", "DUE")))
_MOTION_DECISION = Group(
    "decision",
    (
        *_rows("u_events.d_valid u_events.d_event u_events.d_owned u_events.j_valid u_events.j_kind", Colour.CONTROL),
        *_rows("u_events.d_slot u_events.j_owned"),
        *_rows("u_events.d_x u_events.d_y u_events.d_p", Colour.EVENT),
        *_rows("u_events.d_seq u_events.d_time", Colour.TIME),
    ),
)
_MOTION_WORK = Group(
    "steps and corrections",
    (
        Row("u_turn.state", codes=_TURN, colour=Colour.CONTROL),
        *_rows("u_turn.takes_token u_turn.op_step u_turn.op_effect", Colour.CONTROL),
        *_rows("u_turn.now u_turn.next_step", Colour.TIME),
        *_rows("u_work.u_order.at_work u_work.u_order.correcting u_work.u_order.merging", Colour.CONTROL),
        *_rows("u_work.u_order.at"),
    ),
)
_BOX, _WINDOW = ("box_lo_x", "box_hi_x", "box_lo_y", "box_hi_y"), ("win_lo_x", "win_hi_x", "win_lo_y", "win_hi_y")
_MOTION_SLOT = Group(
    "slot {slot}",
    (
        *(
            Row(f"u_work.u_order.u_lives.{name}", packed=True, colour=Colour.CONTROL)
            for name in ("visible", "candidate", "left")
        ),
        *(Row(f"u_events.u_match.{name}[{{slot}}]", name, Form.SIGNED_PLOT, Colour.PLACE) for name in _BOX),
        *(Row(f"u_events.u_match.{name}[{{slot}}]", name, Form.SIGNED, Colour.PLACE) for name in _WINDOW),
        *(
            Row(f"u_events.u_{axis}.{side}[{{slot}}]", f"{side[:2]}_{axis}", Form.SIGNED_PIXELS, Colour.PLACE)
            for axis in "xy"
            for side in ("los", "his")
        ),
        *(Row(f"u_events.{name}[{{slot}}]", name) for name in ("owneds", "lefts")),
        Row("u_turn.seeded", packed=True),
    ),
)
_MOTION = (_MOTION_DECISION, _MOTION_SLOT, _MOTION_WORK)
_MOTION_OUTPUTS = (_BOXES, _OWNED, _PASSED)

WITH_MOTION = "{}, cot_motion"
"""The key of a module's view if its tracker is cot_motion."""

# Module -> what to show of it, from top to bottom. Signals that a waveform lacks are left out.
VIEWS: dict[str, tuple[Group, ...]] = {
    "cot": (_INPUT, _TRACKER, *_OUTPUTS, Group("registers", _rows(_REGISTERS), closed=True)),
    "cot_chain": (_INPUT, _CHAIN_SLOT, *_OUTPUTS),
    "cot_array": (_INPUT, *_ARRAY, *_OUTPUTS, _below("u_update.", Group("registers", _rows(_REGISTERS), closed=True))),
    "cot_filtered": (
        _INPUT,
        _FILTERED,
        *(_below("u_trackers.g_array.u_tracker.", group) for group in _ARRAY),
        _below("u_trackers.g_chain.u_tracker.", _CHAIN_SLOT),
        *_OUTPUTS,
    ),
    "cot_motion": (_INPUT, *_MOTION, *_MOTION_OUTPUTS),
    WITH_MOTION.format("cot_filtered"): (
        _INPUT,
        _FILTERED,
        *(_below("u_trackers.g_motion.u_tracker.", group) for group in _MOTION),
        *_MOTION_OUTPUTS,
    ),
}
