"""A sweep as a picture: cargo run --release --features parquet -- sweep quick-return --vary O2A=0.1:0.25:200 --out sweep.parquet && python3 examples/sweep.py"""
import json
import matplotlib.pyplot as plt
import polars as pl

designs = pl.read_parquet("sweep.parquet").filter(pl.col("status") == "done")
units = json.load(open("sweep.units.json"))
figure, axes = plt.subplots(2, 1, sharex=True, layout="constrained")
for axis, name in zip(axes, ["x6", "N3"]):
    axis.fill_between(designs["O2A"], designs[f"{name}_min"], designs[f"{name}_max"], alpha=0.3)
    axis.set_ylabel(f"{name} ({units[f'{name}_max']['unit']})")
axes[1].set_xlabel(f"{units['O2A']['doc']} ({units['O2A']['unit']})")
figure.savefig("sweep.png")
