# SPDX-License-Identifier: Apache-2.0
"""ros2 launch evcot_ros track.launch.py events:=/event_camera/events engine:=cot_motion"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    defaults = {"events": "/event_camera/events", "tracks": "/event_camera/tracks", "markers": "/event_camera/markers",
                "engine": "cot_motion", "preset": ""}  # fmt: skip
    chosen = {name: LaunchConfiguration(name) for name in defaults}
    node = Node(
        package="evcot_ros",
        executable="track",
        name="evcot",
        output="screen",
        parameters=[{"engine": chosen["engine"], "preset": chosen["preset"]}],
        remappings=[("events", chosen["events"]), ("tracks", chosen["tracks"]), ("markers", chosen["markers"])],
    )
    return LaunchDescription([*(DeclareLaunchArgument(name, default_value=value) for name, value in defaults.items()), node])
