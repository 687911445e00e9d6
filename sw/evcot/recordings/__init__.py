# SPDX-License-Identifier: Apache-2.0
"""Event files: reading, writing, and what is in one."""
