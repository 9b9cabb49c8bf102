"""Elementary functions in plain arithmetic, without a branch: for numbers and for lanes, the same to the last bit.

Ranges are reduced as in every mathematical library; the series are Taylor's, cut where the rest is below 1e-16.
"""

from __future__ import annotations

import math
from typing import Any

from snakebot.physics.compiled import in_place
from snakebot.physics.lanes import at_most, magnitude, power_of_two

_ROUND = 1.5 * 2.0**52  # adding and taking it off again rounds to an integer
_ONE_OVER_PI = 1.0 / math.pi  # for the reduction of an argument to half a turn
_PI_HIGH = 3.141592653589793116  # pi to double precision
_PI_LOW = 1.2246467991473532e-16  # pi - _PI_HIGH
_ONE_OVER_LN2 = 1.4426950408889634  # for the reduction of an exponent
_LN2_HIGH = 6.93147180369123816490e-01  # its last bits are 0, so that k times it is exact
_LN2_LOW = 1.90821492927058770002e-10  # ln 2 - _LN2_HIGH
_S = tuple((-1.0) ** i / math.factorial(2 * i + 1) for i in range(11))
_C = tuple((-1.0) ** i / math.factorial(2 * i) for i in range(11))
_E = tuple(1.0 / math.factorial(i + 1) for i in range(13))
_TINY = 1e-300  # m/s; keeps a direction finite, far below any speed

S1, S2, S3, S4, S5, S6, S7, S8, S9, S10 = _S[1:]
C1, C2, C3, C4, C5, C6, C7, C8, C9, C10 = _C[1:]
E1, E2, E3, E4, E5, E6, E7, E8, E9, E10, E11, E12 = _E[1:]


@in_place
def sine_cosine(x: Any) -> Any:
    """(sin x, cos x), to 2e-16 for |x| up to 1e5."""
    shifted = x * _ONE_OVER_PI + _ROUND
    k = shifted - _ROUND
    r = (x - k * _PI_HIGH) - k * _PI_LOW
    half = 0.5 * k
    odd = half - ((half + _ROUND) - _ROUND)  # 0, or +-1/2 where k is odd
    sign = 1.0 - 8.0 * odd * odd
    q = r * r
    s = S6 + q * (S7 + q * (S8 + q * (S9 + q * S10)))
    s = r + r * q * (S1 + q * (S2 + q * (S3 + q * (S4 + q * (S5 + q * s)))))
    c = C6 + q * (C7 + q * (C8 + q * (C9 + q * C10)))
    c = 1.0 + q * (C1 + q * (C2 + q * (C3 + q * (C4 + q * (C5 + q * c)))))
    return sign * s, sign * c


@in_place
def sign_over_speed(v: Any, inverse_eps: Any) -> Any:
    """tanh(v/eps)/v, finite at 0: the regularised sign as a coefficient of the speed."""
    speed = magnitude(v) + _TINY
    x = at_most(2.0 * speed * inverse_eps, 50.0)
    shifted = x * _ONE_OVER_LN2 + _ROUND
    k = shifted - _ROUND
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    p = E6 + r * (E7 + r * (E8 + r * (E9 + r * (E10 + r * (E11 + r * E12)))))
    p = r + r * r * (E1 + r * (E2 + r * (E3 + r * (E4 + r * (E5 + r * p)))))
    scale = power_of_two(shifted)
    growth = scale * p + (scale - 1.0)  # exp(x) - 1
    return growth / ((growth + 2.0) * speed)
