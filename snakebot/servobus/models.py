"""The servos that are known. Addresses and sizes are held against the vendors' own tables by a test.

Sources: ROBOTIS e-Manual (X series control tables, protocol 2.0), Feetech's memory tables for SMS/STS and SCSCL; units
from the same places. A 2XC430 is two servos with an id each.

Torque and current at a standstill, each at the supply named beside it:

* XL330-M288, XL430-W250, 2XC430-W250, XM430-W350: the "Stall Torque" line of their e-Manual pages
  (emanual.robotis.com/docs/en/dxl/x/). With the same current, an XL330-M077 has 0.215 N m and an XM430-W210 3.0 N m.
* STS3215 (C018): Feetech's product page, www.feetechrc.com/525603.
* SCS0009: Feetech's specification sheet, as others cite it (its section 5-5); the sheet itself was not at hand.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from snakebot.errors import BadInputError
from snakebot.servobus.registers import Family, Register, ServoModel

_RPM = 2 * math.pi / 60  # rad/s
_TURN = 2 * math.pi  # rad


def _x_series(current_a: float | None) -> dict[str, Register]:
    """Registers of a Dynamixel X servo; ``current_a``: one count of its current register, None: it measures load."""
    counts = _TURN / 4096
    velocity = 0.229 * _RPM
    registers = {
        "model_number": Register(0, 2, stored=True),
        "firmware": Register(6, 1, stored=True),
        "id": Register(7, 1, stored=True),
        "baud_rate": Register(8, 1, stored=True),
        "return_delay": Register(9, 1, unit=2e-6, stored=True),
        "drive_mode": Register(10, 1, stored=True),
        "operating_mode": Register(11, 1, stored=True),
        "homing_offset": Register(20, 4, unit=counts, signed=True, stored=True),
        "temperature_limit": Register(31, 1, stored=True),
        "max_voltage": Register(32, 2, unit=0.1, stored=True),
        "min_voltage": Register(34, 2, unit=0.1, stored=True),
        "pwm_limit": Register(36, 2, unit=0.00113, stored=True),
        "velocity_limit": Register(44, 4, unit=velocity, stored=True),
        "max_position": Register(48, 4, unit=counts, stored=True),
        "min_position": Register(52, 4, unit=counts, stored=True),
        "shutdown": Register(63, 1, stored=True),
        "torque_enable": Register(64, 1),
        "status_return_level": Register(68, 1),
        "hardware_error": Register(70, 1),
        "position_d_gain": Register(80, 2),
        "position_i_gain": Register(82, 2),
        "position_p_gain": Register(84, 2),
        "bus_watchdog": Register(98, 1, unit=0.02, signed=True),
        "goal_pwm": Register(100, 2, unit=0.00113, signed=True),
        "profile_acceleration": Register(108, 4, unit=214.577 * _TURN / 3600),  # rev/min2
        "profile_velocity": Register(112, 4, unit=velocity),
        "goal_position": Register(116, 4, unit=counts, signed=True),
        "moving": Register(122, 1),
        "present_velocity": Register(128, 4, unit=velocity, signed=True),
        "present_position": Register(132, 4, unit=counts, signed=True),
        "present_voltage": Register(144, 2, unit=0.1),
        "present_temperature": Register(146, 1),
    }
    if current_a is None:
        registers["present_load"] = Register(126, 2, unit=0.001, signed=True)
    else:
        registers["present_current"] = Register(126, 2, unit=current_a, signed=True)
        registers["goal_current"] = Register(102, 2, unit=current_a, signed=True)
        registers["current_limit"] = Register(38, 2, unit=current_a, stored=True)
    return registers


_X_BAUD = {0: 9600, 1: 57600, 2: 115200, 3: 1_000_000, 4: 2_000_000, 5: 3_000_000, 6: 4_000_000}
_X_ERRORS = {0: "input voltage", 2: "overheating", 3: "motor encoder", 4: "electrical shock", 5: "overload"}
_X_MODES = {3: "position", 4: "extended position"}
_X_ITSELF = (
    "bus watchdog: without an instruction for as long as register 98 says, brakes where it is and refuses goals",
    "overload, overheating, electrical shock: torque off until it is rebooted (register 63 says at which)",
)


def _dynamixel(
    name: str,
    numbers: tuple[int, ...],
    *,
    current_a: float | None,
    firmware: int,
    torque_nm: float,
    stall_a: float,
) -> ServoModel:
    modes = _X_MODES if current_a is None else {**_X_MODES, 5: "current-based position"}
    return ServoModel(
        name,
        "dynamixel",
        numbers,
        MappingProxyType(_x_series(current_a)),
        counts_per_rev=4096,
        lowest=0,
        highest=4095,
        baud=_X_BAUD,
        position_modes=modes,
        multi_turn_modes=frozenset({4, 5}),
        errors=_X_ERRORS,
        watchdog_firmware=firmware,
        stall_torque_nm=torque_nm,
        stall_current_a=stall_a,
        by_itself=_X_ITSELF,
    )


_STS_COUNT = _TURN / 4096  # rad
_FEETECH_ERRORS = {
    0: "input voltage",
    1: "angle sensor",
    2: "overheating",
    3: "overcurrent",
    5: "overload",
}
_FEETECH_BAUD = {
    0: 1_000_000,
    1: 500_000,
    2: 250_000,
    3: 128_000,
    4: 115_200,
    5: 76_800,
    6: 57_600,
    7: 38_400,
}
_FEETECH_COMMON = {
    "firmware": Register(0, 2, stored=True),  # major, minor
    "model_number": Register(3, 2, stored=True),
    "id": Register(5, 1, stored=True),
    "baud_rate": Register(6, 1, stored=True),
    "return_delay": Register(7, 1, unit=2e-6, stored=True),
    "status_return_level": Register(8, 1, stored=True),
    "min_position": Register(9, 2, stored=True),
    "max_position": Register(11, 2, stored=True),
    "temperature_limit": Register(13, 1, stored=True),
    "max_voltage": Register(14, 1, unit=0.1, stored=True),
    "min_voltage": Register(15, 1, unit=0.1, stored=True),
    "max_torque": Register(16, 2, unit=0.001, stored=True),
    "unloading_condition": Register(19, 1, stored=True),
    "position_p_gain": Register(21, 1, stored=True),
    "position_d_gain": Register(22, 1, stored=True),
    "position_i_gain": Register(23, 1, stored=True),
    "torque_enable": Register(40, 1),
    "present_voltage": Register(62, 1, unit=0.1),
    "present_temperature": Register(63, 1),
    "hardware_error": Register(65, 1),
    "moving": Register(66, 1),
}
_STS = _FEETECH_COMMON | {
    "homing_offset": Register(31, 2, unit=_STS_COUNT, sign_bit=11, stored=True),
    "operating_mode": Register(33, 1, stored=True),
    "protective_torque": Register(34, 1, unit=0.01, stored=True),
    "protection_time": Register(35, 1, unit=0.01, stored=True),
    "overload_torque": Register(36, 1, unit=0.01, stored=True),
    "profile_acceleration": Register(41, 1, unit=100 * _STS_COUNT),
    "goal_position": Register(42, 2, unit=_STS_COUNT, sign_bit=15),
    "goal_time": Register(44, 2, unit=0.001),
    "profile_velocity": Register(46, 2, unit=_STS_COUNT, sign_bit=15),
    "torque_limit": Register(48, 2, unit=0.001),
    "lock": Register(55, 1),
    "present_position": Register(56, 2, unit=_STS_COUNT, sign_bit=15),
    "present_velocity": Register(58, 2, unit=_STS_COUNT, sign_bit=15),
    "present_load": Register(60, 2, unit=0.001, sign_bit=10),
    "present_current": Register(69, 2, unit=0.0065, sign_bit=15),
}
_SCS_COUNT = math.radians(300) / 1024  # rad
_SCS = _FEETECH_COMMON | {
    "protective_torque": Register(37, 1, unit=0.01, stored=True),
    "protection_time": Register(38, 1, unit=0.01, stored=True),
    "overload_torque": Register(39, 1, unit=0.01, stored=True),
    "goal_position": Register(42, 2, unit=_SCS_COUNT),
    "goal_time": Register(44, 2, unit=0.001),
    "profile_velocity": Register(46, 2, unit=_SCS_COUNT, sign_bit=15),
    "lock": Register(48, 1),
    "present_position": Register(56, 2, unit=_SCS_COUNT),
    "present_velocity": Register(58, 2, unit=_SCS_COUNT, sign_bit=15),
    "present_load": Register(60, 2, unit=0.001, sign_bit=10),
}

MODELS: Mapping[str, ServoModel] = MappingProxyType(
    {
        model.name: model
        for model in (
            ServoModel(
                "sts3215",
                "feetech",
                (777,),
                MappingProxyType(_STS),
                counts_per_rev=4096,
                lowest=0,
                highest=4095,
                baud=_FEETECH_BAUD,
                position_modes={0: "position"},
                multi_turn_modes=frozenset({0}),  # where both angle limits are 0
                errors=_FEETECH_ERRORS,
                stall_torque_nm=2.94,  # 30 kg cm at 12 V; 1.9 N m at 7.4 V
                stall_current_a=2.7,  # 12 V
                by_itself=(
                    "no bus watchdog: without a host it holds its last goal with all its torque",
                    "overload: more than overload_torque for protection_time leaves it protective_torque",
                    "overheating, overcurrent, voltage: torque off where unloading_condition says so",
                ),
            ),
            ServoModel(
                "scs0009",
                "feetech",
                (1284,),
                MappingProxyType(_SCS),
                counts_per_rev=1024 * 360 / 300,
                lowest=0,
                highest=1023,
                baud=_FEETECH_BAUD,
                position_modes={},
                errors=_FEETECH_ERRORS,
                big_endian=True,
                sync_read=False,
                stall_torque_nm=0.23,  # 2.3 kg cm at 6 V
                stall_current_a=1.0,  # 6 V
                by_itself=("no bus watchdog: without a host it holds its last goal with all its torque",),
            ),
            # XL330 at 5 V, the others at 12 V
            _dynamixel("xl330", (1190, 1200), current_a=0.001, firmware=0, torque_nm=0.52, stall_a=1.47),
            _dynamixel("xl430", (1060,), current_a=None, firmware=38, torque_nm=1.5, stall_a=1.4),
            _dynamixel("2xc430", (1160,), current_a=None, firmware=0, torque_nm=1.8, stall_a=1.4),
            _dynamixel("xm430", (1020, 1030), current_a=0.00269, firmware=38, torque_nm=4.1, stall_a=2.3),
        )
    }
)


@cache
def model_by_number(family: Family, number: int) -> ServoModel | None:
    """The model that calls itself so, or None."""
    for model in MODELS.values():
        if model.family == family and number in model.numbers:
            return model
    return None


def model_named(name: str) -> ServoModel:
    """A model by its name.

    Raises:
        BadInputError: there is none of that name.
    """
    if name.lower() not in MODELS:
        raise BadInputError(f"servo model {name!r}: known are {', '.join(MODELS)}")
    return MODELS[name.lower()]
