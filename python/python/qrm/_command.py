"""The command `qrm` of the package."""

from __future__ import annotations

import signal
import sys

from . import _native


def main() -> int:
    """Runs the command with the arguments of the process; returns its exit status."""
    # As in any program, and not only where Python looks for signals. Who started it may want Ctrl-C ignored.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.command(["qrm", *sys.argv[1:]])
