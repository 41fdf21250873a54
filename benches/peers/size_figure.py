"""Draws cost against size, and error against run time at one size, from sizes.csv: size_figure.py [FOLDER]

Writes peers-sizes.svg to the folder, by default docs/images, and prints the slopes of the costs.
"""
import csv, math, os, sys
import matplotlib
matplotlib.use('svg')
import matplotlib.pyplot as plt
from matplotlib.ticker import LogLocator
from figure import PEERS
from sizes import END, FOR_ERRORS

HERE = os.path.dirname(os.path.abspath(__file__))
TITLES = dict(chain='Chain of links in relative angles', four_bars='Coupled four-bars')
STYLES = {'qrm': ('#d55e00', 'o'), 'Pinocchio': ('#b39bc8', 's'), 'MuJoCo': ('#8fb3d1', '^'),
          'Exudyn': (PEERS['Exudyn'][0], 'h')}


def style(tool, what):
    colour, marker = STYLES[tool]
    is_ours = tool == 'qrm'
    return dict(color=colour, marker=marker, linewidth=2.0 if is_ours else 1.0, markersize=4, zorder=3 if is_ours else 2,
                linestyle='-' if what == 'step' else ':')


def main(folder):
    with open(os.path.join(HERE, 'sizes.csv'), newline='') as file:
        rows = list(csv.DictReader(file))
    figure, axes = plt.subplots(2, 2, figsize=(8, 6.6))
    handles = {}
    for column, kind in enumerate(TITLES):
        own = [row for row in rows if row['mechanism'] == kind]
        usual = {row['step'] for row in own if int(row['size']) != FOR_ERRORS[kind]}
        curves = {}
        for row in own:
            if row['step'] in usual:
                key = (row['tool'], row['method'], row['what'])
                curves.setdefault(key, []).append((int(row['size']), float(row['microseconds'])))
        axis = axes[0][column]
        for (tool, method, what), points in curves.items():
            name = f'{tool}, {what}' if what == 'evaluation' else f'{tool}, step of {method}'
            handles[name], = axis.plot(*zip(*points), label=name, **style(tool, what))
            (n0, t0), (n1, t1) = points[max(0, len(points) - 4)], points[-1]
            print(f'{kind:10} {name:34} slope from {n0} to {n1}: {math.log(t1 / t0) / math.log(n1 / n0):.2f}')
        axis.set(xscale='log', yscale='log', title=TITLES[kind], xlabel='links' if kind == 'chain' else 'four-bars')
        sizes = sorted({int(row['size']) for row in own})
        axis.set_xticks(sizes, [str(size) for size in sizes])
        axis = axes[1][column]
        for tool in STYLES:
            steps = [row for row in own if row['tool'] == tool and row['error'] and int(row['size']) == FOR_ERRORS[kind]]
            points = [(float(row['error']), float(row['microseconds']) * END[kind] / float(row['step'])) for row in steps]
            if points:
                axis.plot(*zip(*points), **style(tool, 'step'))
        what = 'links' if kind == 'chain' else 'four-bars'
        axis.set(xscale='log', yscale='log', title=f'{FOR_ERRORS[kind]} {what}, {END[kind]:g} s',
                 xlabel='largest error of an angle at the end (rad)')
        axis.invert_xaxis()
        axis.xaxis.set_major_locator(LogLocator(numticks=5))
    for axis in axes.flat:
        axis.grid(True, which='major', color='#e4e4e4', linewidth=0.6)
        axis.minorticks_off()
    axes[0][0].set_ylabel('microseconds')
    axes[1][0].set_ylabel('microseconds of the whole run')
    figure.legend(handles.values(), handles, loc='lower center', ncol=3, frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.1, 1, 1))
    figure.savefig(os.path.join(folder, 'peers-sizes.svg'), metadata={'Date': None, 'Creator': None}, facecolor='white')


if __name__ == '__main__':
    plt.rcParams.update({'svg.hashsalt': 'peers', 'svg.fonttype': 'none', 'font.size': 9, 'font.family': 'sans-serif'})
    main(sys.argv[1] if len(sys.argv) > 1 else os.path.join(HERE, '../../docs/images'))
