#!/usr/bin/env python3
"""Measures sweeps and tolerances on a GPU: seconds of whole commands, and designs that differ from those of the cores.

    tests/gpu/measure.py target/release/qrm [DESIGNS]

The program must be built with the feature `gpu`. A design is counted if a number of the GPU differs from that of the cores
by more than three times the errors that both state, and by more than rounding errors.
"""

import csv
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ALLOWED = 3
ROUNDING = 1e-13
ENDS = ["--no-extremes", "--no-error-estimate"]


def run(qrm, arguments):
    """The seconds that a command takes; prints its last lines."""
    begun = time.perf_counter()
    output = subprocess.run([qrm, *arguments], stdout=subprocess.PIPE, text=True, check=True).stdout
    seconds = time.perf_counter() - begun
    print(*output.strip().splitlines()[-4:], sep="\n", flush=True)
    return seconds


def differing(own, other):
    """The number of rows that differ."""
    count = 0
    with open(own, newline="") as own, open(other, newline="") as other:
        own, other = csv.reader(own), csv.reader(other)
        columns = next(own)
        if columns != next(other):
            raise SystemExit("the columns differ")
        place = {name: i for i, name in enumerate(columns)}
        status, whole = place["status"], place.get("estimated_error")
        coordinates = range(place["steps"] + 1, next((i for name, i in place.items() if name.endswith("_min")), whole))
        # The errors of rates are per second: those of coordinates alone are stated.
        numbers = [(i, whole) for i in coordinates if not columns[i].endswith("_dot")]
        numbers += [(place[name[: -len("_error")]], i) for name, i in place.items() if name.endswith(("_min_error", "_max_error"))]
        for a, b in zip(own, other, strict=True):
            count += a[status] != b[status] or any(
                a[i] and abs(float(a[i]) - float(b[i]))
                > ALLOWED * (float(a[error] or 0) + float(b[error] or 0)) + ROUNDING * max(1.0, abs(float(b[i])))
                for i, error in numbers
            )
    return count


def main():
    """Measures quick-returns, Andrews' mechanisms and tolerances."""
    qrm, designs = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1_000_000
    with tempfile.TemporaryDirectory() as folder:
        table = {device: str(Path(folder) / f"{device}.csv") for device in ("cpu", "gpu")}
        for scene, vary, of_scene in [
            ("quick-return", "O2A=0.15:0.25", designs),
            ("andrews", "m1=0.03:0.05", designs // 10),
        ]:
            sweep = ["sweep", scene, "--vary", f"{vary}:{of_scene}", "--tolerance", "1e-9"]
            for kind, options in [("ends", ENDS), ("extremes and estimates", [])]:
                seconds = {
                    device: run(qrm, [*sweep, *options, "--device", device, "--out", table[device]]) for device in table
                }
                each = ", ".join(f"{device} {1e6 * s / of_scene:.3f} us" for device, s in seconds.items())
                print(f"\n== {scene}, {of_scene} designs, {kind}: {each} a design\n", flush=True)
            print(f"== {differing(table['gpu'], table['cpu'])} of {of_scene} designs differ\n", flush=True)
        samples = str(min(10 * designs, 100_000_000))
        tolerance = ["tolerance", "quick-return", "--vary", "O2A=+-0.001", "--samples", samples, "--device", "gpu"]
        print(f"\n== {samples} samples: {run(qrm, [*tolerance, '--out', folder]):.1f} s")


if __name__ == "__main__":
    main()
