"""What a release consists of, from the last commit: python3 -m kitlib.release FOLDER

It writes the sources as a zip file, and the package for Unity with NetMQ's DLLs. The version stands in pyproject.toml,
and tests compare whatever else names it. To look at before: a section of that version in CHANGELOG.md, and CI.
To look at after: unpack the zip elsewhere and run both commands of the README there.
"""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

from kitlib.lessons import ROOT, KitError
from kitlib.terminal import say
from kitlib.unity.package import write_package


def version() -> str:
    number: str = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    return number


def git(*words: str | Path) -> str:
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        raise KitError(f"git {words[0]} failed; it says: {done.stderr.strip():.200}")
    return done.stdout


def release(folder: Path) -> None:
    """Both files; a KitError says why not."""
    number = version()
    if f"\n## [{number}] - " not in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"):
        raise KitError(f"CHANGELOG.md has no section [{number}] with a date: write it first")
    if changed := git("status", "--porcelain").splitlines():
        raise KitError(f"{changed[0][3:]} is not committed: a release is what the last commit has")
    folder.mkdir(parents=True, exist_ok=True)
    sources = folder.resolve() / f"NetMQExample-{number}.zip"
    git("archive", "--format=zip", f"--prefix=NetMQExample-{number}/", f"--output={sources}", "HEAD")
    say(f"wrote {sources}")
    write_package(folder / f"NetMQExample-{number}.unitypackage", None, True, False, None)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python3 -m kitlib.release FOLDER")
    try:
        release(Path(sys.argv[1]))
    except (KitError, OSError) as error:
        sys.exit(str(error))
