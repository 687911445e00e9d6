# SPDX-License-Identifier: Apache-2.0
"""The header of Prophesee files: ASCII lines `% key value`, up to `% end` or to the first line that does not start with `%`.

https://docs.prophesee.ai/stable/data/file_formats/raw.html and dat.html
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from ...errors import RecordingError
from .printable import printable
from .source import Sensor

__all__ = ["HEADER_BYTES", "T0_LIMIT_US", "Header", "parse_header"]

# Maximum size of a header in bytes.
HEADER_BYTES = 1 << 16
# Upper limit of a header's `t0`: times after it still fit into 63 bits.
T0_LIMIT_US = 1 << 62

_DETAILS = {
    "camera": ("plugin_name", "integrator_name", "camera_integrator_name"),
    "serial": ("serial_number",),
    "date": ("date",),
}


@dataclass(frozen=True)
class Header:
    """The header lines, keys in lower case, and the byte offset of the data after them."""

    fields: Mapping[str, str]
    length: int

    @cached_property
    def _format(self) -> tuple[str, dict[str, str]]:
        """`EVT3;height=720;width=1280` as ("evt3", {"height": "720", "width": "1280"})."""
        name, *options = self.fields.get("format", "").lower().replace(" ", "").split(";")
        return name, dict(option.split("=", 1) for option in options if "=" in option)

    @property
    def evt_version(self) -> str | None:
        """`2`, `2.1` or `3`, as stated by `evt` and `format`; None in the header of a DAT file.

        Raises:
            RecordingError: they contradict each other.
        """
        named = {self.fields.get("evt", ""), self._format[0].removeprefix("evt")} - {""}
        versions = {{"21": "2.1"}.get(version, version.removesuffix(".0")) for version in named}
        if len(versions) > 1:
            raise RecordingError(f"header: EVT version {' and '.join(sorted(versions))}: evt and format must say the same")
        return next(iter(versions), None)

    @property
    def endianness(self) -> str | None:
        """Byte order of EVT 2.1 words: `little`, `legacy`, or None if not stated."""
        stated = self._format[1].get("endianness", "") or self.fields.get("endianness", "").lower()
        if stated not in ("", "little", "legacy"):
            raise RecordingError(f"header: endianness = {stated}: must be little or legacy")
        return stated or None

    @property
    def sensor(self) -> Sensor | None:
        """(width, height) from `geometry`, `format`, or `Width` and `Height`, the largest of them; None if not stated."""
        return max(self._sensors, key=lambda sides: sides[0] * sides[1], default=None)

    @property
    def remarks(self) -> list[str]:
        """Where the header contradicts itself, and what is made of it."""
        if len(set(self._sensors)) < 2:
            return []
        sizes = " and ".join(f"{width}x{height}" for width, height in self._sensors)
        return [f"header: sensor {sizes}: the larger is taken"]

    @cached_property
    def _sensors(self) -> list[Sensor]:
        """The sensor's size, wherever it is stated."""
        options = self._format[1]
        return [
            (int(width), int(height))
            for width, height in (
                self.fields.get("geometry", "").partition("x")[::2],
                (options.get("width", ""), options.get("height", "")),
                (self.fields.get("width", ""), self.fields.get("height", "")),
            )
            if _is_number(width) and _is_number(height)
        ]

    @property
    def t0_us(self) -> int:
        """Offset to add to every time, in microseconds."""
        t0 = self.fields.get("t0", "0")
        if not _is_number(t0) or int(t0) >= T0_LIMIT_US:
            raise RecordingError(f"header: t0 = {t0[:40]}: must be a whole number of microseconds below 2^62")
        return int(t0)

    @property
    def details(self) -> dict[str, str]:
        """Other entries, for display."""
        found = {name: next((self.fields[key] for key in keys if self.fields.get(key)), "") for name, keys in _DETAILS.items()}
        return {name: value for name, value in found.items() if value}


def _is_number(text: str) -> bool:
    return text.isdecimal() and len(text) < 20


def parse_header(content: bytes) -> Header:
    """Parse the header at the start of `content`, the first `HEADER_BYTES` of a file.

    Raises:
        RecordingError: the header does not end within `content`.
    """
    fields: dict[str, str] = {}
    at = 0
    while content.startswith(b"%", at) and content[at + 1 : at + 2] in (b" ", b""):
        end = content.find(b"\n", at)
        if end < 0:
            raise RecordingError(f"ends within its header, at byte {len(content)}: a header line must end in a newline")
        key, _, value = printable(content[at + 1 : end].decode("latin-1")).partition(" ")
        at = end + 1
        if key.lower() == "end":
            break
        fields[key.lower()] = value.strip()
    return Header(fields, at)
