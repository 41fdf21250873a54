"""Writes exact.csv: the exact end of every problem and design, which `cargo bench --bench peers` compares with.

One row a design: problem, end time, parameters that differ from those of the scene, coordinates at the end.
"""
import csv, os
from problems import PROBLEMS

NAMES = {'quick-return': ['O2A', 'J2'], 'andrews': ['mom']}


def rows():
    for problem in PROBLEMS:
        yield problem.NAME, problem.END, '', ' '.join(map(repr, map(float, problem.EXACT)))
        for values, end in zip(problem.DESIGNS if problem.DESIGNS is not None else [], problem.EXACT_DESIGNS or []):
            changed = ' '.join(f'{name}={float(value)!r}' for name, value in zip(NAMES[problem.NAME], values))
            yield problem.NAME, problem.END, changed, ' '.join(map(repr, map(float, end)))


if __name__ == '__main__':
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'exact.csv'), 'w', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(['problem', 'end_time', 'parameters', 'coordinates'])
        writer.writerows(rows())
