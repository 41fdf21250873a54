"""The command `qrm` that the package installs."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import qrm

COMMAND = shutil.which("qrm", path=str(Path(sys.executable).parent))
pytestmark = pytest.mark.skipif(COMMAND is None, reason="the package is not installed with its script")


def run(*arguments, cwd, **env):
    return subprocess.run(
        [COMMAND, *arguments], cwd=cwd, env={**os.environ, **env}, capture_output=True, text=True, check=False
    )


def test_a_run_gives_the_rows_of_the_package(tmp_path):
    done = run("run", "quick-return", "--no-figures", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    table = np.genfromtxt(tmp_path / "out/trajectory.csv", delimiter=",", names=True)
    assert np.array_equal(table["phi2"], np.asarray(qrm.load("quick-return").run()["phi2"]))
    assert json.loads((tmp_path / "out/summary.json").read_text())["status"]


def test_wrong_use_is_told_by_the_exit_status(tmp_path):
    done = run("run", "no-such-scene", cwd=tmp_path)
    assert done.returncode == 2
    assert "no-such-scene" in done.stderr
    assert run("--version", cwd=tmp_path).returncode == 0


def test_a_new_scene_needs_the_engine(tmp_path):
    scene = Path(__file__).parents[2] / "scenes/pendulum.toml"
    (tmp_path / "mine.toml").write_text(scene.read_text() + "# Another text.\n")
    done = run("run", "mine.toml", cwd=tmp_path, QRM_ENGINE="/nowhere/qrm-engine", QRM_CACHE=str(tmp_path / "cache"))
    assert done.returncode == 2
    assert "symbolic engine" in done.stderr
