# SPDX-License-Identifier: Apache-2.0
"""Checks a waveform against the user's properties in a Python file."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from evcot.errors import ConfigError

from . import Samples, Wave, WaveformError, handshake_stable

__all__ = ["PropertyVerdict", "judge", "load_properties"]

PREFIX = "property_"  # a function whose name begins so is a property
Property = Callable[[Samples], Any]


class PropertyVerdict(NamedTuple):
    """Result of a property: whether it holds, the number of cases if it returns that, else the message."""

    name: str
    holds: bool
    cases: int
    message: str


def load_properties(path: Path | None) -> dict[str, Property]:
    """The properties in a file, by name, in its order; without a file, the handshake rule for every stream of the hardware.

    Raises:
        ConfigError: the file cannot be read or run, or holds no property; the message gives the line.
    """
    if path is None:
        return {"streams_hold_their_offers": _streams_hold}
    names: dict[str, Any] = {"__name__": path.stem, "__file__": str(path)}
    try:
        exec(compile(path.read_bytes(), str(path), "exec"), names)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (Exception, SystemExit) as error:
        raise ConfigError(_one_line(path, error)) from error
    found = _properties(names)
    if not found:
        raise ConfigError(f"{path}: holds no property: must have functions whose names begin with {PREFIX}")
    for name, function in found.items():
        if len(inspect.signature(function).parameters) != 1:
            raise ConfigError(f"{path}: {PREFIX}{name}: must take one argument, the signals")
    return found


def _properties(names: Mapping[str, Any]) -> dict[str, Property]:
    return {name.removeprefix(PREFIX): f for name, f in names.items() if name.startswith(PREFIX) and inspect.isfunction(f)}


def judge(properties: Mapping[str, Property], vcd: Path, clock: str) -> list[PropertyVerdict]:
    """Check every property on a waveform sampled on a clock. A failed `assert` counts as a failed property.

    Raises:
        VcdError: the waveform cannot be read, or has no such clock.
        ConfigError: a property is ill-formed, or fails for another reason; the message gives the line.
    """
    samples = Wave.open(vcd).sampled(clock)
    verdicts = []
    for name, function in properties.items():
        try:
            cases = function(samples)
            verdicts.append(PropertyVerdict(name, True, cases if isinstance(cases, int) else 0, ""))
        except WaveformError as error:
            verdicts.append(PropertyVerdict(name, False, 0, str(error)))
        except AssertionError as error:
            verdicts.append(PropertyVerdict(name, False, 0, str(error) or _one_line(None, error)))
        except Exception as error:
            raise ConfigError(_one_line(Path(function.__code__.co_filename), error)) from error
    return verdicts


def _one_line(path: Path | None, error: BaseException) -> str:
    """An exception in one line, with the line of the file that it comes from."""
    if isinstance(error, SyntaxError):
        return f"{path}: line {error.lineno}: {error.msg}"
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if path is None or frame.filename == str(path)]
    place = f"line {own[-1].lineno}: " if own else ""
    said = " ".join(str(error).split()) or type(error).__name__
    return f"{path}: {place}{said}" if path else f"{place}{said}"


def _streams_hold(s: Samples) -> int:
    """Streams keep their payload valid and unchanged until accepted, and offer nothing in reset."""
    ports = {path for path in s.find("TOP.*") if path.count(".") == 1}
    prefixes = [path.removesuffix("_valid") for path in sorted(ports) if path.endswith("_valid")]
    streams = [s.stream(prefix) for prefix in prefixes if f"{prefix}_ready" in ports]
    return sum(handshake_stable(*stream, allow_vacuous=True) for stream in streams)
