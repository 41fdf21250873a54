"""Modes and linear models against closed forms and `scipy.signal`."""

from __future__ import annotations

import numpy as np
import pytest
import qrm
from scipy import signal


def test_a_double_pendulum_has_the_frequencies_of_its_closed_form():
    m = qrm.load("double-pendulum")
    for at in ({"a": 0.1, "b": "3deg"}, "a=0.1,b=3deg"):
        found = m.modes(at=at, g=9.81)
        rates = np.sqrt((2 + np.array([-1, 1]) * np.sqrt(2)) * 9.81)
        assert found.frequencies == pytest.approx(rates / (2 * np.pi), rel=1e-14)
        assert found.shapes[0] == pytest.approx([np.sqrt(0.5), 1], rel=1e-14) and found.stability == "stable"
    assert len(found.others) == 3 and found.eigenvalues.imag == pytest.approx(rates, rel=1e-14)
    assert found.report["modes"][0]["by"]["l"] == pytest.approx(-rates[0] / 2, rel=1e-13)


def test_a_linear_model_is_a_state_space_of_scipy():
    model = qrm.load("andrews").linearize(input="mom", output="beta")
    assert model.states == ["beta", "beta_dot"] and model.A.shape == (2, 2) and model.D.shape == (1, 1)
    system = signal.StateSpace(*model.state_space)
    rate = np.sqrt(model.A[1, 0])
    assert sorted(np.linalg.eigvals(system.A)) == pytest.approx([-rate, rate], rel=1e-9)
    # The gain at rest: a torque against the stiffness.
    assert system.freqresp([0.0])[1][0] == pytest.approx(-model.B[1, 0] / model.A[1, 0], rel=1e-9)


def test_mistakes_are_named():
    with pytest.raises(qrm.OptionError, match="has no parameter `G`"):
        qrm.load("slider-crank").linearize(input="G", output="q")
    with pytest.raises(qrm.Error, match="no equilibrium was found"):
        qrm.load("thrown-stick").modes()
