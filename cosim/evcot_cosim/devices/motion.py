# SPDX-License-Identifier: Apache-2.0
"""What the golden model can do and the RTL cannot yet: the extended contract of docs/motion.md."""

from __future__ import annotations

from evcot.errors import ConfigError
from evcot.hardware.config import CotConfig

__all__ = ["refuse_motion"]


def refuse_motion(config: CotConfig) -> None:
    """Raise ConfigError for a configuration with rules that the RTL does not have: to be called before anything is built."""
    if config.motion.enable:
        raise ConfigError(
            f"motion.enable = {config.motion.enable}: must be 0 in hardware: the RTL does not have these rules yet, only the "
            "golden model has (evcot track --engine cot)"
        )
