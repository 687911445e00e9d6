# SPDX-License-Identifier: Apache-2.0
"""Files of boxes in the field's formats: MOTChallenge text, COCO JSON, Prophesee's `_bbox.npy`, MCAP for Foxglove."""

__all__ = ["FORMAT_NAMES"]

FORMAT_NAMES = ("mot", "mot-gt", "mot-det", "coco", "prophesee", "mcap")  # of `registry.FORMATS`
