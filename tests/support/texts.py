# SPDX-License-Identifier: Apache-2.0
"""Texts of a page in a browser that are too small, or too faint for what is behind them."""

from __future__ import annotations

from typing import Any

__all__ = ["hard_to_read", "texts_of"]

_SIZE_PX, _CONTRAST = 12, 4.5  # least

_TEXTS = """() => {
  const probe = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgba = (colour) => {
    probe.clearRect(0, 0, 1, 1);
    probe.fillStyle = colour;
    probe.fillRect(0, 0, 1, 1);
    return [...probe.getImageData(0, 0, 1, 1).data];
  };
  const linear = (value) => (value <= 10 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const behind = (one) => {
    for (let at = one; at; at = at.parentElement) {
      const colour = rgba(getComputedStyle(at).backgroundColor);
      if (colour[3] === 255) return colour;
    }
    return [255, 255, 255];
  };
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const found = [];
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const one = node.parentElement;
    if (!node.textContent.trim() || !one.checkVisibility() || one.matches("script, style") || one.closest(".hidden")) continue;
    const style = getComputedStyle(one);
    const [a, b] = [light(rgba(style.color)), light(behind(one))];
    found.push([node.textContent.trim(), parseFloat(style.fontSize), (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05)]);
  }
  return found;
}"""


def texts_of(page: Any) -> list[tuple[str, float, float]]:
    """All texts that one can see: text, size in pixels, contrast against what is behind it."""
    return [(text, size, contrast) for text, size, contrast in page.evaluate(_TEXTS)]


def hard_to_read(page: Any) -> list[tuple[str, float, float]]:
    """Those below 12 px or a contrast of 4.5:1."""
    return [found for found in texts_of(page) if found[1] < _SIZE_PX or found[2] < _CONTRAST]
