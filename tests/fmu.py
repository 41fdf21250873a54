"""Units that `qrm export-fmu` writes, in FMPy: valid, right, and honest about what they cannot do.

    python3 tests/fmu.py target/release/qrm

needs the package fmpy from PyPI.
"""

import csv
import ctypes
import os
import subprocess
import sys
import tempfile
import zipfile

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.validation import validate_fmu

QRM = os.path.abspath(sys.argv[1])
WITHIN = 1e-9


def qrm(*arguments):
    subprocess.run([QRM, *arguments], check=True, stdout=subprocess.DEVNULL)


def exported(scene, *arguments):
    qrm("export-fmu", scene, *arguments)
    return f"out/{scene}/{scene.replace('-', '_')}.fmu"


def run(scene, *arguments):
    qrm("run", scene, "--no-figures", *arguments)
    with open(f"out/{scene}/trajectory.csv") as file:
        rows = list(csv.reader(file))
    return rows[0], np.array(rows[1:], dtype=float)


def compare(unit, scene, *arguments, start_values=(), interface="CoSimulation", within=WITHIN, **how):
    """Every column of `qrm run` against the unit's, at every row; errors relative to the largest value where that is above 1."""
    names, rows = run(scene, *arguments)
    columns = [name for name in names[1:] if not name.startswith("residual")]
    end, step = rows[-1, 0], rows[1, 0]
    result = simulate_fmu(
        unit, fmi_type=interface, stop_time=end, step_size=step, output_interval=step, output=columns,
        start_values=dict(start_values), **how,
    )
    at = np.searchsorted(rows[:, 0], result["time"] - 1e-9 * step)
    assert np.max(np.abs(rows[at, 0] - result["time"])) < 1e-9, "rows at the same times"
    assert result["time"][-1] >= end - 1e-9 and len(at) >= len(rows) - 1, (result["time"][-1], end)
    worst = 0.0
    for name in columns:
        expected = rows[:, names.index(name)]
        error = np.max(np.abs(result[name] - expected[at])) / max(1.0, np.max(np.abs(expected)))
        assert error <= within, f"{scene}: {name} is off by {error}"
        worst = max(worst, error)
    print(f"{scene} {' '.join(arguments)} {interface}: {len(columns)} columns, {len(at)} rows, within {worst:.1e}")


def check_file(unit):
    assert validate_fmu(unit) == [], validate_fmu(unit)
    folders = [os.path.expanduser("~"), os.path.dirname(os.path.dirname(os.path.dirname(QRM))), os.getcwd()]
    here = [f"{folder}/" for folder in folders] + ["/.cargo/"]
    with zipfile.ZipFile(unit) as files:
        for name in files.namelist():
            for path in here:
                assert path.encode() not in files.read(name), f"{name} holds {path}"
        assert b"\nnalgebra " in files.read("documentation/licenses/license.txt")


class Slave:
    """An instance driven by hand."""

    def __init__(self, unit, **start):
        self.description = read_model_description(unit)
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.messages = []
        self.slave = FMU3Slave(
            guid=self.description.guid, unzipDirectory=extract(unit),
            modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="slave",
        )
        self.slave.instantiate(loggingOn=True)
        for name, value in start.items():
            self.set(name, value)
        self.slave.enterInitializationMode(startTime=0.0)

    def set(self, name, value):
        self.slave.setFloat64([self.references[name]], [value])

    def get(self, name):
        return self.slave.getFloat64([self.references[name]])[0]

    def step(self, t, h):
        self.slave.doStep(currentCommunicationPoint=t, communicationStepSize=h)


def refused(work):
    try:
        work()
    except FMICallException as e:
        assert e.status == 3, e.status
        return
    raise AssertionError("that should have been refused")


def by_hand():
    unit = exported("quick-return")
    slave = Slave(unit)
    slave.slave.exitInitializationMode()
    # Steps of other lengths than the unit's own do not change its motion.
    t = 0.0
    for h in [0.0004, 0.0131, 0.2, 0.25, 0.0365]:
        slave.step(t, h)
        t += h
    names, rows = run("quick-return", "--end-time", "0.5")
    error = abs(slave.get("phi2") - rows[-1, names.index("phi2")])
    assert error < 1e-12, error
    # A state can be kept and gone back to.
    kept = slave.slave.getFMUState()
    slave.step(t, 0.1)
    later = slave.get("phi2")
    slave.slave.setFMUState(kept)
    slave.step(t, 0.1)
    assert slave.get("phi2") == later
    slave.slave.freeFMUState(kept)
    # A force can change under way; a length of a loop cannot, and the motion goes on as it was.
    t += 0.1
    before = slave.get("x6_ddot")
    refused(lambda: slave.slave.setFloat64([slave.references[n] for n in ("F6", "O2A")], [77.0, 0.25]))
    assert slave.get("F6") == 1000.0, "all or none"
    slave.set("F6", 3000.0)
    assert slave.get("F6") == 3000.0 and abs(slave.get("x6_ddot") - before) > 0.1
    refused(lambda: slave.set("O2A", 0.25))
    assert slave.get("O2A") == 0.2
    refused(lambda: slave.set("x6", 0.0))
    refused(lambda: slave.set("F6", float("nan")))
    refused(lambda: slave.set("w0", 5.0))
    for at, h in [(t - 0.3, 0.1), (t + 0.3, 0.1), (t, -0.1), (t, float("nan")), (t, float("inf")), (t, 1e300)]:
        refused(lambda: slave.step(at, h))
    refused(lambda: slave.set("m6", float("inf")))
    refused(lambda: slave.set("J2", -1e5))
    assert slave.get("J2") == 100.0
    slave.step(t, 0.1)
    assert np.isfinite(slave.get("x6"))
    slave.slave.terminate()
    refused(lambda: slave.step(t, 0.1))
    slave.slave.reset()
    slave.slave.enterInitializationMode(startTime=0.0)
    slave.slave.exitInitializationMode()
    assert slave.get("phi2") == 0.0 and slave.get("F6") == 1000.0
    slave.slave.freeInstance()
    # What cannot be assembled is said when the initialization ends.
    slave = Slave(unit, BC=0.1)
    refused(slave.slave.exitInitializationMode)
    slave.slave.freeInstance()
    # Nothing below the bound that the description states.
    bounded = {v.name: v.min for v in read_model_description(unit).modelVariables if v.min is not None}
    assert {"m4", "J2"} <= set(bounded) and "F6" not in bounded, bounded
    refused(lambda: Slave(unit, J2=-100.0))
    # Steps that do not suffice for a crank without a flywheel are not passed over.
    slave = Slave(exported("quick-return-loaded"), J2=0.0)
    slave.slave.exitInitializationMode()
    refused(lambda: [slave.step(0.01 * i, 0.01) for i in range(100)])
    slave.slave.freeInstance()
    print("by hand: states, tunable parameters, refusals")


def by_an_integrator():
    """Model exchange: the order of the states, and loops that stay closed however loose the importer's tolerance is."""
    unit = exported("pendulum")
    for tolerance, within in [(1e-4, 2e-3), (1e-6, 1e-4), (1e-8, 1e-6)]:
        result = simulate_fmu(
            unit, fmi_type="ModelExchange", solver="CVode", stop_time=100.0, step_size=0.01, output_interval=0.01,
            relative_tolerance=tolerance, output=["x", "y"],
        )
        open_by = np.max(np.abs(result["x"] ** 2 + result["y"] ** 2 - 1.0))
        assert open_by < within, (tolerance, open_by)
    unit = exported("quick-return")
    description = read_model_description(unit)
    instance = FMU3Model(
        guid=description.guid, unzipDirectory=extract(unit), instanceName="model",
        modelIdentifier=description.modelExchange.modelIdentifier,
    )
    instance.instantiate()
    instance.enterInitializationMode(startTime=0.0)
    instance.exitInitializationMode()
    derivatives = [unknown.variable for unknown in description.derivatives]
    values, slopes = (ctypes.c_double * len(derivatives))(), (ctypes.c_double * len(derivatives))()
    instance.getContinuousStates(values, len(derivatives))
    instance.getContinuousStateDerivatives(slopes, len(derivatives))
    for value, slope, derivative in zip(values, slopes, derivatives):
        assert value == instance.getFloat64([derivative.derivative.valueReference])[0], derivative.name
        assert slope == instance.getFloat64([derivative.valueReference])[0], derivative.name
    refused(lambda: instance.fmi3DoStep(instance.component, 0.0, 0.1, True, *(ctypes.byref(ctypes.c_bool()) for _ in range(3)), ctypes.byref(ctypes.c_double())))
    instance.freeInstance()
    print("by an integrator: states in their order, loops closed")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for scene in ["quick-return", "slider-crank", "quick-return-driven", "pendulum"]:
            check_file(exported(scene))
        compare(exported("quick-return"), "quick-return")
        compare(exported("slider-crank"), "slider-crank")
        compare(exported("quick-return-driven"), "quick-return-driven", "--end-time", "1")
        # Parameters, set in the tool and on the command line of either command.
        compare(exported("quick-return"), "quick-return", "--end-time", "1", "--set", "O2A=0.25", "--set", "m6=3",
                start_values=[("O2A", 0.25), ("m6", 3.0)])
        compare(exported("slider-crank", "--set", "k=2"), "slider-crank", "--set", "k=2", "--set", "c=0.5",
                start_values=[("c", 0.5)])
        tight = ["--method", "dop853", "--tolerance", "1e-13"]
        compare(exported("slider-crank", *tight), "slider-crank", *tight)
        # The importer's own method.
        compare(exported("slider-crank"), "slider-crank", *tight, interface="ModelExchange", within=1e-5,
                solver="CVode", relative_tolerance=1e-10)
        by_hand()
        by_an_integrator()
        # The same scene gives the same file.
        qrm("export-fmu", "slider-crank", "--out", "a")
        qrm("export-fmu", "slider-crank", "--out", "b")
        first, second = (open(f"{place}/slider_crank.fmu", "rb").read() for place in "ab")
        assert first == second


main()
