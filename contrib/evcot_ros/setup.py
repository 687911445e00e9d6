# SPDX-License-Identifier: Apache-2.0
from setuptools import setup

setup(
    name="evcot_ros",
    version="0.2.0",
    description="Tracks objects in the events of an event camera: event_camera_msgs in, vision_msgs out",
    license="Apache-2.0",
    packages=["evcot_ros"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/evcot_ros"]),
        ("share/evcot_ros", ["package.xml"]),
        ("share/evcot_ros/launch", ["launch/track.launch.py"]),
    ],
    install_requires=["setuptools", "evcot"],
    zip_safe=True,
    entry_points={"console_scripts": ["track = evcot_ros.node:main"]},
)
