"""Threads beside a run, and Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest


def test_other_threads_go_on_during_a_run(quick_return):
    ticks = []
    is_over = threading.Event()

    def tick():
        while not is_over.wait(0.001):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.perf_counter()
    quick_return.run(end_time=200, estimate_error=False)
    ended = time.perf_counter()
    is_over.set()
    thread.join()
    during = [t for t in ticks if begun < t < ended]
    assert ended - begun > 0.02
    assert len(during) > 5, f"{len(during)} ticks in {ended - begun} s"


def test_threads_share_a_mechanism(quick_return):
    expected = quick_return.run(end_time=0.5)
    results = [None] * 4

    def run(place):
        results[place] = [quick_return.run(end_time=0.5) for _ in range(20)]

    threads = [threading.Thread(target=run, args=(place,)) for place in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert all(np.array_equal(result.array, expected.array) for own in results for result in own)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize(
    "work",
    [
        "m.run(end_time=1e6, estimate_error=False, every=10**9)",
        "m.run(method='dop853', end_time=1e6, estimate_error=False, every=10**9)",
        "m.sweep(O2A=__import__('numpy').linspace(0.15, 0.25, 10**7))",
        "m.sensitivity(end_time=1e5, check=False)",
        "m.accuracy(budget=100)",
    ],
)
def test_ctrl_c_ends_what_is_computed(work):
    program = f"""
import qrm, time
m = qrm.load("quick-return")
print("begun", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", m.run(end_time=0.01).summary["status"], flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    time.sleep(0.5)
    assert process.poll() is None, "it ended too early"
    begun = time.perf_counter()
    os.kill(process.pid, signal.SIGINT)
    try:
        rest, _ = process.communicate(timeout=20)
    finally:
        process.kill()
    assert rest == "interrupted completed\n"
    assert time.perf_counter() - begun < 5


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_a_handler_of_signals_may_run_a_mechanism(quick_return):
    results = []

    def handle(*_):
        results.append(quick_return.run(end_time=0.01))

    before = signal.signal(signal.SIGALRM, handle)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        result = quick_return.run(end_time=2000, estimate_error=False, every=10**6)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert result.summary["status"] == results[0].summary["status"] == "completed"
