"""Runs the performance lab, the folder lab/."""

import argparse
import sys

from kitlib.programs import run_in_terminal

ABOUT = "Measures the kit beside raw TCP, WebSocket, HTTP, gRPC and others, in rounds that take turns."
EXAMPLES = [
    "bench --quick   less than a minute, to see that it works",
    "bench           less than ten minutes; writes lab/performance.json and its plots, and wants a machine at rest",
    "bench --free    without a half of the processor cores for each side",
]


def add_options(parser: argparse.ArgumentParser) -> None:
    elsewhere = "results go into .build/bench"
    parser.add_argument("--quick", action="store_true", help=f"fewer and shorter rounds; {elsewhere}")
    parser.add_argument("--free", action="store_true", help=f"the system places the programs; {elsewhere}")


def do(options: argparse.Namespace) -> int:
    words = [f"--{name}" for name in ("quick", "free") if getattr(options, name)]
    return run_in_terminal([sys.executable, "-m", "lab.bench", *words])
