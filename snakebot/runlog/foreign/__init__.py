"""Recordings of other programs as runs: tables of any form, LeRobot datasets, ROS 2 bags. See docs/your-recordings.md.

``source.read_source`` takes whatever it is given; ``tables``, ``lerobot`` and ``ros_runs`` know one kind each.
"""
