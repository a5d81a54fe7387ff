"""Runs the performance lab, the folder lab/."""

import argparse
import sys

from kitlib.programs import run_in_terminal

ABOUT = "Measures the kit beside raw TCP, WebSocket, HTTP, gRPC and others, in rounds that take turns."
EXAMPLES = [
    "bench --quick   less than a minute, to see that it works",
    "bench           less than ten minutes; writes lab/performance.json and its plots, and wants a machine at rest",
]


def add_options(parser: argparse.ArgumentParser) -> None:
    help = "fewer and shorter rounds; results go into .build/bench"
    parser.add_argument("--quick", action="store_true", help=help)


def do(options: argparse.Namespace) -> int:
    words = ["--quick"] if options.quick else []
    return run_in_terminal([sys.executable, "-m", "lab.bench", *words])
