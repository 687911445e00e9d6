# SPDX-License-Identifier: Apache-2.0
"""Anomaly detection on trajectories: zones and lines, a learned field of normal motion, and online alarms."""

from .alarm import ALARM, Anomaly
from .config import AnomalyConfig
from .field import FieldConfig, NormalMotion
from .learn import learn
from .monitor import Monitor, Verdict, anomalies
from .zones import Zones, load_zones

__all__ = [
    "ALARM",
    "Anomaly",
    "AnomalyConfig",
    "FieldConfig",
    "Monitor",
    "NormalMotion",
    "Verdict",
    "Zones",
    "anomalies",
    "learn",
    "load_zones",
]
