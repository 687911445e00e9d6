# SPDX-License-Identifier: Apache-2.0
"""Support shared by several tests: stories and random traffic, devices that only tests drive, streams with stalls."""
