# SPDX-License-Identifier: Apache-2.0
"""The page of modules: a section for each, from its own header comment, its parameters and ports, and the figures."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path

from ..fpga.catalogue import MODULES
from ..fpga.devices import DEVICES
from ..fpga.figures import Figure, load, recorded_with
from ..fpga.header import DeclaredPort, Header, read
from ..fpga.report import MARK, outdated
from ..rtl.files import modules, verilog_dir

__all__ = ["page"]

_SUBJECT = re.compile(r"^([A-Z][A-Za-z ]{2,24}: +|[a-z]\w*: {2,})(?=\S)")
_HEAD = """# Modules

Made from `hw/verilog` and `hw/fpga/figures.json` by `make docs`, in the order of `manifest.txt`: each after
the modules that it instantiates. The text is each file's header comment. A stream is listed as one bundle of ports: valid,
ready and its data; `clk`, `rst` and self-explanatory ports are left out. Cost as in [fpga.md](fpga.md), at N = 8 where
there is an N (an example at its own), and † marks what was measured before the module last changed; a module without such a
table is only measured as a part of others.

What all trackers have in common (addresses of registers and the rules between them, when `cfg_*` may be written, kinds of
records, order between the streams, what a blocked output stops) is on [registers.md](registers.md). A bench written from these
two pages alone, in plain Verilog: [integrator_tb.v](../hw/fpga/examples/integrator_tb.v). Test vectors for
any bench, and cocotb: [vectors.md](vectors.md).

"""


def page(verilog: Path | None = None) -> str:
    """The whole page."""
    folder = verilog or verilog_dir()
    names = modules(folder)
    recorded = folder.parent / "fpga" / "figures.json"
    figures = load(recorded).values()
    old = outdated(figures, recorded_with(recorded)) if figures else frozenset()
    contents = " ·\n".join(f"[{name}](#{name})" for name in names)
    sections = (_section(read(name, folder), figures, old) for name in names)
    return f"{_HEAD}{contents}\n\n" + "\n".join(sections)


def _section(header: Header, figures: Iterable[Figure], old: Collection[str]) -> str:
    parts = [f"## {header.top}\n", _prose(header.comment)]
    settable = [parameter for parameter in header.parameters if not parameter.derived]
    if settable:
        rows = [(f"`{one.name}`", f"`{_plain(one.default_source)}`", _escaped(one.meaning)) for one in settable]
        parts.append(_table(("parameter", "default", "meaning"), rows))
    bundles = list(_bundles(header.ports))
    if bundles:
        parts.append(_table(("ports", "", "carry", "meaning"), bundles))
    measured = {name for name, module in MODULES.items() if module.top == header.top}
    cost = [_cost(figure, old) for figure in figures if figure.module in measured and figure.n == MODULES[figure.module].shown]
    if cost:
        parts.append(_table(("on", "LUTs", "FFs", "block RAMs", "Fmax, median"), cost))
    return "\n".join(parts)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _escaped(text: str) -> str:
    """Markdown in which the text's own signs stand for themselves; what is between backticks is left alone."""
    parts = text.split("`")
    return "`".join(part if i % 2 else re.sub(r"([*<|])", r"\\\1", part) for i, part in enumerate(parts))


def _plain(source: str) -> str:
    """An expression without the mark of macros."""
    return source.replace("`", "")


def _prose(comment: Iterable[str]) -> str:
    """The header comment as Markdown: paragraphs, a bullet for each subject, drawings as they stand."""
    out: list[str] = []
    kind = "text"
    for line in comment:
        before, subject = kind, _SUBJECT.match(line) if out else None
        if subject:
            kind = "bullet"
        elif not line:
            kind = "text"
        elif before == "bullet" and (line.startswith(" ") or not out[-1].endswith(".")):
            kind = "bullet"
        else:
            kind = "drawing" if line.startswith("    ") else "text"
        if kind == "drawing":
            out += [] if before == kind else ["```text"] if not out[-1] else ["", "```text"]
            out.append(line[4:])
            continue
        out += ["```"] if before == "drawing" else []
        if subject:
            out += [""] if before == "text" and out[-1] else []
            out.append(f"- **{subject[1].rstrip(': ')}**: {_escaped(line[subject.end() :])}")
        elif kind == "bullet":
            out.append(f"  {_escaped(line.strip())}")
        else:
            out += [""] if before == "bullet" and line else []
            out.append(_escaped(line))
    return "\n".join([*out, *(["```"] if kind == "drawing" else [])]).strip() + "\n"


def _bundles(ports: Sequence[DeclaredPort]) -> Iterator[tuple[str, str, str, str]]:
    """One row for each stream, and one for each other port, or group of them, that says what it is."""
    streams = [port.name.removesuffix("valid") for port in ports if re.search(r"_t?valid$", port.name)]
    buses = {port.name.removesuffix("awvalid") for port in ports if port.name.endswith("_awvalid")}
    prefixes = sorted([*streams, *buses], key=len, reverse=True)
    single = [port for port in ports if not any(port.name.startswith(prefix) for prefix in prefixes)]
    seen = set()
    for port in ports:
        prefix = next((prefix for prefix in prefixes if port.name.startswith(prefix)), None)
        key = port.name if port.meaning else port.heading
        if prefix is not None:
            if prefix not in seen:
                yield _bundle(prefix, [other for other in ports if _belongs(other.name, prefix, prefixes)], prefix in buses)
            seen.add(prefix)
        elif key and key not in seen:
            seen.add(key)
            group = [port] if port.meaning else [other for other in single if other.heading == key and not other.meaning]
            directions = sorted({other.direction for other in group})
            names = ", ".join(f"`{other.name}{_plain(other.range_source)}`" for other in group)
            yield names, ", ".join(directions), "", _escaped(port.meaning or port.heading)


def _belongs(name: str, prefix: str, prefixes: Sequence[str]) -> bool:
    return next((longest for longest in prefixes if name.startswith(longest)), None) == prefix


def _bundle(prefix: str, ports: Sequence[DeclaredPort], bus: bool) -> tuple[str, str, str, str]:
    heading = next((port.heading for port in ports if port.heading), "")
    if bus:
        master = any(port.name == f"{prefix}awvalid" and port.direction == "out" for port in ports)
        return f"`{prefix}`", "master" if master else "slave", "AXI4-Lite, 32 bits", _escaped(heading)
    fields = [port for port in ports if port.name.removeprefix(prefix) not in ("valid", "ready")]
    shown = prefix.removesuffix("t") if prefix.endswith("_t") else prefix  # AXI4-Stream
    names = ", ".join(f"`{port.name.removeprefix(shown)}{_plain(port.range_source)}`" for port in fields)
    notes = "; ".join(f"{port.name.removeprefix(prefix)}: {port.meaning}" for port in ports if port.meaning)
    told = ". ".join(part for part in (heading, notes) if part)
    direction = next(port.direction for port in ports if port.name.endswith("valid"))
    return f"`{shown}`", direction, names, _escaped(told)


def _cost(figure: Figure, old: Collection[str]) -> tuple[str, ...]:
    device = DEVICES[figure.device].title if figure.device in DEVICES else figure.device
    size = f"N = {figure.n}, " if figure.n else ""
    size += f"{figure.module}, " if figure.module != MODULES[figure.module].top else ""
    fmax = f"{figure.median_mhz:.0f} MHz" if figure.median_mhz is not None else figure.misfit
    return f"{size}{device}{MARK * (figure.name in old)}", f"{figure.luts:,}", f"{figure.ffs:,}", f"{figure.block_rams:,}", fmax
