"""One effect with its numbers, as written after ``--effect``: ``rate_limit:limit_rad_s=1.6,joints=3+4``."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from snakebot.effects.registry import effects, find_effect
from snakebot.errors import BadInputError
from snakebot.nearest import not_known

if TYPE_CHECKING:
    from snakebot.effects.effect import Effect
    from snakebot.effects.parameter import Parameter
    from snakebot.robot import Robot

Value = float | tuple[float, ...]


@dataclass(frozen=True)
class EffectSpec:
    """An effect with values, on all joints (``joints`` None) or on some (1-based).

    Build it by ``parse_effect``, or by ``EffectSpec(...)`` from numbers that are known to be good; ``checked()`` tells.
    """

    name: str
    values: Mapping[str, Value] = field(default_factory=dict)
    joints: tuple[int, ...] | None = None

    def __hash__(self) -> int:
        return hash((self.name, tuple(sorted(self.values.items())), self.joints))

    def __str__(self) -> str:
        parts = [f"{key}={_text(value)}" for key, value in self.values.items()]
        if self.joints is not None:
            parts.append("joints=" + "+".join(str(j) for j in self.joints))
        return ":".join([self.name, ",".join(parts)]) if parts else self.name

    @property
    def effect(self) -> Effect:
        return find_effect(self.name)

    def value(self, name: str) -> float:
        """A parameter's value, or its default."""
        found = self.values.get(name)
        if found is None:
            found = self.effect.parameter(name).default
        if found is None or isinstance(found, tuple):
            raise BadInputError(f"effect {self.name}: needs {name}=NUMBER")
        return found

    def listed(self, name: str, count: int) -> tuple[float, ...]:
        """The values of a parameter that may have one a joint, spread over ``count`` joints.

        Raises:
            BadInputError: as many values as neither one nor ``count``.
        """
        found = self.values.get(name, self.effect.parameter(name).default)
        row: tuple[float | None, ...] = found if isinstance(found, tuple) else (found,)
        if len(row) == 1:
            row = row * count
        if len(row) != count or any(v is None for v in row):
            raise BadInputError(f"effect {self.name}: {name} has {len(row)} values for {count} joints")
        return tuple(float(v) for v in row if v is not None)

    def joint_indices(self, joints: int) -> tuple[int, ...]:
        """0-based joints that it holds for, of a robot with ``joints``."""
        return tuple(range(joints)) if self.joints is None else tuple(j - 1 for j in self.joints)

    def by_joint(self) -> tuple[EffectSpec, ...]:
        """Itself; or, where values are listed joint by joint, one effect for each joint."""
        many = {p.name for p in self.effect.parameters if p.many}
        listed = [
            name for name, value in self.values.items() if isinstance(value, tuple) and name not in many
        ]
        if not listed or self.joints is None:
            return (self,)
        return tuple(
            EffectSpec(
                self.name,
                {
                    name: value[i] if name in listed and isinstance(value, tuple) else value
                    for name, value in self.values.items()
                },
                (joint,),
            )
            for i, joint in enumerate(self.joints)
        )

    def with_values(self, **values: Value) -> EffectSpec:
        return EffectSpec(self.name, {**self.values, **values}, self.joints)

    def checked(self, robot: Robot | None = None) -> EffectSpec:
        """Itself, if effect, parameters and joints exist and the values are inside their bounds.

        Args:
            robot: check joints and links against this one too.

        Raises:
            BadInputError: one line with the effect, the parameter and what is allowed.
        """
        effect = self.effect
        for name, value in self.values.items():
            _check_value(effect, effect.parameter(name), value, self.joints)
        missing = [p.name for p in effect.parameters if p.default is None and p.name not in self.values]
        if missing:
            raise BadInputError(f"effect {self.name}: needs {', '.join(missing)}; {effect.usage}")
        if self.joints is not None:
            if not effect.per_joint:
                raise BadInputError(f"effect {self.name}: works on the whole robot, it takes no joints=")
            if (
                any(j < 1 for j in self.joints)
                or len(set(self.joints)) != len(self.joints)
                or not self.joints
            ):
                raise BadInputError(
                    f"effect {self.name}: joints are numbered from 1, each once, as in joints=3+4"
                )
        if robot is not None:
            if self.joints is not None and max(self.joints) > robot.joints:
                raise BadInputError(
                    f"effect {self.name}: joint {max(self.joints)} of a robot with {robot.joints} joints"
                )
            effect.check(self, robot)
        return self


def _text(value: Value) -> str:
    if isinstance(value, tuple):
        return "+".join(_text(v) for v in value)
    return str(int(value)) if float(value).is_integer() and abs(value) < 1e15 else repr(float(value))


def _check_value(effect: Effect, parameter: Parameter, value: Value, joints: tuple[int, ...] | None) -> None:
    row = value if isinstance(value, tuple) else (value,)
    if len(row) > 1 and not parameter.many and (not effect.per_joint or len(row) != len(joints or ())):
        other = ", or one for each of joints=, as in joints=3+4" if effect.per_joint else ""
        raise BadInputError(f"effect {effect.name}: {parameter.name} takes one value{other}")
    for v in row:
        if not (math.isfinite(v) and parameter.contains(v)):
            kind = "a whole number, " if parameter.integer else ""
            raise BadInputError(
                f"effect {effect.name}: {parameter.name}={_text(v) if math.isfinite(v) else v} is out of bounds "
                f"({kind}{parameter.bounds_text})"
            )


def parse_effect(text: str, robot: Robot | None = None) -> EffectSpec:
    """Read ``NAME[:parameter=value[,parameter=value...][,joints=3+4]]``.

    A value may be one for each of the joints: ``servo_offset:offset_deg=1.5+-2,joints=3+4``.

    Raises:
        BadInputError: one line that names the known effects, the parameters or the bounds.
    """
    name, colon, rest = text.strip().partition(":")
    effect = find_effect(name.strip())
    values: dict[str, Value] = {}
    joints: tuple[int, ...] | None = None
    parts = rest.split(",") if rest.strip() else []
    if colon and not parts:
        raise BadInputError(f"effect {text!r}: nothing after the colon; {effect.usage}")
    for part in parts:
        key, equals, given = (piece.strip() for piece in part.partition("="))
        if not equals or not given:
            raise BadInputError(
                f"effect {effect.name}: {part.strip()!r} is not parameter=value; {effect.usage}"
            )
        if key in values or (key == "joints" and joints is not None):
            raise BadInputError(f"effect {effect.name}: {key} is given twice")
        numbers = _numbers(given)
        if numbers is None:
            raise BadInputError(f"effect {effect.name}: {key}={given} is not a number; {effect.usage}")
        if key == "joints":
            if not all(n.is_integer() for n in numbers):
                raise BadInputError(
                    f"effect {effect.name}: joints={given} are not joint numbers, as in joints=3+4"
                )
            joints = tuple(int(n) for n in numbers)
        else:
            values[effect.parameter(key).name] = numbers[0] if len(numbers) == 1 else numbers
    return EffectSpec(effect.name, values, joints).checked(robot)


def _numbers(text: str) -> tuple[float, ...] | None:
    """``3+4`` as (3, 4); an exponent's sign, as in ``1e+3``, is no separator."""
    pieces: list[str] = []
    for piece in text.split("+"):
        if (
            pieces
            and pieces[-1][-1:] in ("e", "E")
            and pieces[-1][:-1].replace(".", "").lstrip("-").isdigit()
        ):
            pieces[-1] += "+" + piece
        else:
            pieces.append(piece)
    try:
        numbers = tuple(float(piece) for piece in pieces)
    except ValueError:
        return None
    return numbers if all(math.isfinite(n) for n in numbers) else None


def parse_effects(texts: Iterable[str], robot: Robot | None = None) -> tuple[EffectSpec, ...]:
    """Read what was given to ``--effect``, once or several times: effects, or names of sets in ``configs/effects``.

    Raises:
        BadInputError: as ``parse_effect`` and ``load_effect_set``.
    """
    specs: list[EffectSpec] = []
    for text in texts:
        if text.partition(":")[0].strip() in effects():
            specs.append(parse_effect(text, robot))
        elif _names_a_set(text):
            specs.extend(load_effect_set(text, robot))
        else:
            find_effect(text.partition(":")[0].strip(), _our_sets())  # fails, and says what is known
    return tuple(specs)


def robot_effects(robot: Robot) -> tuple[EffectSpec, ...]:
    """The effects that a robot's description says it has: part of its simulation.

    Descriptions come with logs and sessions from anybody: they name effects, and the sets that come with snakebot, but
    no file is ever opened for one.

    Raises:
        BadInputError: the description names an effect that does not exist or does not fit.
    """
    try:
        return tuple(spec for text in robot.effects for spec in _named(text, robot))
    except BadInputError as error:
        raise BadInputError(f"robot {robot.name}: effects: {error}") from None


def _named(text: str, robot: Robot) -> tuple[EffectSpec, ...]:
    ours = _our_set(text)
    return (parse_effect(text, robot),) if ours is None else load_effect_set(ours, robot)


def _our_set(name: str) -> Path | None:
    """The file of a set that comes with snakebot; no name leads out of its folder."""
    from snakebot.resources import configs_root

    path = configs_root() / "effects" / f"{name}.yaml"
    return path if _SET_NAME.fullmatch(name) and path.is_file() else None


def _our_sets() -> list[str]:
    from snakebot.resources import configs_root

    return sorted(path.stem for path in (configs_root() / "effects").glob("*.yaml"))


def _names_a_set(text: str) -> bool:
    if _our_set(text.removesuffix(".yaml")) is not None:
        return True
    try:
        return Path(text).is_file()
    except (OSError, ValueError):  # too long for the name of a file, or none at all
        return False


SET_SCHEMA = "snakebot.effects/1"
_SET_KEYS = ("schema", "effects", "source")
_SET_NAME = re.compile(r"[a-z0-9_]{1,64}")


def load_effect_set(source: str | Path, robot: Robot | None = None) -> tuple[EffectSpec, ...]:
    """Effects from a YAML file with ``effects: [...]``, the user's own or one of ``configs/effects`` by its name.

    Raises:
        BadInputError: no such file, not YAML, or an effect in it is wrong; the line names the file.
    """
    from snakebot.resources import config_path
    from snakebot.safe_yaml import Lines, load_yaml

    path = config_path("effects", source)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the effects: {error.strerror}") from None
    data, lines = load_yaml(content, str(path)), Lines(content)
    for key in data if isinstance(data, Mapping) else ():
        if key not in _SET_KEYS:
            raise BadInputError(f"{path}: {lines.of(key)}{not_known(key, _SET_KEYS, 'a set of effects')}")
    listed = data.get("effects") if isinstance(data, Mapping) else None
    if (
        not isinstance(listed, Sequence)
        or isinstance(listed, str)
        or not all(isinstance(x, str) for x in listed)
    ):
        raise BadInputError(
            f'{path}: needs effects: [...], each as after --effect, e.g. "command_delay:delay_s=0.05"'
        )
    if data.get("schema", SET_SCHEMA) != SET_SCHEMA:
        raise BadInputError(f"{path}: schema is {data['schema']!r}, this version reads {SET_SCHEMA!r}")
    specs = []
    for index, text in enumerate(listed):
        try:
            specs.append(parse_effect(text, robot))
        except BadInputError as error:
            raise BadInputError(f"{path}: {lines.of('effects', index)}{error}") from None
    return tuple(specs)


def fault_spec(kind: str, joints: Iterable[int], angle_rad: float = 0.0) -> EffectSpec:
    """A joint fault, called as in ``--fault`` (free, rigid), as the effect that it is.

    Args:
        joints: 1-based.
        angle_rad: where they are stuck, if they are.
    """
    effect = next(effect for effect in effects().values() if effect.fault == kind)
    return EffectSpec(effect.name, effect.fault_values(angle_rad), tuple(joints))
