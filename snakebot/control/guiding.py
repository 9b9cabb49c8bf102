"""Steering within a run: poses go in each tick, a decision comes out once a cycle, and everything is told.

The loop calls ``meet`` before the first set-point and ``look`` after each; neither waits for anything.
"""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Iterator

from snakebot.control.journal import Journal
from snakebot.control.plans import RunPlan
from snakebot.control.progress import Progress, SteeringSoFar
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, Motion, OffsetTrack
from snakebot.robot import Robot
from snakebot.runlog import records
from snakebot.steering import Course
from snakebot.steering.authority import Authority, authority_of
from snakebot.steering.law import Decision, SteeringLaw
from snakebot.steering.poses import PoseWindow, TimedPose
from snakebot.steering.response import Response, response_of


def check_course(course: Course, plan: RunPlan, robot: Robot) -> None:
    """What can be checked of a run that holds a course before anything is opened.

    Raises:
        BadInputError: no gait, no ground, a gait that cannot be steered, or limits that leave no room for it.
    """
    if plan.gait is None or plan.lifted:
        raise BadInputError(
            f"{course} cannot be held: it needs a gait, on the ground (no probe, replay or --lifted)"
        )
    motion = plan.from_straight()
    assert isinstance(motion, GaitMotion)
    authority_of(motion, robot)
    response_of(robot, plan.gait)


class Guide:
    """Steers one run along a course.

    Args:
        interval_s: between ticks: an offset changes from the next one on.
    """

    def __init__(
        self, course: Course, robot: Robot, interval_s: float, progress: Progress, journal: Journal
    ) -> None:
        self.course = course
        self._robot = robot
        self._interval_s = interval_s
        self._progress = progress
        self._journal = journal
        self._track = OffsetTrack()
        self._known: dict[Gait, tuple[Response, Authority]] = {}  # also of a gait that is to come
        self._resting: list[TimedPose] = []
        self._met = False
        self._due_s = 0.0
        self._saturated = False
        self._deciding = threading.Lock()
        progress.steering = self.so_far = SteeringSoFar()

    # -- before the first tick ---------------------------------------------------------------------------------------

    @property
    def has_pose(self) -> bool:
        """Whether any pose has come."""
        return bool(self._resting) or self._met

    def meet(self, motion: Motion) -> None:
        """Take the motion that will be steered, before anything moves.

        Raises:
            BadInputError: it cannot be steered.
        """
        if not isinstance(motion, GaitMotion):
            raise BadInputError("only a gait can hold a course")
        self.prepare(motion)
        response, self._authority = self._known[motion.gait]
        self._gait, self._law = motion.gait, SteeringLaw(self.course, response, motion.ramp_s)
        self._window = PoseWindow(response.period_s)
        motion.steering = self._track

    def prepare(self, motion: GaitMotion) -> None:
        """Know what an offset does to a motion's last gait before that gait runs: it takes longer than a tick.

        Raises:
            BadInputError: the gait cannot be steered.
        """
        self._known[motion.gait] = response_of(self._robot, motion.gait), authority_of(motion, self._robot)

    def begin(self) -> None:
        """The first set-point is next: what has been seen of the robot at rest counts as seen now."""
        self._met = True
        for pose in self._resting[-1:]:
            self._window.add(pose._replace(t_s=0.0))
        self._resting.clear()
        response, authority = self._law.response, self._authority
        per_offset = response.turn_per_offset_1_s
        most = math.degrees(min(-authority.low_rad, authority.high_rad))
        self._journal.event(
            "steering",
            f"steers for {self.course}: {per_offset:.3g} deg/s a degree of offset, at most {most:.3g} deg",
            data={
                **self.course.about(),
                "turn_per_offset_1_s": per_offset,
                "bias_rad_s": response.bias_rad_s,
                "speed_m_s": response.speed_m_s,
                "low_rad": authority.low_rad,
                "high_rad": authority.high_rad,
                "step_rad": authority.step_rad,
                "blend_s": authority.blend_s,
            },
        )

    # -- while it runs -----------------------------------------------------------------------------------------------

    def see(self, t_s: float, x_m: float, y_m: float, heading_rad: float) -> None:
        """A pose has come."""
        pose = TimedPose(t_s, x_m, y_m, heading_rad)
        if not self._met:
            self._resting.append(pose)
            del self._resting[:-1]
        else:
            self._window.add(pose)
            self.so_far.doubted = self._window.doubted

    @contextlib.contextmanager
    def standing_still(self) -> Iterator[None]:
        """No decision is made meanwhile: somebody checks what a change of gait would come to."""
        with self._deciding:
            yield

    def look(self, t_s: float, motion: Motion) -> None:
        """Decide, where it is time; called after each tick, in the loop's thread."""
        if not isinstance(motion, GaitMotion) or not self._deciding.acquire(blocking=False):
            return
        try:
            self._look(t_s, motion)
        finally:
            self._deciding.release()
        self.so_far.offset_rad = self._track.at(t_s)

    def _look(self, t_s: float, motion: GaitMotion) -> None:
        stale = self._window.stale(t_s)
        if stale is not self.so_far.stale:
            self._tell_stale(stale, t_s)
        at_s = t_s + self._interval_s
        if at_s < max(self._track.settled_s, motion.settled_s if motion.settled_s > 0 else 0.0):
            return  # one change after the other: their speeds would add up
        if (
            t_s > 0
            and not motion.ramp_s <= at_s <= motion.duration_s - motion.ramp_s - self._authority.blend_s
        ):
            return  # the run's own ramps: the offset stands still
        if motion.gait != self._gait:
            self._take_gait(motion, t_s)
        if stale:
            if self._track.target_rad != 0:
                self._go_to(self._authority.limited(0.0, self._track.target_rad), at_s)
                self._note(t_s, None)
            return
        if t_s < self._due_s:
            return
        mean = self._window.mean()
        if mean is None or not (mean.whole or t_s == 0):
            return
        decision = self._law.decide(mean, t_s, self._track, self._authority)
        if t_s == 0:  # the first ramp blends it in, with the wave
            self._track.change(0.0, decision.offset_rad, 0.0)
            self._due_s = max(motion.ramp_s, self._gait.period_s)
        else:
            self._go_to(decision.offset_rad, at_s)
            self._due_s = max(self._due_s, t_s - self._gait.period_s / 2) + self._gait.period_s
        self._note(t_s, decision)

    def _go_to(self, offset_rad: float, at_s: float) -> None:
        if offset_rad != self._track.target_rad:
            self._track.change(at_s, offset_rad, self._authority.blend_s)

    def _take_gait(self, motion: GaitMotion, t_s: float) -> None:
        response, self._authority = self._known[motion.gait]
        self._law.take(response)
        self._window.set_period(response.period_s)
        self._gait = motion.gait
        self._due_s = t_s + response.period_s

    # -- telling -----------------------------------------------------------------------------------------------------

    def _note(self, t_s: float, decision: Decision | None) -> None:
        so_far, last = self.so_far, self._window.last
        saturated = decision is not None and decision.saturated
        if decision is not None:
            so_far.decisions += 1
            so_far.saturated += saturated
            so_far.error_rad, so_far.cross_track_m = decision.error_rad, decision.cross_track_m
        assert last is not None
        mean = self._window.mean()
        self._journal.steering(
            records.SteeringRecord(
                t_s=t_s,
                x_m=mean.x_m if mean is not None else last.x_m,
                y_m=mean.y_m if mean is not None else last.y_m,
                heading_rad=mean.heading_rad if mean is not None else last.heading_rad,
                wanted_heading_rad=decision.wanted_heading_rad if decision is not None else None,
                heading_error_rad=decision.error_rad if decision is not None else None,
                cross_track_m=decision.cross_track_m if decision is not None else None,
                offset_rad=self._track.target_rad,
                wanted_offset_rad=decision.wanted_offset_rad if decision is not None else None,
                saturated=saturated,
                stale=so_far.stale,
            )
        )
        if saturated and not self._saturated:
            assert decision is not None
            self._journal.event(
                "steering_limit",
                f"steering is at its limit: {math.degrees(decision.wanted_offset_rad):.3g} deg of offset are wanted, "
                f"{math.degrees(decision.offset_rad):.3g} deg can be given",
                "warning",
                {"wanted_offset_rad": decision.wanted_offset_rad, "offset_rad": decision.offset_rad},
            )
        self._saturated = saturated

    def _tell_stale(self, stale: bool, t_s: float) -> None:
        self.so_far.stale = stale
        last = self._window.last
        if stale:
            self.so_far.stale_times += 1
            since = f"for {t_s - last.t_s:.1f} s" if last is not None else "yet"
            self._journal.event("pose_stale", f"no pose {since}: steering fades to straight", "warning")
        else:
            self._due_s = max(self._due_s, t_s + self._gait.period_s)
            self._journal.event("pose_back", "poses come again: steering goes on after a cycle of them")
