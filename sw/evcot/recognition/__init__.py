# SPDX-License-Identifier: Apache-2.0
"""Recognition of tracked objects from their owned events (docs/recognition.md)."""
