"""Steady motions against the command."""

from __future__ import annotations

import json

import pytest
import qrm


def test_a_motion_is_that_of_the_command(run_command, tmp_path):
    out = run_command("steady", "shaper", "--rows", "90", "--out", str(tmp_path / "out"))
    expected = json.loads((out / "steady.json").read_text())
    motion = qrm.load("shaper").steady(rows=90)
    assert (motion.period, motion.stability) == (expected["period"], "attracting")
    assert motion.start == expected["start"] and motion.start_errors == expected["start_errors"]
    assert motion.multipliers.real.tolist() == [entry["re"] for entry in expected["multipliers"]]
    assert motion.columns["P_motor"]["work"] == expected["columns"]["P_motor"]["work"]
    assert len(motion.result.array) == 91 and motion.result["t"][-1] == motion.period
    assert "attracting" in repr(motion) and motion.solved is None


def test_a_parameter_is_solved_for():
    motion = qrm.load("shaper").steady(solve=("J2", "fluctuation(phi2_dot) = 0.1"))
    again = qrm.load("shaper").steady(J2=motion.solved["value"])
    assert again.columns["phi2_dot"]["fluctuation"] == pytest.approx(0.1, abs=1e-10)


def test_mistakes_are_said():
    with pytest.raises(qrm.OptionError, match="there is no quantity `fluct`"):
        qrm.load("shaper").steady(solve=("J2", "fluct(phi2_dot) = 0.1"))
    with pytest.raises(qrm.RunError, match="leads to a state of rest"):
        qrm.load("slider-crank").steady()
    with pytest.raises(qrm.OptionError, match="cycles"):
        qrm.load("shaper").steady(cycles=0)
