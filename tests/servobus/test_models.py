"""The register tables against those that come in packages of others."""

from __future__ import annotations

import importlib
import importlib.resources
import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.errors import BadInputError
from snakebot.servobus import dynamixel
from snakebot.servobus.models import MODELS, model_by_number, model_named
from snakebot.servobus.registers import ServoModel

# our name -> the vendor's, in dynamixel_easy_sdk/control_table/*.model
X_NAMES = {
    "model_number": "Model Number", "firmware": "Firmware Version", "id": "ID", "baud_rate": "Baud Rate",
    "return_delay": "Return Delay Time", "drive_mode": "Drive Mode", "operating_mode": "Operating Mode",
    "homing_offset": "Homing Offset", "temperature_limit": "Temperature Limit", "max_voltage": "Max Voltage Limit",
    "min_voltage": "Min Voltage Limit", "pwm_limit": "PWM Limit", "velocity_limit": "Velocity Limit",
    "max_position": "Max Position Limit", "min_position": "Min Position Limit", "shutdown": "Shutdown",
    "torque_enable": "Torque Enable", "status_return_level": "Status Return Level",
    "hardware_error": "Hardware Error Status", "position_d_gain": "Position D Gain",
    "position_i_gain": "Position I Gain", "position_p_gain": "Position P Gain", "bus_watchdog": "Bus Watchdog",
    "goal_pwm": "Goal PWM", "profile_acceleration": "Profile Acceleration", "profile_velocity": "Profile Velocity",
    "goal_position": "Goal Position", "moving": "Moving", "present_velocity": "Present Velocity",
    "present_position": "Present Position", "present_voltage": "Present Input Voltage",
    "present_temperature": "Present Temperature", "present_load": "Present Load",
    "present_current": "Present Current", "goal_current": "Goal Current", "current_limit": "Current Limit",
}  # fmt: skip
X_FILES = {
    "xl330": ["xl330_m077", "xl330_m288", "xl330_m288_fw52"],
    "xl430": ["xl430_w250"],
    "2xc430": ["2xc430_w250"],
    "xm430": ["xm430_w210", "xm430_w350"],
}
# our name -> rustypot's
FEETECH_NAMES = {
    "model_number": "model_number", "id": "id", "baud_rate": "baud_rate", "return_delay": "return_delay_time",
    "status_return_level": "response_status_level", "min_position": "min_position_limit",
    "max_position": "max_position_limit", "temperature_limit": "max_temperature_limit",
    "max_voltage": "max_voltage_limit", "min_voltage": "min_voltage_limit", "max_torque": "max_torque_limit",
    "unloading_condition": "unloading_condition", "position_p_gain": "p_coefficient",
    "position_d_gain": "d_coefficient", "position_i_gain": "i_coefficient", "torque_enable": "torque_enable",
    "present_voltage": "present_voltage", "present_temperature": "present_temperature", "hardware_error": "status",
    "moving": "moving", "homing_offset": "homing_offset", "operating_mode": "operating_mode",
    "protective_torque": "protective_torque", "protection_time": "protection_time",
    "overload_torque": "overload_torque", "profile_acceleration": "acceleration", "goal_position": "goal_position",
    "goal_time": "goal_time", "profile_velocity": "goal_velocity", "torque_limit": "torque_limit", "lock": "lock",
    "present_position": "present_position", "present_velocity": "present_velocity", "present_load": "present_load",
    "present_current": "present_current",
}  # fmt: skip


def vendor_table(name: str) -> tuple[dict[str, tuple[int, int]], dict[str, float]]:
    """(address, size) of each register, and the units, out of a control table of ROBOTIS."""
    package = importlib.resources.files("dynamixel_easy_sdk")
    text = (package / "control_table" / f"{name}.model").read_text()
    _, _, rest = text.partition("[unit info]")
    units, _, table = rest.partition("[control table]")
    rows = [line.split("\t") for line in table.splitlines() if line[:1].isdigit()]
    unit_rows = [line.split("\t") for line in units.splitlines() if line.count("\t") == 3]
    return (
        {row[2]: (int(row[0]), int(row[1])) for row in rows},
        {row[0]: float(row[1]) for row in unit_rows if row[2] == "rad/s"},
    )


@pytest.mark.parametrize(
    ("ours", "file"), [(name, file) for name, files in X_FILES.items() for file in files]
)
def test_dynamixel_registers_are_the_vendors(ours: str, file: str) -> None:
    model = MODELS[ours]
    table, units = vendor_table(file)
    for name, register in model.registers.items():
        assert (register.address, register.size) == table[X_NAMES[name]], name
        if X_NAMES[name] in units:
            assert math.isclose(register.unit, units[X_NAMES[name]], rel_tol=1e-3), name
    assert ("present_load" in model) == ("Present Load" in table)


def test_dynamixel_model_numbers_are_the_vendors() -> None:
    package = importlib.resources.files("dynamixel_easy_sdk")
    rows = (package / "control_table" / "dynamixel.model").read_text().splitlines()
    numbers = {
        row.split("\t")[1].removesuffix(".model"): int(row.split("\t")[0])
        for row in rows
        if row[:1].isdigit()
    }
    for name, files in X_FILES.items():
        found = {numbers[file] for file in files if file in numbers}
        assert found == set(MODELS[name].numbers), name


@pytest.mark.parametrize(
    ("ours", "controller"), [("sts3215", "Sts3215PyController"), ("scs0009", "Scs0009PyController")]
)
def test_feetech_registers_are_those_of_another_driver(ours: str, controller: str) -> None:
    """Feetech's own package on PyPI has packets, but no table of registers."""
    import rustypot

    model, theirs = MODELS[ours], getattr(rustypot, controller)
    table = {register.name: register for register in theirs.registers()}
    for name, register in model.registers.items():
        if name == "firmware":  # ours has major and minor version in one
            assert table["firmware_major_version"].addr == register.address
            continue
        other = table[FEETECH_NAMES[name]]
        assert (register.address, register.size) == (other.addr, other.size), name
        if other.sign_bit is not None:
            assert register.sign_bit == other.sign_bit, name
    assert model.numbers == (theirs.models()[ours.upper()],)


def test_error_bits_are_the_vendors() -> None:
    sdk = importlib.import_module("scservo_sdk.protocol_packet_handler")

    errors = MODELS["sts3215"].errors
    for bit, word in (
        (sdk.ERRBIT_VOLTAGE, "voltage"),
        (sdk.ERRBIT_OVERHEAT, "overheating"),
        (sdk.ERRBIT_OVERLOAD, "overload"),
    ):
        assert word in errors[bit.bit_length() - 1]
    assert "angle" in errors[sdk.ERRBIT_ANGLE.bit_length() - 1]


def test_dynamixel_modes_and_error_numbers_are_the_vendors() -> None:
    modes = importlib.import_module("dynamixel_easy_sdk.data_types").OperatingMode
    for name in X_FILES:
        named = {value: modes(value).name for value in MODELS[name].position_modes}
        assert named == {
            value: text.upper().replace(" ", "_").replace("-", "_")
            for value, text in MODELS[name].position_modes.items()
        }
    sdk = importlib.import_module("dynamixel_sdk.protocol2_packet_handler")
    ours = (dynamixel.ALERT, dynamixel.ERROR_RANGE, dynamixel.ERROR_LIMIT, dynamixel.ERROR_ACCESS)
    assert ours == (sdk.ERRBIT_ALERT, sdk.ERRNUM_DATA_RANGE, sdk.ERRNUM_DATA_LIMIT, sdk.ERRNUM_ACCESS)


@pytest.mark.parametrize(
    ("ours", "controller"), [("xl330", "Xl330PyController"), ("xl430", "Xl430PyController")]
)
def test_dynamixel_bit_rates_are_those_of_another_driver(ours: str, controller: str) -> None:
    """The vendor's tables have the register, but not its codes."""
    import rustypot

    rates = getattr(rustypot, controller).baudrates()
    assert {code: rate for rate, code in rates.items()} == dict(MODELS[ours].baud)


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
@given(st.data())
def test_values_come_back_from_their_bytes(model: ServoModel, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(model.registers)))
    register = model[name]
    bits = 8 * register.size
    if register.sign_bit is not None:
        most = (1 << register.sign_bit) - 1
        value = data.draw(st.integers(-most, most))
    elif register.signed:
        value = data.draw(st.integers(-(1 << bits - 1), (1 << bits - 1) - 1))
    else:
        value = data.draw(st.integers(0, (1 << bits) - 1))
    assert model.unpack(name, model.pack(name, value)) == value
    block = bytes(3) + model.pack(name, value) + bytes(5)
    assert model.part(name, register.address - 3, block) == value
    with pytest.raises(BadInputError, match=name):
        model.pack(name, 1 << 40)


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
def test_a_model_is_sound(model: ServoModel) -> None:
    for name in ("id", "baud_rate", "torque_enable", "goal_position", "present_position", "present_voltage"):
        assert name in model
    spans = sorted((r.address, r.end) for r in model.registers.values())
    assert all(end <= start for (_, end), (start, _) in itertools.pairwise(spans)), "registers overlap"
    assert model_by_number(model.family, model.numbers[0]) is model
    assert model.baud[model.baud_code(1_000_000)] == 1_000_000
    assert model_named(model.name.upper()) is model


def test_feetech_bit_rates_are_those_of_the_memory_table() -> None:
    """The row "Baud rate" of Feetech's table: 0-7 are these, and the data sheet's range is 38400 bit/s to 1 Mbit/s."""
    rates = (1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400)
    for name in ("sts3215", "scs0009"):
        assert tuple(MODELS[name].baud[code] for code in range(8)) == rates


# Data sheets: torque in N m and current in A at a standstill, at the supply that models.py names.
STALL = {
    "sts3215": (2.94, 2.7),
    "scs0009": (0.23, 1.0),
    "xl330": (0.52, 1.47),
    "xl430": (1.5, 1.4),
    "2xc430": (1.8, 1.4),
    "xm430": (4.1, 2.3),
}


def test_stall_figures_are_those_of_the_data_sheets() -> None:
    assert {m.name: (m.stall_torque_nm, m.stall_current_a) for m in MODELS.values()} == STALL


def test_sts_positions_have_their_sign_in_bit_15() -> None:
    sts = MODELS["sts3215"]
    assert sts.pack("goal_position", -5) == b"\x05\x80"
    assert sts.unpack("present_position", b"\x05\x80") == -5
    assert sts.unpack("present_load", b"\x0a\x04") == -10
    assert MODELS["scs0009"].pack("goal_position", 0x0102) == b"\x01\x02"
    assert MODELS["xl330"].pack("goal_position", -2) == b"\xfe\xff\xff\xff"


def test_unknown_names_are_told() -> None:
    with pytest.raises(BadInputError, match="known are sts3215"):
        model_named("mg996r")
    with pytest.raises(BadInputError, match="it knows"):
        MODELS["xl430"].baud_code(1234)
    assert model_by_number("feetech", 9999) is None
