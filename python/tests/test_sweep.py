"""Sweeps against those of the command."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest
import qrm
from conftest import table


def check_equal(found: qrm.SweepTable, path) -> None:
    expected = table(path)
    assert list(found.dtype.names) == list(expected)
    for name, column in expected.items():
        values = found[name]
        if values.dtype.kind in "UO":
            assert values.tolist() == column, name
        elif values.dtype.kind == "i":
            assert values.tolist() == [int(entry or 0) for entry in column], name
        else:
            assert values.tobytes() == np.array([float(entry or "nan") for entry in column]).tobytes(), name
    units = json.loads(path.with_suffix(".units.json").read_text())
    assert found.units == {name: meaning["unit"] for name, meaning in units.items()}
    assert found.docs == {name: meaning["doc"] for name, meaning in units.items()}


def test_combinations_are_those_of_the_command(run_command, tmp_path, quick_return):
    path = tmp_path / "sweep.csv"
    run_command("sweep", "quick-return", "--vary", "O2A=0.15:0.25:41", "--vary", "J2=50,100", "--out", str(path))
    found = quick_return.sweep(O2A=[float(f"{value:.14e}") for value in np.linspace(0.15, 0.25, 41)], J2=[50, 100])
    assert found.shape == (82,) and found.done.all()
    check_equal(found, path)


def test_designs_that_fail_have_a_reason(run_command, tmp_path, quick_return):
    path = tmp_path / "sweep.csv"
    words = ["--vary", "BC=0.1,0.6", "--vary", "J2=-1,100", "--set", "O2A=0.21", "--tolerance", "1e-11"]
    run_command("sweep", "quick-return", *words, "--no-extremes", "--no-error-estimate", "--out", str(path))
    found = quick_return.sweep(
        BC=[0.1, 0.6], J2=[-1, 100], O2A=0.21, tolerance=1e-11, extremes=False, estimate_error=False
    )
    check_equal(found, path)
    assert found.done.tolist() == [False, False, False, True]
    assert "negative" in found["reason"][0] and "cannot be assembled" in found["reason"][1]
    assert np.isnan(found["x6_min" if "x6_min" in found.dtype.names else "phi2"][0])


def test_fixed_steps_and_conditions_are_as_in_the_command(run_command, tmp_path, quick_return):
    path = tmp_path / "sweep.csv"
    words = ["--vary", "O2A=0.2,0.25", "--method", "rk4", "--step", "0.002", "--until", "phi2 >= pi"]
    run_command("sweep", "quick-return", *words, "--out", str(path))
    check_equal(quick_return.sweep(O2A=[0.2, 0.25], method="rk4", step=0.002, until="phi2 >= pi"), path)


def test_paired_designs_take_one_value_of_each(quick_return):
    random = np.random.default_rng(1)
    o2a, bc = random.uniform(0.19, 0.21, 300), random.uniform(0.58, 0.62, 300)
    found = quick_return.sweep(O2A=o2a, BC=bc, paired=True)
    assert found["O2A"].tobytes() == o2a.tobytes() and found["BC"].tobytes() == bc.tobytes()
    alone = quick_return.run(O2A=o2a[7], BC=bc[7], method="dop853", tolerance=1e-9)
    assert found["phi4"][7] == pytest.approx(alone.end_state["phi4"], abs=1e-8)
    assert found["N3_max"][7] == pytest.approx(alone.extremes["N3"]["max"], rel=1e-7)


def test_a_table_keeps_units_when_it_is_cut_and_pickled(quick_return):
    found = quick_return.sweep(O2A=[0.2, 0.25])
    assert found[found.done].units["x6_max"] == "m"
    assert type(found["O2A"]) is np.ndarray and type(found[["O2A", "x6_max"]]) is qrm.SweepTable
    same = pickle.loads(pickle.dumps(found))
    assert same.units == found.units and same["x6_max"].tobytes() == found["x6_max"].tobytes()
    assert found[0]["status"] == "done"


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"O2A": 0.2}, TypeError, "varies at least one parameter"),
        ({"O2X": [0.2]}, qrm.OptionError, "has no parameter `O2X`"),
        ({"O2A": [0.2, float("nan")]}, qrm.OptionError, "a value of `O2A` is NaN"),
        ({"O2A": [[0.2]]}, TypeError, "sequence of numbers"),
        ({"O2A": [0.2], "J2": [1, 2], "paired": True}, qrm.OptionError, "`O2A` has 1 values and `J2` has 2"),
        ({"O2A": [0.2], "step": 0.1}, qrm.OptionError, "`step` needs a method of fixed steps"),
        ({"O2A": [0.2], "start": {"phi2": 1}}, qrm.OptionError, "begins at the start of the scene"),
    ],
)
def test_wrong_sweeps_are_refused(quick_return, options, error, message):
    with pytest.raises(error, match=message):
        quick_return.sweep(**options)
    assert len(quick_return.sweep(O2A=[])) == 0
