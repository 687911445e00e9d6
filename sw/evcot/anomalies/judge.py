# SPDX-License-Identifier: Apache-2.0
"""The rules, one function each, evaluated for a track whenever one of its steps is closed.

Rules on motion accumulate evidence: the time for which they were violated, minus the time for which they were not. An alarm
requires `hold_us` of evidence; a track that has complied with the rule before needs twice as much, so that a tracker's switch
from one object to another raises no alarm. Each alarm is raised once per track, for zones and lines once per track and zone.
"""

from __future__ import annotations

import math

from .._numba_private import step
from .alarm import Anomaly
from .stays import leave, settle
from .zones import crosses, holds, offset

__all__ = ["ALARMS_PER_STEP", "end", "judge"]

WRONG_WAY, CROSSING, FAST, SLOW, STOPPING = (
    int(kind) for kind in (Anomaly.WRONG_WAY, Anomaly.CROSSING, Anomaly.FAST, Anomaly.SLOW, Anomaly.STOPPING)
)
LOITERING, PLACE, FORBIDDEN, DWELL, LINE = (
    int(kind) for kind in (Anomaly.LOITERING, Anomaly.PLACE, Anomaly.FORBIDDEN, Anomaly.DWELL, Anomaly.LINE)
)
ALARMS_PER_STEP = FORBIDDEN  # plus one for each zone and line

_SCORE_MAX = 99.0
_RARE, _SELDOM = 0.03, 0.05  # tracks lost per cell, and as a share of its visits: at most both is rare
_MOST = 0.4  # share of a stay during which something was observed
_SWELL = 1.6  # a box that changes more than this while a velocity is measured switches between objects
_BRAKED = 0.4  # of the normal speed: an object that was faster has braked
_WHOLE = 0.6  # of its box when it became slow: a smaller one covers the remains of another track
_NEAR = 0.6  # of the radius: within this distance of its mean position a stay continues, and is reported
_AMONG = 0.5  # of the normal speed: above this, an object counts as moving


@step
def _raise(cur, out, trace, kind, zone, score, expected, seen, since_t):  # type: ignore[no-untyped-def]
    row = out[cur.alarms]
    cur.alarms += 1
    row.t_us = cur.t_us
    row.event_index = cur.event_index
    row.track_id = trace.track_id
    row.kind = kind
    row.zone = zone
    row.x = trace.x
    row.y = trace.y
    row.score = min(score, _SCORE_MAX)
    row.expected = expected
    row.seen = seen
    row.begin_us = cur.origin_us + int(since_t)
    row.birth_us = trace.birth_us


@step
def _gather(trace, kind, broken, elapsed_us, travel_px, least_us, least_px):  # type: ignore[no-untyped-def]
    """Add a step to the evidence of a rule; returns whether an alarm is due."""
    if broken:
        if not trace.open[kind]:
            trace.open[kind] = 1
            trace.since_t[kind] = trace.t - elapsed_us
            trace.travel_px[kind] = 0.0
        trace.evidence_us[kind] += elapsed_us
        trace.travel_px[kind] += travel_px
    else:
        trace.evidence_us[kind] = max(-least_us, trace.evidence_us[kind] - elapsed_us)
        if trace.evidence_us[kind] <= 0:
            trace.open[kind] = 0
    enough = trace.evidence_us[kind] >= least_us and trace.travel_px[kind] >= least_px
    if not (broken and enough) or trace.raised[kind]:
        return False
    trace.raised[kind] = 1
    return True


@step
def _cell(field, x, y):  # type: ignore[no-untyped-def]
    """Row and column of a position; row -1 outside."""
    column = int((x + 0.5) // field.cell_px)
    row = int((y + 0.5) // field.cell_px)
    if 0 <= row < field.support.shape[0] and 0 <= column < field.support.shape[1]:
        return row, column
    return -1, -1


@step
def _direction(rules, field, row, column, cur, trace, out, elapsed_us, speed):  # type: ignore[no-untyped-def]
    normal_x = field.x[row, column]
    normal_y = field.y[row, column]
    along = trace.vx * normal_x + trace.vy * normal_y
    across = abs(trace.vx * normal_y - trace.vy * normal_x)
    sure = rules.significance * trace.error
    wrong = along < -sure and along < rules.wrong_way_cos * speed
    crossing = not wrong and across > sure and along < rules.crossing_cos * speed
    expected = math.degrees(math.atan2(normal_y, normal_x))
    seen = math.degrees(math.atan2(trace.vy, trace.vx))
    turn = math.acos(max(-1.0, min(1.0, along / max(speed, 1e-9))))
    way_s = 1e-6 * elapsed_us
    if _gather(trace, WRONG_WAY, wrong, elapsed_us, -along * way_s, rules.hold_us, rules.evidence_px):
        score = turn / math.acos(rules.wrong_way_cos)
        _raise(cur, out, trace, WRONG_WAY, -1, score, expected, seen, trace.since_t[WRONG_WAY])
    if _gather(trace, CROSSING, crossing, elapsed_us, across * way_s, rules.hold_us, rules.evidence_px):
        score = turn / math.acos(rules.crossing_cos)
        _raise(cur, out, trace, CROSSING, -1, score, expected, seen, trace.since_t[CROSSING])


@step
def _is_near(rules, normal):  # type: ignore[no-untyped-def]
    """Whether motion at the normal speed is distinguishable from a tracker's jitter there."""
    return 1e-6 * rules.hold_us * normal >= rules.travel_px


@step
def _speed(rules, field, row, column, cut, cur, trace, out, elapsed_us, speed):  # type: ignore[no-untyped-def]
    normal = math.exp(field.log_speed[row, column])
    sure = rules.significance * trace.error
    far_off = rules.speed_deviations * field.deviation[row, column]
    apart = math.log(max(speed, 1e-3) / normal)
    way_px = speed * 1e-6 * elapsed_us
    if speed - sure > _AMONG * normal:
        trace.moved_us += elapsed_us
    fast = speed - sure > rules.fast_ratio * normal and apart > far_off and _is_near(rules, normal)
    if _gather(trace, FAST, fast, elapsed_us, way_px, rules.hold_us, rules.evidence_px):
        _raise(cur, out, trace, FAST, -1, speed / (rules.fast_ratio * normal), normal, speed, trace.since_t[FAST])
    slow = speed + sure < rules.slow_ratio * normal and apart < -far_off
    slow = slow and trace.farthest_px >= rules.travel_px and not cut
    if _gather(trace, SLOW, slow, elapsed_us, way_px, rules.hold_us, 0.0):
        score = rules.slow_ratio * normal / max(speed, 1e-3)
        _raise(cur, out, trace, SLOW, -1, score, normal, speed, trace.since_t[SLOW])


@step
def _stopping(rules, field, cur, trace, out, elapsed_us, speed):  # type: ignore[no-untyped-def]
    """Whether the object stands; also records later evidence of standing: that it braked, or stayed at its first position."""
    if _is_taken(rules, trace, speed):
        _taken(rules, field, cur, trace, out)
    moved = trace.moved_us >= rules.hold_us / 2
    stands = moved and speed + trace.error < rules.stop_ratio * trace.normal
    if _gather(trace, STOPPING, stands, elapsed_us, 0.0, rules.hold_us, 0.0):
        _stopped(rules, cur, trace, out, trace.x, trace.y, trace.since_t[STOPPING])
    slows = moved and speed + trace.error < rules.slow_ratio * trace.normal and not _is_cut(field, trace)
    if slows and trace.slow_us == 0:
        trace.slow_t = trace.t - elapsed_us
        trace.slow_extent = trace.extent
    trace.slow_us = trace.slow_us + elapsed_us if slows else 0.0
    whole = _WHOLE * trace.slow_extent <= trace.extent <= trace.slow_extent / _WHOLE
    if trace.slow_us >= rules.hold_us / 2 and speed < _BRAKED * trace.normal and whole and _is_near(rules, trace.normal):
        trace.braked_t = trace.t
        trace.braked_x = trace.x
        trace.braked_y = trace.y
    if _starts(rules, field, trace, speed) and not trace.raised[STOPPING]:
        trace.raised[STOPPING] = 1
        _stopped(rules, cur, trace, out, trace.x, trace.y, trace.first_t)


@step
def _starts(rules, field, trace, speed):  # type: ignore[no-untyped-def]
    """Whether a track that begins away from the edge first stays there and then drives off, still slower than others."""
    if trace.stood == 0:
        return False
    away_px = math.hypot(trace.x - trace.first_x, trace.y - trace.first_y)
    age_us = trace.t - trace.first_t
    if age_us < 2 * rules.hold_us:
        return False
    if trace.stood == 2:
        stood = away_px < _BRAKED * trace.normal * 1e-6 * age_us
        trace.stood = 1 if stood and _is_near(rules, trace.normal) else 0
    row, column = _cell(field, trace.x, trace.y)
    if trace.stood == 0 or away_px < rules.evidence_px or row < 0:
        return False
    if speed > trace.normal:  # the track was captured by a passing object
        trace.stood = 0
        return False
    along = (trace.x - trace.first_x) * field.x[row, column] + (trace.y - trace.first_y) * field.y[row, column]
    return along > rules.crossing_cos * away_px


@step
def _is_taken(rules, trace, speed):  # type: ignore[no-untyped-def]
    """Whether a track that has just braked moves back: it has switched to a following object."""
    if trace.braked_t < 0 or trace.t - trace.braked_t > rules.hold_us or speed - trace.error < rules.slow_ratio * trace.normal:
        return False
    way_x = trace.braked_x - trace.first_x
    way_y = trace.braked_y - trace.first_y
    return trace.vx * way_x + trace.vy * way_y < 0


@step
def _is_cut(field, trace):  # type: ignore[no-untyped-def]
    """Whether a track's box extends over the picture's edge: the centre of a clipped object moves incorrectly."""
    reach = trace.extent + field.cell_px
    before, _ = _cell(field, trace.x - reach, trace.y - reach)
    after, _ = _cell(field, trace.x + reach, trace.y + reach)
    return before < 0 or after < 0


@step
def _is_end(field, x, y):  # type: ignore[no-untyped-def]
    """Whether tracks are often lost at a position: near the picture's edge, and wherever the tracker loses them."""
    row, column = _cell(field, x, y)
    return row < 0 or field.ends[row, column] > _RARE + _SELDOM * field.support[row, column]


@step
def _vanished(rules, field, cur, trace, out):  # type: ignore[no-untyped-def]
    """A track is lost, or has switched to another object: standing objects cause no events, so if it braked it has stopped."""
    braked = trace.braked_t >= 0 and trace.t - trace.braked_t <= rules.stitch_us
    if braked and not _is_end(field, trace.braked_x, trace.braked_y) and not trace.raised[STOPPING]:
        trace.raised[STOPPING] = 1
        _stopped(rules, cur, trace, out, trace.braked_x, trace.braked_y, trace.slow_t)


@step
def _taken(rules, field, cur, trace, out):  # type: ignore[no-untyped-def]
    """Reset the evidence after the track has switched to another object."""
    _vanished(rules, field, cur, trace, out)
    trace.moved_us = 0.0
    trace.slow_us = 0.0
    trace.braked_t = -1.0
    trace.stood = 0
    trace.evidence_us[:] = 0.0
    trace.open[:] = 0
    trace.first_x = trace.x
    trace.first_y = trace.y


@step
def _stopped(rules, cur, trace, out, x, y, since_t):  # type: ignore[no-untyped-def]
    speed = math.hypot(trace.vx, trace.vy)
    _raise(cur, out, trace, STOPPING, -1, rules.stop_ratio * trace.normal / max(speed, 1e-3), trace.normal, speed, since_t)
    out[cur.alarms - 1].x = x
    out[cur.alarms - 1].y = y


@step
def end(rules, field, stays, cur, trace, out, lost):  # type: ignore[no-untyped-def]
    """Process the end of a track, lost or merged. A track lost at the edge has left."""
    leave(stays, trace, trace.raised[LOITERING], rules.hold_us)
    if lost and not _is_cut(field, trace):
        _vanished(rules, field, cur, trace, out)


@step
def _loitering(rules, stays, cur, trace, out, elapsed_us):  # type: ignore[no-untyped-def]
    if math.hypot(trace.x - trace.anchor_x, trace.y - trace.anchor_y) > rules.loiter_radius_px:
        leave(stays, trace, trace.raised[LOITERING], rules.hold_us)
        gap_us = rules.loiter_gap_us if trace.jumped else -1.0  # continuous motion ends the stay
        trace.raised[LOITERING] = settle(stays, trace, _NEAR * rules.loiter_radius_px, gap_us)
        trace.evidence_us[LOITERING] = 0.0
    limit_us = rules.loiter_us
    if trace.normal > 0:  # only where the normal speed is known
        limit_us = max(limit_us, 1e6 * rules.loiter_factor * rules.loiter_radius_px / trace.normal)
        if not trace.known or math.hypot(trace.vx, trace.vy) >= rules.slow_ratio * trace.normal:
            return
    trace.lingered_t = trace.t
    trace.lingered_us += elapsed_us
    share = elapsed_us / max(trace.lingered_us, 1.0)
    trace.anchor_x += share * (trace.x - trace.anchor_x)
    trace.anchor_y += share * (trace.y - trace.anchor_y)
    trace.evidence_us[LOITERING] += elapsed_us
    stay_us = trace.t - trace.anchor_t
    lingers = trace.evidence_us[LOITERING] >= rules.hold_us and trace.lingered_us >= _MOST * stay_us
    near = math.hypot(trace.x - trace.anchor_x, trace.y - trace.anchor_y) <= _NEAR * rules.loiter_radius_px
    if lingers and near and stay_us >= limit_us and not trace.raised[LOITERING]:
        trace.raised[LOITERING] = 1
        _raise(cur, out, trace, LOITERING, -1, stay_us / limit_us, 1e-6 * limit_us, 1e-6 * stay_us, trace.anchor_t)


@step
def _zones(rules, places, i, cur, trace, out):  # type: ignore[no-untyped-def]
    for zone in range(len(places.dwell_us)):
        if holds(places.corners, places.starts[zone], places.starts[zone + 1], trace.x, trace.y):
            places.left[i, zone] = -1.0
            if places.since[i, zone] < 0:
                places.since[i, zone] = trace.t
        elif places.since[i, zone] >= 0:
            if places.left[i, zone] < 0:
                places.left[i, zone] = trace.t
            if trace.t - places.left[i, zone] >= rules.hold_us:
                places.since[i, zone] = -1.0
            continue
        else:
            continue
        stay_us = trace.t - places.since[i, zone]
        limit_us = places.dwell_us[zone]
        if stay_us >= max(limit_us, rules.hold_us) and not places.raised[i, zone]:
            places.raised[i, zone] = True
            kind = DWELL if limit_us > 0 else FORBIDDEN
            score = stay_us / limit_us if limit_us > 0 else 1.0
            _raise(cur, out, trace, kind, zone, score, 1e-6 * limit_us, 1e-6 * stay_us, places.since[i, zone])


@step
def _lines(rules, places, i, cur, trace, out):  # type: ignore[no-untyped-def]
    for line in range(len(places.lines)):
        ax, ay, bx, by = places.lines[line]
        away = offset(ax, ay, bx, by, trace.x, trace.y)
        if abs(away) < rules.line_margin_px * math.hypot(bx - ax, by - ay):
            continue
        side = 1 if away > 0 else -1
        if places.side[i, line] == -side:
            way = crosses(places.lines[line], places.x[i, line], places.y[i, line], trace.x, trace.y)
            if way != 0:
                places.counts[line, 0 if way > 0 else 1] += 1
                if places.allowed[line] == -way and not places.line_raised[i, line]:
                    places.line_raised[i, line] = True
                    _raise(cur, out, trace, LINE, line, 1.0, places.allowed[line], way, trace.t)
        places.side[i, line] = side
        places.x[i, line] = trace.x
        places.y[i, line] = trace.y


@step
def judge(rules, field, places, stays, i, cur, trace, out):  # type: ignore[no-untyped-def]
    """Apply all rules to the step that was just closed for track i."""
    if not trace.settled:
        trace.settled = True
        trace.first_x = trace.x
        trace.first_y = trace.y
        trace.first_t = trace.t
        trace.stood = 0 if _is_cut(field, trace) else 2
        trace.raised[LOITERING] = settle(stays, trace, _NEAR * rules.loiter_radius_px, rules.loiter_gap_us)
    if trace.jumped:
        _taken(rules, field, cur, trace, out)
    trace.farthest_px = max(trace.farthest_px, math.hypot(trace.x - trace.first_x, trace.y - trace.first_y))
    elapsed_us = min(trace.elapsed_us, rules.longest_us)
    row, column = _cell(field, trace.x, trace.y)
    trace.normal = field.near_speed[row, column] if row >= 0 else math.nan
    _zones(rules, places, i, cur, trace, out)
    _lines(rules, places, i, cur, trace, out)
    _loitering(rules, stays, cur, trace, out, elapsed_us)
    support = field.support[row, column] if row >= 0 else 0.0
    strange = support < rules.place_support and trace.farthest_px >= rules.travel_px
    if _gather(trace, PLACE, strange, elapsed_us, 0.0, rules.hold_us, 0.0):
        score = rules.place_support / max(support, rules.place_support / _SCORE_MAX)
        _raise(cur, out, trace, PLACE, -1, score, rules.place_support, support, trace.since_t[PLACE])
    if not trace.known:
        return
    speed = math.hypot(trace.vx, trace.vy)
    row, column = _cell(field, trace.mid_x, trace.mid_y)
    if row < 0:
        return
    if field.support[row, column] >= rules.min_support and trace.swell <= _SWELL:
        cut = _is_cut(field, trace)
        if field.concentration[row, column] >= rules.min_concentration and not cut:
            _direction(rules, field, row, column, cur, trace, out, elapsed_us, speed)
        _speed(rules, field, row, column, cut, cur, trace, out, elapsed_us, speed)
    if trace.normal > 0:
        _stopping(rules, field, cur, trace, out, elapsed_us, speed)
