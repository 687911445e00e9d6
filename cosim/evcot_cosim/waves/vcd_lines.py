# SPDX-License-Identifier: Apache-2.0
"""A VCD as vcdvcd reads it: one declaration or value change per line.

IEEE 1364-2005, section 18, separates all parts of a VCD by any white space; vcdvcd reads lines. Blocks of a file that have one
change per line already, as simulators write them, are passed on as they are. In names `$` becomes `DOLLAR`, since vcdvcd
looks for keywords anywhere in a line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from .errors import VcdError

__all__ = ["DOLLAR", "vcd_lines"]

DOLLAR = "\x01"

_BLOCK = 1 << 20
_LONGEST = 1 << 22  # of a word: a vector with so many bits is none
_PLAIN = re.compile(rb"(?:(?:#[0-9]++|[01xXzZ][!-~]++|[bB][01xXzZ]++ [!-~]++)\n)*+")
_TIMESCALE = re.compile(r"(1|10|100) ?(s|ms|us|ns|ps|fs)")
_SCALARS = str.maketrans("UWuw-HhLl", "xxxxx1100")  # std_logic: weak levels count as levels, all that is no level as unknown
_EXTENDED = "is an extended VCD ($dumpports): must be a four-state VCD, as $dumpvars writes it"
_SKIPPED = ("$date", "$version", "$comment")  # up to $end
_MARKS = ("$end", "$dumpvars", "$dumpall", "$dumpon", "$dumpoff")


def vcd_lines(path: Path, *, header_only: bool = False) -> Iterator[bytes]:
    """The text of a VCD, in blocks of whole lines.

    Values of reals and strings are left out.

    Args:
        header_only: end with the declarations.

    Raises:
        VcdError: not a VCD, or an extended one.
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        blocks = iter(lambda: file.read(_BLOCK), b"")
        words = _Words(blocks)
        yield "".join(_header(path, words)).encode()
        if not header_only:
            yield from _changes(path, words.rest(), blocks)


class _Words:
    """The words of a file, read in blocks; what was read and not taken yet is `rest`."""

    def __init__(self, blocks: Iterator[bytes]) -> None:
        self._blocks, self._text, self._at = blocks, b"", 0

    def next(self) -> str | None:
        """The next word, None at the end of the file."""
        while True:
            found = _WORD.match(self._text, self._at)
            if found and found.end() < len(self._text):
                self._at = found.end()
                return found[1].decode("latin-1")
            more = next(self._blocks, None)
            if len(self._text) - self._at > _LONGEST:
                raise ValueError(f"a word has more than {_LONGEST} characters")
            if more is None:
                self._at = len(self._text)
                return found[1].decode("latin-1") if found else None
            self._text, self._at = self._text[self._at :] + more, 0

    def until_end(self) -> list[str]:
        """The words up to $end."""
        words = []
        while (word := self.next()) not in ("$end", None):
            words.append(str(word))
        return words

    def rest(self) -> bytes:
        """What was read and not taken yet."""
        return self._text[self._at :].lstrip()


_WORD = re.compile(rb"\s*(\S+)")


def _header(path: Path, words: _Words) -> Iterator[str]:
    named: list[bool] = []  # of each open scope: whether it has a name
    while (word := words.next()) != "$enddefinitions":
        if word is None or not word.startswith("$"):
            raise VcdError(f"{path}: not a VCD: must begin with declarations, up to $enddefinitions")
        parts = words.until_end()
        if word == "$timescale":
            if not (scale := _TIMESCALE.fullmatch(" ".join(parts))):
                raise VcdError(f"{path}: $timescale {' '.join(parts)}: must be 1, 10 or 100 s, ms, us, ns, ps or fs")
            yield f"$timescale {scale[1]}{scale[2]} $end\n"
        elif word == "$scope":
            named.append(len(parts) > 1)
            if named[-1]:  # Yosys writes scopes without a name
                yield f"$scope {parts[0]} {_name(parts[1:])} $end\n"
        elif word == "$upscope":
            if not named:
                raise VcdError(f"{path}: $upscope: must close a scope")
            if named.pop():
                yield "$upscope $end\n"
        elif word == "$var":
            if len(parts) < 4 or not parts[1].isdigit():
                raise VcdError(f"{path}: $var {' '.join(parts)}: must have a type, a size, a code and a name")
            if parts[0] == "port":
                raise VcdError(f"{path}: {_EXTENDED}")
            if any(mark in parts[2] for mark in ("$scope", "$upscope", "$enddefinitions")):
                raise VcdError(f"{path}: $var {' '.join(parts)}: has a keyword as its code, which cannot be read")
            yield f"$var {' '.join(parts[:3])} {_name(parts[3:])} $end\n"
        elif word == "$dumpports":
            raise VcdError(f"{path}: {_EXTENDED}")
        elif word not in _SKIPPED:
            raise VcdError(f"{path}: {word}: must be one of $timescale, $scope, $upscope, $var, {', '.join(_SKIPPED)}")
    words.until_end()
    yield "$enddefinitions $end\n"


def _name(parts: list[str]) -> str:
    return "".join(parts).replace("$", DOLLAR)


def _changes(path: Path, begin: bytes, blocks: Iterator[bytes]) -> Iterator[bytes]:
    """The value changes, a line each."""
    value: str | None = None  # of a vector whose code comes next; empty if it is left out
    skips = False  # inside a comment
    text = begin
    while text or (text := next(blocks, b"")):
        cut = _end_of_words(text)
        while not cut and (more := next(blocks, b"")):
            if len(text) > _LONGEST:
                raise ValueError(f"a word has more than {_LONGEST} characters")
            text += more
            cut = _end_of_words(text)
        whole, text = (text[:cut], text[cut:]) if cut else (text + b"\n", b"")
        if value is None and not skips and _PLAIN.fullmatch(whole):
            yield whole
        else:
            lines: list[str] = []
            for word in whole.decode("latin-1").split():
                if skips:
                    skips = word != "$end"
                elif value is not None:
                    if value:
                        lines.append(f"b{value} {word}")
                    value = None
                elif word[0] in "bB":
                    value = word[1:].translate(_SCALARS) or "x"
                elif word[0] in "rRsS":
                    value = ""
                elif word[0] == "#":
                    lines.append(f"#{_time(path, word)}")
                elif word[0] in "01xXzZUWuw-HhLl" and len(word) > 1:
                    lines.append(word[0].translate(_SCALARS) + word[1:])
                elif word in _SKIPPED:
                    skips = True
                elif word[0] in "pP" or word.startswith(("$dumpports", "$vcdclose")):
                    raise VcdError(f"{path}: {_EXTENDED}")
                elif word not in _MARKS:
                    raise VcdError(f"{path}: {word[:40]!r}: must be a time or a value change")
            yield "".join(f"{line}\n" for line in lines).encode("latin-1")
        if not text:
            text = next(blocks, b"")
    if value is not None:
        raise VcdError(f"{path}: not a whole VCD: the last value has no code")


def _end_of_words(text: bytes) -> int:
    """Where the last whole line of a text ends, or its last whole word if it is a part of one line."""
    return text.rfind(b"\n") + 1 or max(text.rfind(space) for space in b" \t\r\v\f") + 1


def _time(path: Path, word: str) -> int:
    """A time; some writers add a fraction of zero."""
    try:
        time = int(word[1:]) if word[1:].isdigit() else float(word[1:])
        if time == int(time) >= 0:
            return int(time)
    except (ValueError, OverflowError):
        pass
    raise VcdError(f"{path}: {word[:40]}: must be a whole number of time units, not negative")
