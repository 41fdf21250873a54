"""Measures tools on problems: measure.py OUT.csv [problem or tool ...]

Rows that OUT.csv holds already are kept where they were faster: the addresses of a process, which are random, make
the same code faster or slower by up to half, so that the fast tools are measured in several processes.
"""
import csv, importlib, math, os, sys
os.environ.update({k: '1' for k in ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'NUMBA_NUM_THREADS')})
from common import measure
from problems import PROBLEMS

# A new tool is one file in tools/ and one row here.
TOOLS = ['heyoka', 'cyrk', 'sundials', 'assimulo', 'scipy', 'exudyn']
COLUMNS = 'problem,kind,tool,version,method,options,tolerance,microseconds,spread,error,preparation_seconds'.split(',')


def digits(x):
    return f'{x:.3g}' if 1e-3 <= abs(x) < 1e5 or x == 0 else f'{x:.2e}'


def read(path):
    if not os.path.exists(path):
        return {}
    with open(path, newline='') as file:
        return {tuple(row[:7]): row for row in list(csv.reader(file))[1:]}


def write(path, rows):
    with open(path, 'w', newline='') as file:
        table = csv.writer(file, lineterminator='\n')
        table.writerow(COLUMNS)
        table.writerows(rows.values())


def main(path, chosen):
    names = [p.NAME for p in PROBLEMS]
    problems = [p for p in PROBLEMS if not set(chosen) & set(names) or p.NAME in chosen]
    tools = [importlib.import_module('tools.' + t) for t in TOOLS if not set(chosen) & set(TOOLS) or t in chosen]
    rows = read(path)
    for problem in problems:
        for tool in tools:
            for case in tool.cases(problem):
                key = [problem.NAME, case.kind, tool.NAME, tool.VERSION, case.method, case.options, f'{case.tolerance:.2g}']
                try:
                    numbers = measure(problem, case)
                except Exception as failure:  # a tool that gives up at a tolerance has no row there
                    print(*key[:6:2], key[6], repr(failure)[:100], file=sys.stderr)
                    continue
                row = key + [digits(x) for x in numbers]
                old = rows.get(tuple(key))
                if math.isfinite(numbers[2]) and (old is None or float(row[7]) < float(old[7])):
                    rows[tuple(key)] = row
                print(*row, flush=True)
        write(path, rows)


if __name__ == '__main__':
    main(sys.argv[1], sys.argv[2:])
