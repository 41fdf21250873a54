"""The command `qrm` that the package installs."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import pytest
import qrm
from conftest import ROOT, numbers

COMMAND = shutil.which("qrm", path=str(Path(sys.executable).parent))
pytestmark = pytest.mark.skipif(COMMAND is None, reason="the package is not installed with its script")


def run(*words, cwd, **env):
    return subprocess.run([COMMAND, *words], cwd=cwd, env={**os.environ, **env}, capture_output=True, text=True)


@pytest.mark.parametrize("words", [[], ["run", "quick-return", "--no-figures"]])
def test_a_run_gives_the_rows_of_the_package(tmp_path, words):
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    result = qrm.load("quick-return").run()
    written = numbers(tmp_path / "out/quick-return/trajectory.csv")
    assert list(written) == list(result)
    for name, column in written.items():
        assert result[name].tobytes() == column.tobytes(), name
    summary = json.loads((tmp_path / "out/quick-return/summary.json").read_text())
    assert summary["extremes"] == result.summary["extremes"]


def test_a_table_is_written_in_parquet(tmp_path):
    done = run("sweep", "quick-return", "--vary", "O2A=0.15,0.25", "--out", "table.parquet", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "table.parquet").read_bytes().startswith(b"PAR1")


def test_it_says_its_version(tmp_path):
    done = run("--version", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"qrm {version('qrm')}\n", "")


@pytest.mark.parametrize(
    ("words", "said"), [(["run", "no-such-scene"], "no-such-scene"), (["--no-such-option"], "no-such-option")]
)
def test_wrong_usage_is_told_by_the_exit_status(tmp_path, words, said):
    done = run(*words, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_a_new_scene_needs_the_engine(tmp_path):
    (tmp_path / "mine.toml").write_text((ROOT / "scenes/pendulum.toml").read_text() + "# Another text.\n")
    done = run("run", "mine.toml", cwd=tmp_path, QRM_ENGINE="/nonexistent", QRM_CACHE=str(tmp_path / "cache"))
    assert done.returncode == 2
    assert "the symbolic engine /nonexistent cannot be started" in done.stderr
    assert "QRM_ENGINE" in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_ctrl_c_ends_a_run(tmp_path):
    words = ["run", "quick-return", "--no-figures", "--step", "1e-5", "--end-time", "1e6"]
    process = subprocess.Popen([COMMAND, *words], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    # Rows are written from the start on.
    latest = time.perf_counter() + 20
    while not any(file.is_file() for file in tmp_path.rglob("*")) and time.perf_counter() < latest:
        time.sleep(0.05)
    time.sleep(0.2)
    assert process.poll() is None, "it ended too early"
    begun = time.perf_counter()
    process.send_signal(signal.SIGINT)
    try:
        _, said = process.communicate(timeout=20)
    finally:
        process.kill()
    assert process.returncode == 1
    assert "interrupted at t = " in said
    assert time.perf_counter() - begun < 5
