# SPDX-License-Identifier: Apache-2.0
"""Trackers in software, one package each, all of them by name, and named configurations of whole runs."""
