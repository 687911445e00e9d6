# SPDX-License-Identifier: Apache-2.0
"""The filters in front of a tracker, from the options."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import replace

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import Pixels, learn_hot_pixels, load_hot_pixels, save_hot_pixels

from ..filter_options import NUMBERS

__all__ = ["check_learning", "filters_from", "save_learned", "with_options"]


def filters_from(
    options: argparse.Namespace, base: FilterConfig, blocks: Iterable[Events], sensor: tuple[int, int]
) -> FilterConfig:
    """A configuration with what the options say on top.

    Args:
        blocks: the recording, from which hot pixels are learned where the options ask for it.

    Raises:
        ConfigError: as `check_learning`, a value outside its range, or a list of hot pixels that cannot be used.
    """
    check_learning(options)
    learned: Pixels = learn_hot_pixels(blocks, sensor) if options.learn_hot_pixels else ()
    options.learned = learned, sensor
    return with_options(options, base, sensor)


def with_options(options: argparse.Namespace, base: FilterConfig, sensor: tuple[int, int]) -> FilterConfig:
    """As `filters_from`, after it: the hot pixels that it found are used again."""
    listed = load_hot_pixels(options.hot_pixels, sensor) if options.hot_pixels else ()
    config = _on_top(base, options)
    return replace(config, hot_pixels=config.hot_pixels + listed + options.learned[0])


def check_learning(options: argparse.Namespace) -> None:
    """Raise ConfigError where hot pixels are to be saved that nobody finds."""
    if options.save_hot_pixels is not None and not options.learn_hot_pixels:
        raise ConfigError("--save-hot-pixels: must be given with --learn-hot-pixels")


def save_learned(options: argparse.Namespace) -> None:
    """Write the hot pixels that `filters_from` found, where the options ask for it.

    Raises:
        OutputError: the file cannot be written.
    """
    if options.save_hot_pixels is not None:
        learned, sensor = options.learned
        save_hot_pixels(options.save_hot_pixels, learned, sensor, force=options.force)


def _on_top(config: FilterConfig, options: argparse.Namespace) -> FilterConfig:
    """The configuration with what the options say."""
    given = {name: getattr(options, name) for name in ("region", "polarity", *(field for field, *_ in NUMBERS.values()))}
    return config.changed({name: value for name, value in given.items() if value is not None})
