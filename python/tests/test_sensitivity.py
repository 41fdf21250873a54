"""Derivatives against finite differences, the command, and an optimiser."""

from __future__ import annotations

import numpy as np
import pytest
import qrm
from conftest import table
from scipy import optimize

METHOD = {"method": "dop853", "tolerance": 1e-11}


def test_derivatives_are_those_of_the_command(run_command, tmp_path):
    out = run_command("sensitivity", "slider-crank", "--by", "k", "--by", "c", "--out", str(tmp_path / "out"))
    expected = table(out / "sensitivity.csv")
    found = qrm.load("slider-crank").sensitivity(by=["k", "c"])
    assert [quantity.kind for quantity in found.quantities] == expected["quantity"]
    assert [quantity.of for quantity in found.quantities] == expected["of"]
    assert [quantity.unit for quantity in found.quantities] == expected["unit"]
    columns = [("value", found.values)]
    for place, name in enumerate(found.by):
        columns += [(f"by_{name}", found.jacobian[:, place]), (f"by_{name}_error", found.jacobian_errors[:, place])]
    for name, column in columns:
        assert column.tolist() == [float(entry) for entry in expected[name]], name


def test_the_jacobian_agrees_with_finite_differences(quick_return):
    by = ["J2", "BC", "O2A"]
    found = quick_return.sensitivity(by=by, of=["x6", "N3"], **METHOD)
    assert found.jacobian.shape == (len(found.quantities), 3) and found.by == by
    for place, name in enumerate(found.by):
        value = quick_return.values()[name]
        change = 1e-4 * value
        ends = [quick_return.run(**{name: value + sign * change}, **METHOD) for sign in (1, -1)]
        for row in ("minimum x6", "maximum N3"):
            kind, of = row.split()
            quotient = (ends[0].extremes[of][kind[:3]] - ends[1].extremes[of][kind[:3]]) / (2 * change)
            assert found.gradient(row)[place] == pytest.approx(quotient, rel=1e-5), (row, name)
    assert found.unit("maximum N3") == "N" and "maximum N3" in found
    assert found.value_errors.shape == found.values.shape
    with pytest.raises(KeyError, match="there is no quantity 'maximum N4'; quantities: end x6"):
        found.row("maximum N4")


def test_products_of_hessians_agree_with_differences_of_gradients(quick_return):
    by = ["O2A", "BC"]
    found = quick_return.sensitivity(by=by, of=["x6"], hessian_vector={"O2A": 1.0}, **METHOD)
    change = 1e-5
    options = {"by": by, "of": ["x6"], "check": False, **METHOD}
    beside = [quick_return.sensitivity(O2A=length, **options) for length in (0.2 + change, 0.2 - change)]
    at = [derivatives.gradient("maximum x6") for derivatives in beside]
    row = found.row("maximum x6")
    np.testing.assert_allclose(found.hessian_vector[row], (at[0] - at[1]) / (2 * change), rtol=1e-5)
    assert found.hessian_vector_errors.shape == found.hessian_vector.shape


def test_least_squares_finds_the_lengths_of_a_known_motion(quick_return):
    true = {"O2A": 0.21, "BC": 0.63}
    objectives = quick_return.objectives(["O2A", "BC"], ["minimum x6", "maximum x6", "end t"], **METHOD)
    goal = objectives.fun([*true.values()])
    assert objectives.x0.tolist() == [0.2, 0.6]
    found = optimize.least_squares(
        lambda x: objectives.fun(x) - goal, objectives.x0, jac=objectives.jac, xtol=1e-12, ftol=1e-15, gtol=1e-15
    )
    np.testing.assert_allclose(found.x, [*true.values()], rtol=1e-8)


def test_the_order_of_parameters_is_that_of_x(quick_return):
    forward = quick_return.objectives(["O2A", "BC"], "maximum x6", **METHOD)
    backward = quick_return.objectives(["BC", "O2A"], "maximum x6", **METHOD)
    assert forward.fun([0.2, 0.6]) == backward.fun([0.6, 0.2])
    assert forward.jac([0.2, 0.6]).tolist() == backward.jac([0.6, 0.2])[::-1].tolist()
    assert forward.jac([0.2, 0.6]).shape == (2,) and isinstance(forward.fun([0.2, 0.6]), float)
    assert quick_return.objectives(["O2A"], ["end phi4"], **METHOD).jac([0.2]).shape == (1, 1)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"by": ["O2X"]}, qrm.OptionError, "has no parameter `O2X`"),
        ({"of": ["x7"]}, qrm.OptionError, "no output of this name"),
        ({"by": "O2A"}, TypeError, "sequences of names"),
        ({"hessian_vector": {"x": 1}}, qrm.OptionError, "has no parameter `x`"),
        ({"start": {"phi2": 1}}, qrm.OptionError, "from the start of the scene"),
    ],
)
def test_wrong_derivatives_are_refused(quick_return, options, error, message):
    with pytest.raises(error, match=message):
        quick_return.sensitivity(**options)


def test_wrong_objectives_are_refused(quick_return):
    with pytest.raises(qrm.OptionError, match="has no parameter `O2X`"):
        quick_return.objectives(["O2X"], "maximum x6")
    for quantity in ("x6", "largest x6"):
        with pytest.raises(qrm.OptionError, match="is no quantity"):
            quick_return.objectives(["O2A"], quantity)
    for quantity in ("maximum phi2", "end x7"):
        with pytest.raises(qrm.OptionError, match=f"there is no quantity `{quantity}`"):
            quick_return.objectives(["O2A"], quantity)
    with pytest.raises(ValueError, match="x has shape"):
        quick_return.objectives(["O2A"], "maximum x6").fun([0.2, 0.3])


def test_derivatives_that_cannot_be_relied_on_are_an_error():
    with pytest.raises(qrm.RunError):
        qrm.load("double-pendulum").sensitivity(end_time=40)
