"""Runs against those of the command."""

from __future__ import annotations

import copy
import json
import pickle

import numpy as np
import pytest
import qrm
from conftest import numbers

RUNS = [
    ("quick-return", {}, []),
    (
        "quick-return",
        {"O2A": 0.25, "method": "dop853", "tolerance": 1e-10},
        ["--set", "O2A=0.25", "--method", "dop853", "--tolerance", "1e-10"],
    ),
    ("slider-crank", {"k": "2*10", "end_time": 0.05}, ["--set", "k=2*10", "--end-time", "0.05"]),
    ("quick-return", {"until": "phi2 >= pi", "projection": "none"}, ["--until", "phi2 >= pi", "--projection", "none"]),
    ("quick-return", {"every": 7, "start": {"phi2": 0.5}}, ["--every", "7", "--start", "phi2=0.5"]),
    ("shaper", {"method": "auto", "estimate_error": False}, ["--method", "auto", "--no-error-estimate"]),
    ("pendulum", {"end_time": 3}, ["--end-time", "3"]),
]


@pytest.mark.parametrize(("scene", "options", "words"), RUNS)
def test_a_run_gives_the_rows_of_the_command_to_the_last_bit(run_command, tmp_path, scene, options, words):
    out = run_command("run", scene, *words, "--no-figures", "--out", str(tmp_path / "out"))
    result = qrm.load(scene).run(**options)
    expected = numbers(out / "trajectory.csv")
    assert list(result) == list(expected)
    for name, column in expected.items():
        assert result[name].tobytes() == column.tobytes(), name
    summary = json.loads((out / "summary.json").read_text())
    for varying in ("run_seconds", "figures"):
        summary.pop(varying), result.summary.pop(varying)
    assert result.summary == summary
    meanings = json.loads((out / "trajectory.units.json").read_text())
    assert result.units == {name: meaning["unit"] for name, meaning in meanings.items()}
    assert result.docs == {name: meaning["doc"] for name, meaning in meanings.items()}


def test_arrays_are_whole_columns(quick_return):
    result = quick_return.run()
    assert result.array.shape == (1757, len(quick_return.columns))
    assert result["x6"].shape == result.t.shape == (1757,)
    assert result["x6"].dtype == np.float64 and result["x6"].flags.c_contiguous
    assert result["x6"] is result["x6"]
    assert result.errors["x6"] < 1e-7
    assert result.extremes["N3"]["min"] == pytest.approx(-24359.2176390712, rel=1e-9)
    assert result.end_time == result.t[-1] == pytest.approx(2 * 0.877997139511224403438, abs=1e-9)
    assert "1757 rows by rk4" in repr(result)
    with pytest.raises(KeyError, match="there is no column 'x7'; columns: t, phi2"):
        result["x7"]


def test_a_mechanism_says_what_it_is(quick_return):
    assert quick_return.name == "quick-return" and quick_return.is_compiled
    assert [entry.name for entry in quick_return.coordinates] == ["phi2", "phi4", "phi5"]
    assert [entry.name for entry in quick_return.constraints] == ["slot", "guide"]
    assert ("O2A", "m") in [(entry.name, entry.unit) for entry in quick_return.parameters]
    assert quick_return.values()["O2A"] == 0.2
    assert quick_return.values(O2A="1/4")["O2A"] == 0.25
    assert "quick-return" in qrm.scenes() and "dop853" in qrm.methods()
    assert quick_return.source.startswith("#") or "name" in quick_return.source


def test_mechanisms_and_results_can_be_copied_and_pickled(quick_return):
    for same in (copy.copy(quick_return), copy.deepcopy(quick_return), pickle.loads(pickle.dumps(quick_return))):
        assert same.name == quick_return.name
    result = quick_return.run(end_time=0.01)
    same = pickle.loads(pickle.dumps(result))
    assert same.array.tobytes() == result.array.tobytes() and same.summary == result.summary


def test_a_constraint_that_is_singular_is_rewritten() -> None:
    mechanism = qrm.load("quick-return-loaded")
    with pytest.warns(qrm.RunWarning, match=r"is taken as `A\.x\*sin\(phi4\) - A\.y\*cos\(phi4\)` instead"):
        run = mechanism.run(O2A=0.301, BC=2, BG5=1, end_time=1, method="auto")
    assert run.summary["energy_drift"] < 1e-4


def test_warnings_are_warned_of():
    with pytest.warns(qrm.RunWarning, match="singular position"):
        result = qrm.load("n-four-bar-2").run(end_time=4)
    assert any("singular position" in warning for warning in result.warnings)
