# SPDX-License-Identifier: Apache-2.0
"""Software trackers, one package each; the registry of engines; and named configurations of whole runs."""
