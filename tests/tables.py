"""Tables of `qrm` in pandas and polars: the same numbers, and a unit for every column.

    python3 tests/tables.py target/release/qrm
"""

import json
import os
import subprocess
import sys
import tempfile

import pandas as pd
import polars as pl

QRM = os.path.abspath(sys.argv[1])


def qrm(*arguments):
    subprocess.run([QRM, *arguments], check=True, stdout=subprocess.DEVNULL)


def same(text, parquet, units):
    by_text = pd.read_csv(text)
    by_pandas = pd.read_parquet(parquet)
    by_polars = pl.read_parquet(parquet)
    names = list(json.load(open(units)))
    assert list(by_text.columns) == list(by_pandas.columns) == by_polars.columns == names, names
    for name in names:
        if by_polars[name].dtype.is_numeric():
            assert by_text[name].to_list() == by_polars[name].to_list() == by_pandas[name].to_list(), name
        else:
            assert name in ("status", "reason"), name
    assert pl.read_csv(text).shape == by_polars.shape
    print(f"{text}: {by_polars.shape[0]} rows, {by_polars.shape[1]} columns")
    return json.load(open(units))


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        qrm("run", "quick-return", "--parquet", "--no-figures", "--out", "run")
        units = same("run/trajectory.csv", "run/trajectory.parquet", "run/trajectory.units.json")
        assert units["phi2_dot"]["unit"] == "rad/s" and units["lambda_slot"]["unit"] == "N", units
        vary = ["sweep", "quick-return", "--vary", "O2A=0.15:0.25:50", "--out"]
        qrm(*vary, "sweep.csv")
        qrm(*vary, "sweep.parquet")
        units = same("sweep.csv", "sweep.parquet", "sweep.units.json")
        assert units["O2A"]["unit"] == "m" and units["N3_max"]["unit"] == "N", units
        qrm("sensitivity", "slider-crank", "--of", "T", "--out", "run")
        table = pl.read_csv("run/sensitivity.csv")
        assert abs(table.filter(pl.col("quantity") == "integral")["by_k"][0] - 0.333448106128) < 1e-8


main()
