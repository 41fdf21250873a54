"""The problems, in the order of the tables. A new problem is one file here and one row."""
from . import quick_return, andrews, slider_crank, n_four_bar, pendulum, double_pendulum

PROBLEMS = [quick_return, andrews, slider_crank, n_four_bar, pendulum, double_pendulum]
