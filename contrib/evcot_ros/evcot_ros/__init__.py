# SPDX-License-Identifier: Apache-2.0
"""A ROS 2 node that tracks objects in the events of an event camera."""
