"""What a calibrated robot is good for: how well its numbers are known, and what follows from that.

* ``spread``: each number that is known within an interval, and draws of robots that may be meant by them.
* ``forecast``: speed, tracking error and power of a gait nobody has run, with bands.
* ``mujoco_model``, ``mujoco_servos``, ``mujoco_callbacks``: the robot as MJCF, with the callbacks that go beside it.
* ``ranges``: ranges for domain randomisation.
"""
