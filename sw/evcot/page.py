# SPDX-License-Identifier: Apache-2.0
"""A page of HTML that a notebook shows in a frame."""

from __future__ import annotations

import html
from dataclasses import dataclass
from pathlib import Path

from .outputs import written_aside

__all__ = ["EVENTS_MAX", "HEIGHT_PX", "Page"]

EVENTS_MAX = 50_000  # of a page in a notebook, which keeps it: about 0.4 MB
HEIGHT_PX = 640  # of its frame


@dataclass(frozen=True, repr=False)
class Page:
    """A self-contained page. A notebook in a browser shows it where it is the value of a cell.

    Attributes:
        name: what it shows.
        text: the HTML.
        height_px: height of the frame.
    """

    name: str
    text: str
    height_px: int = HEIGHT_PX

    def __repr__(self) -> str:
        """What a notebook without a browser, or a terminal, shows."""
        size = f"{len(self.text) / 1e6:.1f} MB"
        return f"<Page of {self.name}, {size}: a notebook in a browser shows it; save('page.html') writes it for any browser>"

    def _repr_html_(self) -> str:
        """The frame: the page runs its scripts in it, and reaches nothing of the notebook."""
        style = f"width: 100%; height: {self.height_px}px; border: 1px solid #8888"
        source = html.escape(self.text, quote=True)
        return f'<iframe title="{html.escape(self.name)}" sandbox="allow-scripts" style="{style}" srcdoc="{source}"></iframe>'

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write the page as a file for a browser.

        Args:
            force: replace a file that exists.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        with written_aside(Path(path), force=force) as file:
            file.write(self.text.encode())
