"""Poses over a real socket: damage, silence, restarts and floods are counted, and nothing waits."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Iterator

import pytest

from snakebot.errors import BadInputError
from snakebot.steering.pose_line import SaidPose
from snakebot.steering.pose_udp import UdpAddress, UdpPoses, parse_pose_source


class Tracker:
    """Sends to an address, and waits until everything has been read."""

    def __init__(self, poses: UdpPoses, address: UdpAddress) -> None:
        self.poses, self.address = poses, address
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send(self, data: bytes, lines: int = 1) -> None:
        poses = self.poses
        before = poses.good + poses.bad + poses.old
        self.socket.sendto(data, (self.address.host, self.address.port))
        until = time.monotonic() + 20
        while poses.good + poses.bad + poses.old < before + lines:
            assert time.monotonic() < until
            time.sleep(0.001)

    def say(self, t: float, x: float = 0.0) -> None:
        self.send(json.dumps({"t": t, "x": x, "y": 0.5, "heading": 0.1}).encode())


@pytest.fixture
def address() -> UdpAddress:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return UdpAddress("127.0.0.1", free.getsockname()[1])


@pytest.fixture
def now() -> list[float]:
    return [100.0]


@pytest.fixture
def tracker(address: UdpAddress, now: list[float]) -> Iterator[Tracker]:
    poses = UdpPoses(address, lambda: now[0])
    made = Tracker(poses, address)
    yield made
    made.socket.close()
    poses.close()


def test_what_is_sent_is_taken_once_with_the_time_it_came(tracker: Tracker, now: list[float]) -> None:
    assert tracker.poses.take() == []
    tracker.say(1.0, 0.25)
    now[0] = 100.1
    tracker.say(1.1)
    assert tracker.poses.take() == [
        (100.0, SaidPose(1.0, 0.25, 0.5, 0.1)),
        (100.1, SaidPose(1.1, 0.0, 0.5, 0.1)),
    ]
    assert tracker.poses.take() == []


def test_several_lines_of_a_datagram_are_several_poses(tracker: Tracker) -> None:
    line = '{"t":%d,"x":0,"y":0,"heading":0}\n'
    tracker.send((line % 1 + "\n" + line % 2 + "rubbish\n" + line % 3).encode(), lines=4)
    assert [pose.t_s for _, pose in tracker.poses.take()] == [1, 2, 3]
    assert (tracker.poses.good, tracker.poses.bad) == (3, 1)


def test_damage_is_counted_and_the_next_pose_counts(tracker: Tracker) -> None:
    for data in (b"\x00\xff", b"{", b"[]", b"x" * 5000, b'{"t":1,"x":1,"y":1}'):
        tracker.send(data)
    tracker.say(1.0)
    assert (tracker.poses.good, tracker.poses.bad) == (1, 5)
    assert len(tracker.poses.take()) == 1


def test_an_older_pose_is_left_out_and_a_restarted_tracker_is_not(tracker: Tracker, now: list[float]) -> None:
    for t in (50.0, 50.1, 50.05, 50.1):
        tracker.say(t)
    assert (tracker.poses.good, tracker.poses.old) == (2, 2)
    tracker.say(0.0)
    assert tracker.poses.good == 3
    now[0] += 1.0  # a silence
    tracker.say(-0.5)
    assert tracker.poses.good == 4


def test_between_two_looks_the_newest_are_kept(tracker: Tracker) -> None:
    for number in range(100):
        tracker.say(number)
    taken = tracker.poses.take()
    assert len(taken) == 64
    assert taken[-1][1].t_s == 99


def test_a_port_that_is_taken_is_refused_in_one_line(tracker: Tracker) -> None:
    with pytest.raises(BadInputError, match=r"--pose udp://127.0.0.1:\d+: cannot listen there"):
        UdpPoses(tracker.address, time.monotonic)
    with pytest.raises(BadInputError, match="cannot listen there"):
        UdpPoses(UdpAddress("203.0.113.7", tracker.address.port), time.monotonic)


def test_after_the_end_the_port_is_free(address: UdpAddress) -> None:
    for _ in range(2):
        UdpPoses(address, time.monotonic).close()


@pytest.mark.parametrize(
    ("text", "address", "open_to_others"),
    [
        ("udp://127.0.0.1:9000", ("127.0.0.1", 9000), False),
        ("udp://:9000", ("127.0.0.1", 9000), False),
        ("udp://localhost:9000", ("127.0.0.1", 9000), False),
        ("udp://0.0.0.0:9000", ("0.0.0.0", 9000), True),
        ("udp://[::1]:9000", ("::1", 9000), False),
    ],
)
def test_only_an_address_opens_it_to_others(
    text: str, address: tuple[str, int], open_to_others: bool
) -> None:
    parsed = parse_pose_source(text)
    assert tuple(parsed) == address
    assert parsed.open_to_others is open_to_others


@pytest.mark.parametrize(
    "text",
    ["", "9000", "udp://", "udp://9000", "tcp://127.0.0.1:9000", "udp://h:9", "udp://:0", "udp://:99999"],
)
def test_another_text_is_refused(text: str) -> None:
    with pytest.raises(BadInputError, match="--pose"):
        parse_pose_source(text)
