# SPDX-License-Identifier: Apache-2.0
"""What the tests of several modules share: stories and random traffic, devices that only tests drive, streams with stalls."""
