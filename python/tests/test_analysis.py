"""Equations of motion, accuracy, plots and pages."""

from __future__ import annotations

import numpy as np
import pytest
import qrm


@pytest.mark.parametrize("scene", ["quick-return", "quick-return-driven", "andrews", "pendulum", "thrown-stick"])
def test_the_terms_and_the_solution_belong_together(scene):
    mechanism = qrm.load(scene)
    n, m = len(mechanism.coordinates), len(mechanism.constraints)
    q, qd = mechanism.start()
    at = mechanism.equations(q, qd)
    shapes = {"mass_matrix": (n, n), "forces": (n,), "C": (m,), "C_q": (m, n), "C_t": (m,), "gamma": (m,)}
    shapes |= {"qdd": (n,), "multipliers": (m,)}
    for name, shape in shapes.items():
        assert getattr(at, name).shape == shape, name
    size = max(1.0, np.abs(at.forces).max())
    np.testing.assert_allclose(at.mass_matrix @ at.qdd + at.C_q.T @ at.multipliers, at.forces, atol=1e-12 * size)
    np.testing.assert_allclose(at.C_q @ at.qdd, at.gamma, atol=1e-10 * max(1.0, np.abs(at.gamma).max(initial=0)))
    np.testing.assert_allclose(at.C, np.zeros(m), atol=1e-12)
    np.testing.assert_allclose(at.C_q @ qd + at.C_t, np.zeros(m), atol=1e-11)
    assert at.mass_matrix.tolist() == at.mass_matrix.T.tolist()


def test_the_equations_are_those_of_a_row(quick_return):
    result = quick_return.run(O2A=0.22, end_time=0.1)
    row = 57
    names = [coordinate.name for coordinate in quick_return.coordinates]
    q, qd, qdd = ([result[name + end][row] for name in names] for end in ("", "_dot", "_ddot"))
    at = quick_return.equations(q, qd, t=result.t[row], O2A=0.22)
    np.testing.assert_allclose(at.qdd, qdd, rtol=1e-11)
    assert at.outputs["N3"] == pytest.approx(result["N3"][row], rel=1e-11)
    assert at.kinetic_energy + at.potential_energy == pytest.approx(result["energy"][row], rel=1e-12)


def test_the_jacobian_of_the_constraints_agrees_with_differences(quick_return):
    q, qd = quick_return.start()
    change = 1e-6
    for place in range(3):
        step = change * np.eye(3)[place]
        quotient = (quick_return.equations(q + step, qd).C - quick_return.equations(q - step, qd).C) / (2 * change)
        np.testing.assert_allclose(quick_return.equations(q, qd).C_q[:, place], quotient, atol=1e-8)


def test_a_vector_of_another_length_is_refused(quick_return):
    with pytest.raises(qrm.OptionError, match="`q` has 2 entries instead of 3") as raised:
        quick_return.equations([1, 2], [0, 0, 0])
    assert "phi2, phi4, phi5" in raised.value.hints[0]


def test_the_equations_take_finite_numbers_and_parameters_alone(quick_return):
    q, qd = quick_return.start()
    with pytest.raises(TypeError, match="`q` must be real numbers"):
        quick_return.equations(q + 1j, qd)
    with pytest.raises(ValueError, match="`qd` must be finite"):
        quick_return.equations(q, [0, np.nan, 0])
    with pytest.raises(qrm.OptionError, match="`t` must be finite"):
        quick_return.equations(q, qd, t=np.nan)
    with pytest.raises(ValueError, match=r"`q` has shape \(1, 3\) instead of \(n,\)"):
        quick_return.equations([q], qd)
    with pytest.raises(qrm.OptionError, match="no parameter `step`"):
        quick_return.equations(q, qd, step=3.0)
    same = quick_return.equations(q, qd, set={"O2A": np.float32(0.25)})
    np.testing.assert_array_equal(same.mass_matrix, quick_return.equations(q, qd, O2A=0.25).mass_matrix)


def test_the_start_can_be_elsewhere(quick_return):
    q, qd = quick_return.start(start={"phi2": 1.0}, w0=3)
    assert q[0] == 1.0 and qd[0] == 3.0
    assert np.abs(quick_return.equations(q, qd).C).max() < 1e-12


def test_accuracy_measures_every_method(quick_return):
    accuracy = quick_return.accuracy(budget=1.0, end_time=0.2, at=[0.1, 0.2])
    table = accuracy.table
    assert {"rk4, mass metric", "dop853, mass metric"} <= set(table["method"])
    errors = table["error_position"][table["method"] == "rk4, mass metric"]
    assert errors[0] > 10 * errors[1] and (table["failure"] == "").all()
    assert accuracy._repr_svg_().startswith("<svg") and "error" in str(accuracy)
    assert len(accuracy.recommendations) == 5 and "uncertain by" in accuracy.reference
    with pytest.raises(qrm.OptionError, match="there is no reference `best`") as raised:
        quick_return.accuracy(reference="best")
    assert raised.value.hints == ["references: energy, scene, run"]
    with pytest.raises(qrm.OptionError, match="there is no such column"):
        quick_return.accuracy(of="x7")


def test_a_page_simulates_the_scene(quick_return, tmp_path):
    page = quick_return.animate(height=500)
    assert page.html.startswith("<!DOCTYPE html>") and "qrm-panel" in page.html
    shown = page._repr_html_()
    assert shown.startswith("<iframe") and 'height="500"' in shown and "<script" not in shown
    page.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == page.html
    played = quick_return.animate(O2A=0.25, end_time=0.5)
    assert played.html != page.html and "qrm-panel" not in played.html
    assert "kB" in repr(page)


def test_plots_have_units(quick_return):
    pytest.importorskip("matplotlib").use("Agg")
    axes = quick_return.plot("N3", "N6", end_time=0.2)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("t (s)", "N3, N6 (N)")
    lines = axes.get_lines()
    result = quick_return.run(end_time=0.2)
    assert np.array_equal(lines[0].get_ydata(), result["N3"]) and len(axes.collections) == 2
    both = result.plot("x6", "N3", x="phi2").figure.axes
    assert [axes.get_ylabel() for axes in both] == ["x6 (m)", "N3 (N)"] and len(both[0].get_legend().texts) == 2
    over_angle = result.plot("x6", x="phi2")
    assert (over_angle.get_xlabel(), over_angle.get_ylabel()) == ("phi2 (rad)", "x6 (m)")
    assert result.plot().get_ylabel() == "x6 (m)"
    assert result.plot("N3", axes=axes) is axes
    assert len({line.get_color() for line in axes.get_lines()}) == 3
