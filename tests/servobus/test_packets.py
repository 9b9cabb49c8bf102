"""Both packet formats: round trips, the vendors' bytes, and whatever a bad line makes of them."""

from __future__ import annotations

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from sdk_ports import KeptPort

from snakebot.servobus import dynamixel, feetech
from snakebot.servobus.packets import BROADCAST, Dialect, Packet, PacketError

DIALECTS = [feetech.Feetech(), dynamixel.Dynamixel()]
BY_NAME = {dialect.name: dialect for dialect in DIALECTS}
every_dialect = pytest.mark.parametrize("dialect", DIALECTS, ids=lambda dialect: dialect.name)

ids = st.integers(0, 0xFC)
# data in which headers and stuffing are likely
nasty = st.lists(
    st.sampled_from([b"\xff", b"\xff\xff\xfd", b"\xff\xff\xfd\x00", b"\xfd", b"\x00", b"\x12"]), max_size=12
).map(b"".join)
payload = st.one_of(nasty, st.binary(max_size=40))


@every_dialect
@given(st.data())
def test_answers_come_back_whole_in_any_pieces(dialect: Dialect, data: st.DataObject) -> None:
    sent = data.draw(st.lists(st.tuples(ids, st.integers(0, 0x7F), payload), max_size=5))
    stream = b"".join(dialect.answer(*each) for each in sent)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    decoder = dialect.answers(1024)
    heard = [
        packet
        for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)
        for packet in decoder.feed(stream[start:end])
    ]
    assert heard == [Packet(*each) for each in sent]
    assert decoder.corrupt == 0


@every_dialect
@given(st.data())
def test_instructions_reach_the_servos(dialect: Dialect, data: st.DataObject) -> None:
    servo, address, what = data.draw(ids), data.draw(st.integers(0, 0xFF)), data.draw(payload)
    for raw in (
        dialect.ping(servo),
        dialect.read(servo, address, 2),
        dialect.write(servo, address, what),
        dialect.sync_read([1, 2, 3], address, 4),
        dialect.sync_write(address, {1: what, 2: what}),
    ):
        (packet,) = dialect.instructions().feed(raw)
        assert packet.id in (servo, BROADCAST)


@every_dialect
@given(st.data())
def test_one_damaged_byte_is_found(dialect: Dialect, data: st.DataObject) -> None:
    """What comes out is the original, or it is no answer of that id with that many bytes."""
    servo, error, what = data.draw(ids), data.draw(st.integers(0, 0x7F)), data.draw(payload)
    raw = bytearray(dialect.answer(servo, error, what))
    at = data.draw(st.integers(0, len(raw) - 1))
    raw[at] ^= data.draw(st.integers(1, 0xFF))
    heard = dialect.answers(len(raw)).feed(bytes(raw))
    expected = [p for p in heard if p.id == servo and len(p.parameters) == len(what)]
    assert expected in ([], [Packet(servo, error, what)])


@given(servo=ids, what=payload, start=st.integers(0, 400), burst=st.integers(1, 0xFFFF))
def test_a_burst_within_sixteen_bits_is_found_by_the_crc(
    servo: int, what: bytes, start: int, burst: int
) -> None:
    raw = dynamixel.Dynamixel().answer(servo, 0, what)
    bits = 8 * len(raw)
    start %= bits
    number = int.from_bytes(raw, "big") ^ (burst << (bits - start) >> 16)
    damaged = number.to_bytes(len(raw), "big")
    assume(damaged != raw)
    assume(damaged[:7] == raw[:7])  # a damaged length is another packet: the next test
    assert dynamixel.crc16(damaged[:-2]) != int.from_bytes(damaged[-2:], "little")


@every_dialect
@given(st.data())
def test_noise_never_hides_what_comes_after_it(dialect: Dialect, data: st.DataObject) -> None:
    """After any noise and as many quiet bytes as the longest packet has, a good one is heard."""
    noise = data.draw(st.one_of(nasty, st.binary(max_size=60)))
    good = dialect.answer(7, 0, b"\x01\x02")
    decoder = dialect.answers(dialect.answer_bytes(4))
    decoder.feed(noise + bytes(decoder.longest))
    assert decoder.pending <= decoder.longest
    assert Packet(7, 0, b"\x01\x02") in decoder.feed(good)


@every_dialect
@given(noise=st.binary(max_size=60))
def test_a_new_question_forgets_old_bytes(dialect: Dialect, noise: bytes) -> None:
    decoder = dialect.answers(64)
    decoder.feed(noise)
    decoder.reset()
    assert decoder.feed(dialect.answer(7, 0, b"\x01\x02")) == [Packet(7, 0, b"\x01\x02")]


def test_a_damaged_length_does_not_swallow_the_next_answer() -> None:
    dialect = dynamixel.Dynamixel()
    broken = bytearray(dialect.answer(1, 0, b"\x01\x02\x03\x04"))
    broken[5] = 0x1E
    assert dialect.answers(64).feed(bytes(broken) + dialect.answer(2, 0, b"\x05\x06\x07\x08")) == [
        Packet(2, 0, b"\x05\x06\x07\x08")
    ]


@given(
    st.lists(st.tuples(ids, st.integers(0, 0xFF), st.binary(min_size=4, max_size=4)), min_size=1, max_size=16)
)
def test_fast_sync_read(pieces: list[tuple[int, int, bytes]]) -> None:
    raw = dynamixel.fast_answer(pieces)
    for size in (1, 7, len(raw)):
        decoder = dynamixel.DynamixelAnswers(1024)
        heard = [p for at in range(0, len(raw), size) for p in decoder.feed(raw[at : at + size])]
        assert [packet.id for packet in heard] == [BROADCAST]
        assert dynamixel.fast_pieces(heard[0].parameters, 4) == [Packet(*piece) for piece in pieces]
    assert dynamixel.fast_pieces(b"\x00" * 5, 4) is None


@given(payload)
def test_stuffing(body: bytes) -> None:
    stuffed = dynamixel.stuff(body)
    assert dynamixel.unstuff(stuffed) == body
    assert dynamixel.HEADER not in stuffed


def test_what_no_packet_can_carry() -> None:
    with pytest.raises(PacketError):
        feetech.pack(1, 3, bytes(300))
    with pytest.raises(PacketError):
        dynamixel.pack(1, 3, bytes(1100))
    for dialect in DIALECTS:
        with pytest.raises(PacketError):
            dialect.sync_write(42, {1: b"\0\0", 2: b"\0"})


@given(st.data())
def test_the_same_bytes_as_the_dynamixel_sdk(data: st.DataObject) -> None:
    import dynamixel_sdk as sdk

    port, handler, ours = KeptPort(), sdk.PacketHandler(2.0), dynamixel.Dynamixel()
    servo = data.draw(ids)
    address = data.draw(st.integers(0, 600))
    # dynamixel-sdk 4.1 works the stuffing out and then sends the packet without it: see the next test
    what = data.draw(
        st.binary(min_size=1, max_size=8).filter(lambda b: b"\xff\xfd" not in b and b[0] != 0xFD)
    )
    handler.ping(port, servo)
    assert port.written == ours.ping(servo)
    handler.readTx(port, servo, address, 4)
    assert port.written == ours.read(servo, address, 4)
    port.is_using = False
    handler.writeTxOnly(port, servo, address, len(what), list(what))
    assert port.written == ours.write(servo, address, what)
    handler.reboot(port, servo)
    assert port.written == ours.reboot(servo)
    servos = data.draw(st.lists(ids, min_size=1, max_size=16, unique=True))
    for fast, raw in (
        (False, ours.sync_read(servos, address, 4)),
        (True, ours.fast_sync_read(servos, address, 4)),
    ):
        port.is_using = False
        handler.syncReadTx(port, address, 4, servos, len(servos), fast)
        assert port.written == raw
    port.is_using = False
    group = sdk.GroupSyncWrite(port, handler, address, len(what))
    for each in servos:
        group.addParam(each, list(what))
    group.txPacket()
    assert port.written == ours.sync_write(address, dict.fromkeys(servos, what))


@given(payload)
def test_stuffing_is_the_vendors(body: bytes) -> None:
    import dynamixel_sdk as sdk

    handler = sdk.PacketHandler(2.0)
    length = len(body) + 3
    plain = [0xFF, 0xFF, 0xFD, 0, 1, length & 0xFF, length >> 8, dynamixel.WRITE, *body, 0, 0]
    stuffed = handler.addStuffing(plain)
    ours = dynamixel.pack(1, dynamixel.WRITE, body)
    assert bytes(stuffed[: len(ours) - 2]) == ours[:-2]
    assert handler.updateCRC(0, list(ours), len(ours) - 2) == dynamixel.crc16(ours[:-2])


@given(st.data())
def test_the_same_bytes_as_the_feetech_sdk(data: st.DataObject) -> None:
    import scservo_sdk as sdk

    port, handler, ours = KeptPort(), sdk.PacketHandler(0), feetech.Feetech()
    servo = data.draw(ids)
    address = data.draw(st.integers(0, 80))
    what = data.draw(st.binary(min_size=1, max_size=8))
    handler.ping(port, servo)
    assert port.written == ours.ping(servo)
    handler.readTx(port, servo, address, 4)
    assert port.written == ours.read(servo, address, 4)
    port.is_using = False
    handler.writeTxOnly(port, servo, address, len(what), list(what))
    assert port.written == ours.write(servo, address, what)
    servos = data.draw(st.lists(ids, min_size=1, max_size=16, unique=True))
    port.is_using = False
    handler.syncReadTx(port, address, 4, servos, len(servos))
    assert port.written == ours.sync_read(servos, address, 4)
    port.is_using = False
    group = sdk.GroupSyncWrite(port, handler, address, len(what))
    for each in servos:
        group.addParam(each, list(what))
    group.txPacket()
    assert port.written == ours.sync_write(address, dict.fromkeys(servos, what))
