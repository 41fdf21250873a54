"""What tools share: right-hand sides for any kind of number, compilation by numba, timing."""
import functools, math, statistics, time, types
from dataclasses import dataclass
from typing import Callable
import numba
import numpy as np

TOLERANCES = [10.0**-k for k in range(3, 15)]


@dataclass
class Case:
    """One row of the table. `prepare` returns (reset, go, end): what comes before the clock, what the clock measures,
    and the coordinates at the end, one list for each design."""
    kind: str  # run or sweep
    method: str
    options: str
    tolerance: float
    prepare: Callable
    designs: int = 1


def with_functions(function, **functions):
    """The same function, and those of its module that it calls, with another sin, cos, sqrt."""
    module = dict(function.__globals__)
    module.update(functions)
    wrap = functions.get('__wrap__', lambda f: f)
    for name in function.__code__.co_names:
        inner = module.get(name)
        if isinstance(inner, types.FunctionType) and inner.__module__ == function.__module__:
            module[name] = with_functions(inner, **functions)
    return wrap(types.FunctionType(function.__code__, module, function.__name__))


jit = numba.njit(error_model='numpy')


@functools.cache
def compiled_rates(problem):
    """rates(y, p) of a problem by numba."""
    return with_functions(problem.rates, sin=math.sin, cos=math.cos, sqrt=math.sqrt, __wrap__=jit)


@functools.cache
def in_place(problem, order='t, y, out, p'):
    """A compiled function that writes the rates into `out`; `order` is the order of its arguments."""
    n, k = len(problem.START), len(problem.PARAMETERS)
    lines = [f'def f({order}):', f'    r = rates(({values("y", n)}), ({values("p", k)}))']
    lines += [f'    out[{i}] = r[{i}]' for i in range(n)]
    scope = {'rates': compiled_rates(problem)}
    exec('\n'.join(lines), scope)
    return scope['f']


def values(name, n):
    return ''.join(f'{name}[{i}], ' for i in range(n))


def exact(problem, kind):
    return np.array(problem.EXACT_DESIGNS if kind == 'sweep' else [problem.EXACT], dtype=float)


def designs(problem, kind):
    return problem.DESIGNS if kind == 'sweep' else problem.PARAMETERS[None, :]


def kinds(problem):
    return ['run'] if problem.DESIGNS is None else ['run', 'sweep']


def measure(problem, case, budget=0.4):
    """Best time in microseconds per design, its spread, the error, and the seconds of preparation."""
    start = time.process_time()
    reset, go, end = case.prepare()
    reset()
    go()
    seconds = time.process_time() - start
    times, error = [], math.nan
    while len(times) < (5 if sum(times) < 2e6 else 3) or (sum(times) < budget * 1e6 and len(times) < 40):
        reset()
        begin = time.process_time_ns()
        go()
        times.append((time.process_time_ns() - begin) * 1e-3)
    error = float(np.abs(np.array(end(), dtype=float) - exact(problem, case.kind)).max())
    q1, q2, q3 = statistics.quantiles(times, n=4)
    return min(times) / case.designs, (q3 - q1) / q2, error, max(0.0, seconds - min(times) * 1e-6)
