"""Lesson 11, a locator's canonical text: what Python and C# take it for.

    python python/11_observations/locator.py ".speed" --scope "car@.body"         prints: @car@.body.speed

How a locator is read: netmq_example/locator.py.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from netmq_example.locator import main

if __name__ == "__main__":
    main()
