"""Times of runs and sweeps: python3 python/benches/times.py [target/release/qrm]."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import qrm

M = qrm.load("quick-return")


def every_column(result: qrm.Result) -> None:
    """Makes the array of every column."""
    for name in result:
        result[name]


RUNS: dict[str, Callable[[], object]] = {
    "run()": lambda: M.run(),
    "run(), every column": lambda: every_column(M.run()),
    "run(estimate_error=False)": lambda: M.run(estimate_error=False),
    "run(O2A=0.21)": lambda: M.run(O2A=0.21),
    'run(method="dop853", tolerance=1e-10)': lambda: M.run(method="dop853", tolerance=1e-10),
    'run(method="dop853", tolerance=1e-10, step=0.05)': lambda: M.run(method="dop853", tolerance=1e-10, step=0.05),
    "run(end_time=0.001)": lambda: M.run(end_time=0.001),
    "equations()": lambda: M.equations(),
}


def seconds(work: Callable[[], object]) -> float:
    """The time that some work takes."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def main() -> None:
    """Prints the times."""
    for name, work in RUNS.items():
        print(f"{name:50} {1e3 * statistics.median(seconds(work) for _ in range(200)):8.3f} ms")
    lengths = np.linspace(0.15, 0.25, 10_000)
    package: list[float] = []
    command: list[float] = []
    program = [str(Path(word).resolve()) for word in sys.argv[1:2]]
    with tempfile.TemporaryDirectory() as folder:
        words = ["sweep", "quick-return", "--vary", "O2A=0.15:0.25:10000", "--out", f"{folder}/sweep.csv"]
        for _ in range(15):
            package.append(seconds(lambda: M.sweep(O2A=lengths)))
            if program:
                command.append(seconds(lambda: subprocess.run([*program, *words], check=True, capture_output=True)))
    print(f"{'sweep of 10 000 designs':50} {1e3 * statistics.median(package):8.1f} ms")
    if command:
        ratio = statistics.median(own / other for own, other in zip(package, command))
        print(f"{'the same by the command':50} {1e3 * statistics.median(command):8.1f} ms, ratio {ratio:.2f}")


if __name__ == "__main__":
    main()
