"""The scene's clock in C#: the golden bytes that test_13_scene_clock_bytes.py has for Python."""

from __future__ import annotations

import json
import subprocess

from tests.programs import LIMIT, ROOT

GOLDEN = {
    entry["name"]: entry["frame"]
    for entry in json.loads((ROOT / "tests" / "lessons" / "golden" / "09_scene_clock.json").read_text(encoding="utf-8"))
}
ASKS = [frame for frame in GOLDEN.values() if frame.startswith("03")]
# A request's id, its clock, whether all begin anew, the exchange and each row.
READ = [
    "1 True True  ",
    "2 True True 746f6c64 ",
    "3 True False  0:Step:0000003f000000c00200000001000000 0:Step:000000000000803f0000000000000000",
    "4 True False  ",
]
# All begin anew by Python's clock, or with actions; nobody steps by Python's clock; a bit that is none.
WRONG = [
    f"03{bits:02x}{count:02x}0000000000010000000000000000000000000000".ljust(48, "0")
    for bits, count in ((0x10, 0), (0x14, 1), (0x00, 0), (0x24, 0))
]


def test_csharp_writes_and_reads_the_golden_bytes(harness):
    cut = [frame[:end] for frame in ASKS for end in range(2, len(frame), 2)]
    lines = [*ASKS, *WRONG, *cut]
    done = subprocess.run(
        ["dotnet", harness, "frames"], input="\n".join(lines), capture_output=True, text=True, timeout=LIMIT
    )
    assert done.returncode == 0, done.stderr
    answers = [frame for frame in GOLDEN.values() if frame.startswith("04")]
    said = done.stdout.splitlines()
    assert said[: len(answers)] == answers
    assert [line.rstrip() for line in said[len(answers) :][: len(ASKS)]] == [line.rstrip() for line in READ]
    assert set(said[len(answers) + len(ASKS) :]) == {"bad-record"}
