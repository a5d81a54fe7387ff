"""Lesson 08, training: learns to steer from a recording, by copying the driver ("behavioural cloning").

    python python/08_see_and_steer/train.py runs/run_0001        prints how far it is, and writes steering.npz
    python python/08_see_and_steer/server.py --model steering.npz

A picture becomes a few hundred numbers, the mean colours of its parts, and steering the sum of these with a weight for
each: ridge regression (Hoerl and Kennard, 1970), which numpy solves in one line. Each picture is used twice, the second
time as in a mirror, with the steering turned round: so left bends teach right ones.
It needs numpy and Pillow.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.arguments import regular_file
from netmq_example.extras import importing
from netmq_example.program import run, whole

with importing("numpy and Pillow: pip install numpy pillow, or let kit.py run 8 do it", stopped="stopped"):
    import numpy as np
    from driver import keep_speed, main_camera

    from netmq_example.camera.recording import recorded
    from netmq_example.messages import MessageError

# The upper part of a picture is sky. The rest is cut into so many parts, with three colours each.
SKY = 0.3
ROWS = 12
COLUMNS = 32
# How much large weights are held back: without it a few pixels that happened to fit would decide.
RIDGE = 5.0
# Of the file of weights, which has 10 KB. Packed as zip packs, a larger one could become a thousand times as large.
LARGEST_BYTES = 64 * 1024


def features(picture: Any) -> Any:
    """The mean colours of a picture's parts, of any size that has enough pixels."""
    below = picture[int(picture.shape[0] * SKY) :].astype(np.float32) / 255
    if below.shape[0] < ROWS or below.shape[1] < COLUMNS:
        raise MessageError("bad-shape", f"{picture.shape[1]} x {picture.shape[0]} pixels are too few to steer by")
    rows = np.linspace(0, below.shape[0], ROWS, False).astype(int)
    columns = np.linspace(0, below.shape[1], COLUMNS, False).astype(int)
    sums = np.add.reduceat(np.add.reduceat(below, rows, 0), columns, 1)
    counts = np.diff(rows, append=below.shape[0])[:, None, None] * np.diff(columns, append=below.shape[1])[:, None]
    return sums / counts


def learn(seen: Any, steer: Any) -> Any:
    """The weights, and last what to steer when nothing is seen."""
    both = np.concatenate([seen, seen[:, :, ::-1]]).reshape(2 * len(seen), -1)
    both = np.column_stack([both, np.ones(len(both))])
    wanted = np.concatenate([steer, -steer])
    return np.linalg.solve(both.T @ both + RIDGE * np.eye(both.shape[1]), both.T @ wanted)


def steering(weights: Any, seen: Any) -> float:
    return float(np.append(seen.ravel(), 1) @ weights)


def load(path: str) -> Callable[[dict[str, Any], dict[str, Any]], tuple[float, float, float]]:
    """A driver that steers by the numbers that train.py has learned."""
    try:
        # Without pickle, which would run what is in it: numpy's own default, too.
        weights = np.load(regular_file(Path(path), LARGEST_BYTES), allow_pickle=False)["weights"]
        if weights.shape != (ROWS * COLUMNS * 3 + 1,) or not np.isfinite(weights).all():
            raise ValueError("these are no weights of this lesson")
    # numpy raises whatever it meets in a file that is not its own.
    except Exception as error:
        sys.exit(f"no model in {path}: {error!s:.80}; train.py writes one")
    return lambda pictures, told: keep_speed(told["speed"], steering(weights, features(main_camera(pictures))))


def examples(folder: Path) -> tuple[Any, Any]:
    """Pictures and their steering, by a person or in answer to this very picture."""
    seen, steer = [], []
    begin = time.monotonic()
    for row in recorded(folder):
        seen.append(features(main_camera(row.pictures)))
        steer.append(row.values["steer"] if row.values["manual"] else row.answered["steer"])
        if len(seen) % 1000 == 0:
            print(f"read {len(seen)} pictures, {time.monotonic() - begin:.0f} s", flush=True)
    print(f"read {len(seen)} pictures, {time.monotonic() - begin:.0f} s", flush=True)
    return np.array(seen), np.array(steer)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="a recorded drive, such as runs/run_0001")
    parser.add_argument("--out", type=Path, default=Path("steering.npz"), help="where to write what was learned")
    parser.add_argument("--seed", type=whole, default=0, help="chooses the pictures that are kept for the check")
    options = parser.parse_args()
    try:
        seen, steer = examples(options.recording)
    except (OSError, MessageError) as error:
        sys.exit(f"no recording in {options.recording}: {error}; server.py --record runs makes one")
    if len(seen) < 100:
        sys.exit(f"{len(seen)} pictures are too few to learn from: record a lap or more")
    # One in ten is not learned from: how far off it is there says what was learned, and not what was remembered.
    check = np.random.default_rng(options.seed).random(len(seen)) < 0.1
    weights = learn(seen[~check], steer[~check])
    off = [abs(steering(weights, picture) - wanted) for picture, wanted in zip(seen[check], steer[check], strict=True)]
    try:
        with options.out.open("wb") as file:
            np.savez(file, weights=weights)
    except OSError as error:
        sys.exit(f"cannot write {options.out}: {error.strerror}; give another file with --out")
    print(f"learned from {(~check).sum()} pictures; on {check.sum()} others its steering is off by {np.mean(off):.3f}")
    print(f"wrote {options.out}")


if __name__ == "__main__":
    run(main, stopped="stopped")
