# SPDX-License-Identifier: Apache-2.0
"""Hardware and golden model in lock-step, and whole runs: hardware, model and software tracker on one recording."""
