"""Scene files that were never compiled."""

from __future__ import annotations

import os
import pickle
import shutil

import pytest
import qrm
from conftest import ROOT, numbers

HAS_ENGINE = bool(os.environ.get("QRM_ENGINE") or shutil.which("qrm-engine"))
needs_engine = pytest.mark.skipif(not HAS_ENGINE, reason="the engine is not built; QRM_ENGINE names it")


@pytest.fixture
def four_bar(tmp_path):
    """A scene file in links and joints."""
    path = tmp_path / "my-four-bar.toml"
    path.write_text(
        """
name = "my-four-bar"
run = { step = 1e-3, end_time = 1 }
[parameters]
r = { value = 0.1, unit = "m", doc = "length of the crank" }
[links]
ground  = { points = { A = [0, 0], D = [0.4, 0] } }
crank   = { bar = ["A", "B"], length = "r", mass = 1, rate = 10 }
coupler = { bar = ["B", "C"], length = 0.35, mass = 3 }
rocker  = { bar = ["D", "C"], length = 0.25, mass = 2 }
[joints]
A = { revolute = ["crank", "ground"] }
B = { revolute = ["crank", "coupler"], near = [0.07, 0.07] }
C = { revolute = ["coupler", "rocker"], near = [0.35, 0.25] }
D = { revolute = ["rocker", "ground"] }
"""
    )
    return path


@needs_engine
def test_a_scene_file_gives_the_rows_of_the_command(run_command, tmp_path, four_bar):
    mechanism = qrm.load(four_bar)
    assert mechanism.name == "my-four-bar" and not mechanism.is_compiled
    result = mechanism.run()
    out = run_command("run", str(four_bar), "--no-figures", "--out", str(tmp_path / "out"))
    for name, column in numbers(out / "trajectory.csv").items():
        assert result[name].tobytes() == column.tobytes(), name


@needs_engine
def test_a_file_is_read_anew(four_bar):
    before = qrm.load(four_bar).run()
    four_bar.write_text(four_bar.read_text().replace("rate = 10", "rate = 11"))
    after = qrm.load(four_bar).run()
    assert (before["phi_crank_dot"][0], after["phi_crank_dot"][0]) == (10, 11)


@needs_engine
def test_a_pickled_mechanism_keeps_the_text_of_its_file(four_bar):
    stored = pickle.dumps(qrm.load(four_bar))
    four_bar.unlink()
    assert pickle.loads(stored).run(end_time=0.01)["phi_crank_dot"][0] == 10


@needs_engine
def test_interpreted_designs_are_swept(four_bar):
    mechanism = qrm.load(four_bar)
    table = mechanism.sweep(r=[0.1, 0.12])
    assert table.done.all()
    alone = mechanism.run(r=0.12, method="dop853", tolerance=1e-9)
    name = mechanism.coordinates[1].name
    assert table[name][1] == pytest.approx(alone.end_state[name], abs=1e-7)


def test_a_copy_of_a_compiled_scene_is_compiled(tmp_path):
    path = tmp_path / "copy.toml"
    shutil.copy(ROOT / "scenes/quick-return.toml", path)
    assert qrm.load(path).is_compiled


@pytest.mark.skipif(HAS_ENGINE, reason="there is an engine")
def test_without_the_engine_a_hint_says_how_to_get_it(four_bar, monkeypatch, tmp_path):
    monkeypatch.setenv("QRM_CACHE", str(tmp_path / "cache"))
    with pytest.raises(qrm.OptionError, match="qrm-engine"):
        qrm.load(four_bar)
