# SPDX-License-Identifier: Apache-2.0
"""Registers and filters of the array without motion, the paper's rules, from estimates about the scene.

Every rule is a ratio of lengths, of times or of counts; docs/auto.md explains them, "The paper's rules".
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from ..filters.config import FilterConfig
from ..hardware.config import CotConfig, SlotConfig
from ..hardware.contract import SLOTS_MAX, Shape
from .auto.estimates import Estimates, Objects
from .config import RunConfig
from .presets import fit, for_sensor

__all__ = ["paper_config"]

_ONE_SIZE = 1.4  # of the largest by the smallest: objects of up to that are of one size
_REACH = 1.4  # a window's radius, of the longer half side
_RING = 0.2  # its outer part
_SMALLEST = 0.5  # inner radius, of that at the start of a life
_UPDATE_PX = 0.3  # of travel between two updates of the centre
_UPDATE_ONE_SIZE_PX = 0.06
_EVENTS = 1.5  # of an update at least, by pixels of the half side: fewer are no object of several sizes
_LIFE = 0.12  # of the time in which an object travels its half side: silence after which a track ends
_DETECTION = 0.5  # of the time in which an object sends the events of an update
_REFRACTORY_PX = 0.2  # of travel
_SPARE_SLOTS = 4
_NOISE_EVENTS = 0.3  # in a window while a track lives, from which on noise is filtered
_NEIGHBOUR_PX = 1.0  # of travel between two events of neighbouring pixels
_NEIGHBOUR_MAX_US = 10_000
_MOST_NEIGHBOURS = 3
_N_EV = (4, 500)
_RADIUS_MAX = 250
_TIMES_US = (500, 4_000_000)


def paper_config(seen: Estimates, name: str) -> RunConfig:
    """The configuration for a scene, of that name, with the automatic software tracker beside it.

    Where no object was seen, windows, counts and times are those of the preset for the sensor.
    """
    if seen.objects is None:
        base = for_sensor(seen.sensor[0])
        slot, one_polarity, n_slots = base.cot.slots[0], False, base.cot.shape.n_slots
        refractory_us, neighbour_us = 0, _NEIGHBOUR_MAX_US
    else:
        one_polarity = not _one_size(seen.objects)
        slot = _registers(seen.objects, one_polarity)
        n_slots = min(seen.alive_most + _SPARE_SLOTS, SLOTS_MAX)
        per_px_us = 1e6 / seen.objects.speed_px_s.median
        refractory_us = _us(_REFRACTORY_PX * per_px_us, 1)
        neighbour_us = min(_us(_NEIGHBOUR_PX * per_px_us, 1), _NEIGHBOUR_MAX_US)
    polarity: Literal["off"] | None = "off" if one_polarity else None
    filters = FilterConfig(polarity=polarity, hot_pixels=seen.hot_pixels, refractory_us=refractory_us)
    noise_hz = (seen.noise_hz or 0.0) * (0.5 if one_polarity else 1.0)
    support = _neighbours(noise_hz, slot, neighbour_us)
    if support:
        filters = replace(filters, activity_us=neighbour_us, activity_support=support)
    config = RunConfig(
        name=name,
        cot=CotConfig.uniform(Shape(n_slots=n_slots), slot),
        filters=filters,
        software="auto",
        software_filters=FilterConfig(),
    )
    return fit(config, *seen.sensor)


def _one_size(objects: Objects) -> bool:
    return objects.long_px.high <= _ONE_SIZE * objects.long_px.low


def _registers(objects: Objects, one_polarity: bool) -> SlotConfig:
    one_size, half_px, speed_px_s = _one_size(objects), objects.half_px.median, objects.speed_px_s.median
    radius = min(_REACH * objects.long_px.median, _RADIUS_MAX)
    ring = max(2, round(_RING * radius))
    inner = max(2, round(radius) - ring)
    if one_size:
        least, most = inner - max(1, inner // 6), inner + max(1, inner // 6)
    else:
        largest = min(_REACH * objects.long_px.high, _RADIUS_MAX)
        least, most = max(1, round(_SMALLEST * inner)), max(round(largest) - ring, inner)
    per_px = objects.pixels_per_px.median * (0.5 if one_polarity else 1.0)
    wanted = _UPDATE_ONE_SIZE_PX * per_px if one_size else max(_UPDATE_PX * per_px, _EVENTS * half_px)
    n_ev = int(min(max(wanted, _N_EV[0]), _N_EV[1]))
    life_us = _us(1e6 * _LIFE * half_px / speed_px_s)
    return SlotConfig(
        init_radix=inner,
        radix_th=ring,
        radix_step=1,
        radix_min=least,
        radix_max=most,
        hist_avg=3,
        max_ticks=life_us,
        clust_nev=n_ev,
        nev_min=n_ev,
        nev_max=n_ev,
        nev_th=life_us // 8,
        detect_ticks=_us(1e6 * _DETECTION * n_ev / (per_px * speed_px_s)),
    )


def _us(value: float, least: int = _TIMES_US[0]) -> int:
    return int(min(max(value, least), _TIMES_US[1]))


def _neighbours(noise_hz: float, slot: SlotConfig, within_us: int) -> int:
    """How many neighbours an event needs so that noise keeps no track alive; 0 if it needs none."""
    in_window = noise_hz * (2 * (slot.init_radix + slot.radix_th) + 1) ** 2 * 1e-6 * slot.max_ticks
    by_chance = 1.0 - math.exp(-8.0 * noise_hz * 1e-6 * within_us)
    for support in range(_MOST_NEIGHBOURS):
        if in_window * by_chance**support <= _NOISE_EVENTS:
            return support
    return _MOST_NEIGHBOURS
