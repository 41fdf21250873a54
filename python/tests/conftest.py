"""The command beside the package: both must give the same numbers."""

from __future__ import annotations

import csv
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import qrm

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def command() -> Path:
    """The program `qrm`, built from the same sources."""
    program = Path(os.environ.get("QRM", ROOT / "target/release/qrm"))
    if not program.is_file():
        pytest.skip(f"{program} is not built; QRM names another one")
    return program


@pytest.fixture
def run_command(command, tmp_path):
    """Runs a subcommand in a folder of its own, and returns its folder of results."""

    def run(*words: str) -> Path:
        out = tmp_path / "out"
        done = subprocess.run([command, *words], cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return out

    return run


@pytest.fixture(scope="session")
def quick_return() -> qrm.Mechanism:
    return qrm.load("quick-return")


def table(path: Path) -> dict[str, list[str]]:
    """The columns of a CSV file as texts."""
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, map(list, zip(*rows))))


def numbers(path: Path) -> dict[str, np.ndarray]:
    """The columns of a CSV file as numbers."""
    return {name: np.array([float(entry) for entry in column]) for name, column in table(path).items()}
