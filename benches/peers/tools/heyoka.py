"""heyoka: Taylor series of the order that the tolerance asks for, compiled by LLVM.

One run is a scalar integrator, without options and with fast_math. A sweep is a batch of eight designs, each with its
own step, without options and with force_avx512 and fast_math (the first has no effect on machines without AVX-512).
Its cache on disk is off, so that `preparation_seconds` holds a compilation.
"""
import numpy as np
import heyoka as hy
from common import Case, TOLERANCES, designs, kinds, with_functions

NAME, VERSION = 'heyoka', hy.__version__
hy.llvm_state.set_diskcache_enabled(False)

OPTIONS = dict(run=[('', {}), ('fast_math', dict(fast_math=True))],
               sweep=[('', {}), ('force_avx512, fast_math', dict(force_avx512=True, fast_math=True))])


def system(problem):
    y = hy.make_vars(*[f'y{i}' for i in range(len(problem.START))])
    f = with_functions(problem.rates, sin=hy.sin, cos=hy.cos, sqrt=hy.sqrt)
    return list(zip(y, f(y, [hy.par[i] for i in range(len(problem.PARAMETERS))])))


def prepare(problem, kind, tolerance, options):
    p, first = designs(problem, kind), getattr(problem, 'FIRST_STEP', None)
    start = np.repeat(problem.START[:, None], len(p), 1)
    if kind == 'run':
        start = start[:, 0]
        ta = hy.taylor_adaptive(system(problem), start.copy(), pars=p[0], tol=tolerance, **options)
    else:
        ta = hy.taylor_adaptive_batch(system(problem), start.copy(), pars=p.T.copy(), tol=tolerance, **options)

    def reset():
        if kind == 'run':
            ta.time = 0.0
        else:
            ta.set_time(0.0)
        ta.state[:] = start

    def go():
        if first:
            ta.step(max_delta_t=first)
        ta.propagate_until(problem.END)

    return (reset, go,
            lambda: [problem.coordinates(y, q) for y, q in zip(ta.state.reshape(len(start), -1).T, p)])


def cases(problem):
    for kind in kinds(problem):
        for text, options in OPTIONS[kind]:
            if first := getattr(problem, 'FIRST_STEP', None):
                text = ', '.join(filter(None, [text, f'first step at most {first}']))
            for tolerance in TOLERANCES[:9:2] + TOLERANCES[9:] + [2.2e-16]:
                yield Case(kind, 'Taylor batch' if kind == 'sweep' else 'Taylor', text, tolerance,
                           lambda k=kind, t=tolerance, o=options: prepare(problem, k, t, o), len(designs(problem, kind)))
