# SPDX-License-Identifier: Apache-2.0
"""The extended contract of the array: slots with a velocity, boxes, meetings and births (docs/motion.md)."""
