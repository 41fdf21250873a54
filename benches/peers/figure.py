"""Draws error against run time from peers.csv and ours.csv, and prints the times at three errors as a table.

figure.py [FOLDER] writes peers-run.svg and peers-sweep.svg to the folder, by default docs/images, and the table to
crates/cli/src/commands/report/peers.csv, for the reports of scenes.
"""
import csv, math, os, sys
import matplotlib
matplotlib.use('svg')
import matplotlib.pyplot as plt
from problems import PROBLEMS

HERE = os.path.dirname(os.path.abspath(__file__))
ERRORS = [1e-6, 1e-9, 1e-12]
TITLES = dict(run='One run', sweep='Eight designs')
# Muted colours for peers, one for each tool, and a marker for each method; strong ones for qrm.
PEERS = {
    'heyoka': ('#7a7a7a', ['o', 's', 'D']), 'CyRK': ('#8fb3d1', ['v', '^', '<']), 'SUNDIALS': ('#c9a66b', ['P', 'X']),
    'scipy': ('#b39bc8', ['1', '2', '3']), 'Assimulo': ('#9cc0a0', ['d']), 'Exudyn': ('#d3a29a', ['h', 'p', '*', 'x'])}
OURS = ['#d55e00', '#0072b2', '#000000', '#cc79a7', '#009e73', '#56b4e9']


def rows():
    table = []
    for name in 'ours.csv', 'peers.csv':
        path = os.path.join(HERE, name)
        if os.path.exists(path):
            with open(path, newline='') as file:
                table += list(csv.DictReader(file))
    return table


def label(row):
    options = row['options'] if row['tool'] == 'qrm' else 'fast' if 'fast_math' in row['options'] else ''
    return f"{row['tool']} {row['method']} {options}".rstrip()


def curves(table, kind):
    """{problem: {label: sorted [(error, microseconds)]}} with the points that no other of the same curve beats."""
    found = {}
    for row in table:
        if row['kind'] == kind:
            point = (max(float(row['error']), 1e-17), float(row['microseconds']))
            found.setdefault(row['problem'], {}).setdefault(label(row), []).append(point)
    for problem in found.values():
        for name, points in problem.items():
            best, cheapest = [], math.inf
            for error, time in sorted(points):  # from the smallest error on: a larger one must be cheaper
                if time < cheapest:
                    best.append((error, time))
                    cheapest = time
            problem[name] = best[::-1]
    return found


def at(points, error):
    """Time at an error on the line between measured points in logarithms; that of the first point where it is more
    accurate; None where the error is not reached."""
    if points and points[0][0] <= error:
        return points[0][1]
    for (e0, t0), (e1, t1) in zip(points, points[1:]):
        if e1 <= error <= e0:
            s = math.log(error / e0) / math.log(e1 / e0)
            return math.exp(math.log(t0) * (1 - s) + math.log(t1) * s)
    return None


def order(found):
    """Labels, ours first, in the order of the tables."""
    labels = list(dict.fromkeys(name for problem in found.values() for name in problem))
    return [n for n in labels if n.startswith('qrm ')] + [n for n in labels if not n.startswith('qrm ')]


def styles(labels):
    result, ours, count = {}, 0, {}
    for name in labels:
        tool = name.split()[0]
        if tool == 'qrm':
            result[name] = dict(color=OURS[ours % len(OURS)], marker='os^Dv*'[ours % 6], linewidth=2.0, markersize=4,
                                zorder=3)
            ours += 1
        else:
            colour, markers = PEERS.get(tool, ('#aaaaaa', ['.']))
            k = count[tool] = count.get(tool, -1) + 1
            result[name] = dict(color=colour, marker=markers[k % len(markers)], linewidth=1.0, markersize=4,
                                linestyle=['-', '--', ':', '-.'][k % 4], zorder=2)
    return result


def draw(found, kind, path):
    names = [p.NAME for p in PROBLEMS if p.NAME in found]
    columns = min(3, len(names))
    lines = -(-len(names) // columns)
    labels = order(found)
    style = styles(labels)
    across = 4 if columns == 3 else 3
    legend = 0.19 * -(-len(labels) // across) + 0.15
    height = 2.8 * lines + legend + 0.4
    figure, axes = plt.subplots(lines, columns, figsize=(max(3.4 * columns, 8), height), squeeze=False)
    handles = {}
    for axis, name in zip(axes.flat, names):
        for text in labels:
            if points := found[name].get(text):
                handles[text], = axis.plot(*zip(*points), label=text, **style[text])
        axis.set(xscale='log', yscale='log', title=name, xlim=(1e-1, 1e-15))
        axis.set_xticks([1e-3, 1e-6, 1e-9, 1e-12])
        axis.grid(True, which='major', color='#e4e4e4', linewidth=0.6)
        axis.minorticks_off()
    for axis in axes.flat[len(names):]:
        axis.set_visible(False)
    for axis in axes[-1]:
        axis.set_xlabel('largest error at the end (rad, m)')
    for line in axes:
        line[0].set_ylabel('microseconds' + (' per design' if kind == 'sweep' else ''))
    figure.suptitle(TITLES[kind] + ': error against time (processor time, one core; down and right is better)', fontsize=11)
    figure.legend([handles[n] for n in labels], labels, loc='lower center', ncol=across, frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, legend / height, 1, 1))
    figure.savefig(path, metadata={'Date': None, 'Creator': None}, facecolor='white')
    plt.close(figure)


def number(x):
    return '' if x is None else f'{x:.3g}' if x < 1000 else f'{x:.0f}'


def table(found, kind):
    print(f'\n{TITLES[kind]}: microseconds{" per design" if kind == "sweep" else ""} at errors of 1e-6, 1e-9, 1e-12\n')
    names = [p.NAME for p in PROBLEMS if p.NAME in found]
    print('| tool and method | ' + ' | '.join(names) + ' |')
    print('|---' * (len(names) + 1) + '|')
    for text in order(found):
        cells = []
        for name in names:
            values = [number(at(found[name].get(text, []), e)) or '-' for e in ERRORS]
            cells.append(' / '.join(values) if set(values) != {'-'} else '')
        print(f'| {text} | ' + ' | '.join(cells) + ' |')


def times(found, kind):
    """Rows of the table for reports: problem, kind, tool and method, times."""
    for name in (p.NAME for p in PROBLEMS if p.NAME in found):
        for text in order(found):
            values = [number(at(found[name].get(text, []), e)) for e in ERRORS]
            if any(values):
                yield [name, kind, text, *values]


if __name__ == '__main__':
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(HERE, '../../docs/images')
    plt.rcParams.update({'svg.hashsalt': 'peers', 'svg.fonttype': 'none', 'font.size': 9, 'font.family': 'sans-serif'})
    data = rows()
    with open(os.path.join(HERE, '../../crates/cli/src/commands/report/peers.csv'), 'w', newline='') as file:
        write = csv.writer(file, lineterminator='\n')
        write.writerow(['problem', 'kind', 'method', *(f'1e-{-math.log10(error):.0f}' for error in ERRORS)])
        for kind in TITLES:
            if found := curves(data, kind):
                draw(found, kind, os.path.join(folder, f'peers-{kind}.svg'))
                table(found, kind)
                write.writerows(times(found, kind))
