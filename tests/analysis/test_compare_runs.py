"""A run beside its simulation: what differs, where, and on which clock."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from sample_runs import BENCH, PENN_STATE, bench_run, loaded, snake_run

from snakebot.analysis import compare
from snakebot.analysis.as_json import comparison_json
from snakebot.analysis.as_text import comparison_text
from snakebot.analysis.report_compare import comparison_page
from snakebot.errors import BadInputError


def test_a_nominal_robot_differs_by_counts_only() -> None:
    found = compare(loaded(snake_run()))
    assert found.rms_rad <= PENN_STATE.rad_per_count
    assert found.sim_source == "nominal simulation"
    assert abs(found.speed_error_percent) < 0.5


def test_the_gap_is_where_it_was_put() -> None:
    found = compare(loaded(snake_run(effects=("rate_limit:limit_rad_s=1.5,joints=4",))))
    assert found.joints[3].share > 0.99
    assert found.joints[3].real.tracking.te > 3 * found.joints[3].sim.tracking.te
    assert found.joints[0].rms_rad <= PENN_STATE.rad_per_count
    assert found.speed_error_percent < 0


def test_faults_the_run_was_made_with_are_simulated_too() -> None:
    found = compare(loaded(snake_run(effects=("joint_rigid:angle_deg=20,joints=2",))))
    assert found.rms_rad < 2 * PENN_STATE.rad_per_count


@pytest.mark.parametrize("shift", [0.137, -1.2345])
def test_a_simulation_on_another_clock_and_beat_is_brought_over(shift: float) -> None:
    real = snake_run(rate_hz=50)
    sim = snake_run(rate_hz=83)
    sim = dataclasses.replace(sim, t_s=sim.t_s + shift, name="sim")
    found = compare(loaded(real), loaded(sim))
    assert found.alignment.shift_s == pytest.approx(shift, abs=2e-3)
    assert found.alignment.shift_samples == pytest.approx(shift * 50, abs=0.1)
    assert found.aligned_by == "commands"
    assert np.degrees(found.rms_rad) < 1
    assert found.warnings == ()
    assert "ms" in comparison_text(found)


def test_two_different_motions_are_told() -> None:
    one = loaded(snake_run(omega=2))
    with pytest.raises(
        BadInputError, match=r"were told different motions: .* % of the commands' rms is left"
    ):
        compare(one, loaded(snake_run(omega=3, name="other")))
    larger = dataclasses.replace(one.run, command_rad=1.4 * one.run.command_rad, name="larger")
    assert any("one motion" in warning for warning in compare(one, loaded(larger)).warnings)


def test_a_bench_has_no_body_and_compares_all_the_same() -> None:
    found = compare(loaded(bench_run(), BENCH))
    assert len(found.joints) == 1
    assert found.joints[0].share == pytest.approx(1)
    assert "Over ground" not in comparison_page(found).html()


def test_robots_with_different_joints_are_refused() -> None:
    with pytest.raises(BadInputError, match="not one robot"):
        compare(loaded(snake_run()), loaded(bench_run(), BENCH))


def test_nothing_that_moves_cannot_be_aligned() -> None:
    still = snake_run()
    still = dataclasses.replace(
        still, command_rad=np.zeros_like(still.command_rad), measured_rad=np.zeros_like(still.command_rad)
    )
    with pytest.raises(BadInputError, match="aligned in time"):
        compare(loaded(still), loaded(still))


def test_json_and_page_are_whole() -> None:
    found = compare(loaded(snake_run(lost=0.1)))
    data = json.loads(json.dumps(comparison_json(found), allow_nan=False))
    assert data["schema"] == "snakebot.comparison/1"
    assert len(data["joints"]) == 5
    html = comparison_page(found, "foot").html()
    assert html.count('<figure class="chart') == 5 + 1 + 5 + 1 + 1
