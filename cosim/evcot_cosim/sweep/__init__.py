# SPDX-License-Identifier: Apache-2.0
"""Sweeps: many runs over recordings, engines, settings and seeds, on all cores or a cluster, with a store that resumes.

Data flows one way: `spec` (what was asked for) → `plan` (tasks) → `run` (a scheduler: `pool` or `cluster`, each calling
`execute`) → `store` (one row a run) → `results` (best runs, front, responses) → `page`.
"""
