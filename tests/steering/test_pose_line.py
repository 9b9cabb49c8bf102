"""Lines of JSON as poses: whatever comes, a pose or nothing comes out."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.steering.pose_line import Order, SaidPose, parse_pose

GOOD = st.builds(
    SaidPose, st.floats(-1e9, 1e9), st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.floats(-100, 100)
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["t", "x", "y", "heading", "a"]), inner)
    ),
    max_leaves=12,
)


def said(pose: SaidPose, **more: object) -> bytes:
    return json.dumps(
        {"t": pose.t_s, "x": pose.x_m, "y": pose.y_m, "heading": pose.heading_rad, **more}
    ).encode()


@given(GOOD)
def test_a_pose_comes_out_as_it_was_said(pose: SaidPose) -> None:
    assert parse_pose(said(pose, tag=7, confidence=0.9)) == pose


@given(st.binary(max_size=300))
def test_any_bytes_are_a_pose_or_nothing(line: bytes) -> None:
    check(parse_pose(line))


@given(JSON)
def test_any_json_is_a_pose_or_nothing(value: object) -> None:
    check(parse_pose(json.dumps(value).encode()))


@given(GOOD, st.data())
def test_damage_gives_a_pose_or_nothing(pose: SaidPose, data: st.DataObject) -> None:
    line = bytearray(said(pose))
    for _ in range(data.draw(st.integers(1, 4))):
        line[data.draw(st.integers(0, len(line) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    check(parse_pose(bytes(line[: data.draw(st.integers(0, len(line)))])))


def check(pose: SaidPose | None) -> None:
    assert pose is None or all(math.isfinite(value) for value in pose)


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"{}",
        b"[1,2,3,4]",
        b'{"t":1,"x":2,"y":3}',
        b'{"t":1,"x":2,"y":3,"heading":null}',
        b'{"t":1,"x":2,"y":3,"heading":"0"}',
        b'{"t":1,"x":2,"y":true,"heading":0}',
        b'{"t":1,"x":2,"y":NaN,"heading":0}',
        b'{"t":1,"x":1e300,"y":0,"heading":0}',
        b'{"t":1,"x":1e400,"y":0,"heading":0}',
        b'{"t":' + b"9" * 400 + b',"x":1,"y":0,"heading":0}',
        b"[" * 2000,
        b'{"t":1,"x":2,"y":3,"heading":0,"pad":"' + b"a" * 4000 + b'"}',
        b'{"t":1,"x":2,"y":3,"heading":0',
        b"\xff\xfe",
    ],
)
def test_what_is_no_pose_is_none(line: bytes) -> None:
    assert parse_pose(line) is None


def test_the_order_of_a_trackers_clock() -> None:
    order = Order()
    assert [order.newer(t) for t in (10.0, 10.1, 10.1, 10.05, 10.2)] == [True, True, False, False, True]
    assert order.newer(0.0)  # restarted
    assert order.newer(0.1)
    assert not order.newer(0.05)
    assert order.newer(0.05, after_silence=True)
    assert not order.newer(0.05, after_silence=True)  # the same word again says nothing
