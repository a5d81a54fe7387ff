"""The scenes of the pages of lessons 09 and 10 and of reinforcement learning, as they stand there: what is written in
C# and in Python is the same to the last bit.
"""

from __future__ import annotations

import contextlib
import re
import sys
import time
from pathlib import Path

import pytest

from kitlib.docs import guide
from tests.conftest import PYTHON
from tests.programs import ROOT, elsewhere, finished, steady_endpoint

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402

from netmq_example.envs import UnityParallelEnv  # noqa: E402
from netmq_example.messages import MessageError  # noqa: E402

# One worker builds a scene once, and takes what it has built.
pytestmark = [pytest.mark.xdist_group("scenes"), pytest.mark.timeout(1200)]
PAGES = {name: [*guide.blocks(ROOT / "docs" / "guide" / f"{name}.md")] for name in (
    "09_environment", "10_many_agents", "reinforcement_learning"
)}  # fmt: skip
INSTALLED = {"PYTHONPATH": str(ROOT / "python")}
UNITY = "NetMQExample/Unity-v0"


def of_the_page(page, language, word):
    """The page's block in this language in which the word stands."""
    (body,) = [block.body for block in PAGES[page] if (block.language, word in block.body) == (language, True)]
    return body


BALL = of_the_page("09_environment", "csharp", "class Ball ")
BALL_SCENE = of_the_page("09_environment", "python", "class Ball(")
BALL_PROGRAM = of_the_page("09_environment", "python", "the ball is at")
HOVER_SCENE = of_the_page("reinforcement_learning", "python", "class Hover(")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A reader's, with the scenes; what is launched there finds the package as if it was installed."""
    monkeypatch.setenv("PYTHONPATH", INSTALLED["PYTHONPATH"])
    for page in PAGES.values():
        for block in page:
            name = re.search(r"^public sealed class (\w+)", block.body, re.MULTILINE)
            if name and block.language == "csharp":
                (tmp_path / f"{name[1]}.cs").write_text(block.body, encoding="utf-8")
    (tmp_path / "ball_scene.py").write_text(BALL_SCENE, encoding="utf-8")
    (tmp_path / "hover_scene.py").write_text(HOVER_SCENE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def played(name, *files):
    """Programs that launch them in the player."""
    words = [sys.executable, str(ROOT / "kit.py"), "play", *(f"{file}.cs" for file in files)]
    return [*words, "--add", "GymManager", "--envName", name]


def test_the_ball_is_where_the_page_says_in_both_languages(folder, netmq, console):
    (line,) = re.findall("^launch = .*$", BALL_PROGRAM, re.MULTILINE)
    here = BALL_PROGRAM.replace(line, 'launch = [sys.executable, "ball_scene.py"]')
    said = [finished([PYTHON, "-c", elsewhere(program)], timeout=500) for program in (here, BALL_PROGRAM)]
    found = [re.findall(r"^the ball is at -?0\.\d\d$", one.stdout, re.MULTILINE) for one in said]
    assert len(found[0]) == 1 and found[0] == found[1], said


def test_what_goes_wrong_in_the_ball_is_named_and_it_goes_on(folder, netmq, console, start):
    """Also: it has no Heuristic, so by hand nothing is pressed, which for its action is to the left until it is out."""
    script = BALL
    for old, new in (
        (
            "=> seen.Add(place, speed);",
            "{ if (place < -5) seen.Add(place); else if (place < 5) seen.Add(place, speed); }",
        ),
        ("        AddReward(", '        Info["frame"] = UnityEngine.Time.frameCount;\n        AddReward('),
        (
            "    public override void OnTick(double dt) => place += speed * dt;",
            "    public override void OnTick(double dt)\n    {\n"
            '        if (place > 4 && speed > 0) throw new ArithmeticException("my mistake");\n'
            "        place += speed * dt;\n    }",
        ),
        ("=> (place, speed) = (Rng.Next() - 0.5, 0);", """
    {
        (place, speed) = (Rng.Next() - 0.5, 0);
        if (Options.TryGetValue("place", out var given)) place = Convert.ToDouble(given);
    }"""),
    ):  # fmt: skip
        assert script.count(old) == 1, old
        script = script.replace(old, new)
    (folder / "Ball.cs").write_text(script, encoding="utf-8")
    words = played("Ball", "Ball")
    alone = start(*words, "--byHand", "true", "--seconds", "60", folder=folder)
    alone.wait_for(r"^by hand: .*return -\d+\.\d$")
    alone.stop()
    endpoint = steady_endpoint()
    player = start(*words, "--endpoint", endpoint, "--timeout", "200", folder=folder)
    env = gymnasium.make(UNITY, env_name="Ball", endpoint=endpoint, wait=500)
    env.reset(options={"place": 4.5})
    for wrong, text in (
        (lambda: env.step(2), "^error-in-simulation: ArithmeticException: my mistake$"),
        (lambda: env.reset(options={"place": 6}), r"^not-in-space: 0 numbers of 2 .*is not in Box\("),
        (lambda: env.reset(options={"place": -6}), r"^not-in-space: 1 numbers of 2 .*is not in Box\("),
    ):
        with pytest.raises(MessageError, match=text):
            wrong()
    assert env.reset(options={"place": 3})[0] == pytest.approx([3, 0])
    # Through several frames.
    assert {env.step(1)[1] for _ in range(200)} == {-3}
    # A policy of 3 ms is waited for, and makes more than one step in a frame. A busy machine gets five tries.
    assert any(frames_of_steps(env, 200) < 160 for _ in range(5))
    env.close()
    player.wait()
    assert "ArithmeticException: my mistake" in player.output and "Ball.OnTick" in player.output
    assert "NullReference" not in player.output and "by hand" not in player.output


def frames_of_steps(env, count):
    """Of a policy that thinks."""
    frames = set()
    for _ in range(count):
        time.sleep(0.003)
        frames.add(env.step(1)[4]["frame"])
    return len(frames)


@pytest.fixture
def registered():
    """My/Ball-v0, as the page does it."""
    exec(of_the_page("10_many_agents", "python", "My/Ball-v0"), {"gymnasium": gymnasium})
    yield
    del gymnasium.registry["My/Ball-v0"]


def test_an_id_of_ones_own_is_registered_as_the_page_does_it(registered, folder):
    launch = [sys.executable, "ball_scene.py"]
    env = gymnasium.make("My/Ball-v0", launch=launch)
    envs = gymnasium.make_vec("My/Ball-v0", num_envs=1, launch=launch)
    try:
        assert np.array_equal(env.reset(seed=3)[0], envs.reset(seed=3)[0][0])
    finally:
        env.close()
        envs.close()


def test_sixteen_drones_fly_alike_in_both_languages(folder, netmq, console):
    """Sixteen, not seventeen; and one connection for all."""
    words = {"env_name": "Hover", "max_episode_steps": 40, "wait": 500, "autoreset_mode": "SameStep"}
    both = [
        gymnasium.make_vec(UNITY, 16, launch=launch, **words)
        for launch in ([sys.executable, "hover_scene.py"], [*played("Hover", "Hover", "HoverCopies"), "--dt", "0.02"])
    ]
    random = np.random.default_rng(1)
    try:
        assert data_equivalence(*(envs.reset(seed=1) for envs in both))
        for _ in range(100):
            action = random.uniform(-1, 1, (16, 1)).astype(np.float32)
            assert data_equivalence(*(envs.step(action) for envs in both))
    finally:
        for envs in both:
            envs.close()


def test_the_pages_game_ends_with_its_mouse_or_its_time(folder, netmq, console):
    player = [sys.executable, str(ROOT / "kit.py"), "play", "Tag.cs"]
    with contextlib.closing(UnityParallelEnv("Tag", launch=player, wait=500)) as env:
        assert env.possible_agents == ["cat", "mouse"]
        # Both to the right, where the wall is: the cat begins at the other one, and is faster. Then it stays there.
        for cat, ends in (
            (2, ({"cat": 1, "mouse": -1}, True, False, 33)),
            (1, ({"cat": 0, "mouse": 0}, False, True, 100)),
        ):
            env.reset(seed=1)
            steps = 0
            while env.agents:
                steps += 1
                seen, rewards, terminated, truncated, _ = env.step({"cat": cat, "mouse": 2})
            assert (rewards, terminated["cat"], truncated["mouse"], steps) == ends
            assert seen["mouse"].tolist() == seen["cat"].tolist()[::-1] == [5, pytest.approx(4.9 if cat == 2 else -5)]


def test_robots_find_what_they_see(folder, start, netmq, console):
    pytest.importorskip("PIL", reason="the robots see pictures: kit.py run 12 installs Pillow")
    page = (ROOT / "docs" / "guide" / "10_many_agents.md").read_text(encoding="utf-8")
    # The copies of the drones, changed as the page says.
    copies = (folder / "HoverCopies.cs").read_text(encoding="utf-8")
    (changes,) = re.findall("SeekerCopies.cs` is (.*?)\\.\n", page, re.DOTALL)
    for new, old in re.findall("`([^`]*)` in place of `([^`]*)`", changes):
        assert old in copies
        copies = copies.replace(old, new)
    (folder / "SeekerCopies.cs").write_text(copies, encoding="utf-8")
    script = (Path(__file__).parents[1] / "lessons" / "seek.py").read_text(encoding="utf-8")
    (folder / "seek.py").write_text(elsewhere(script), encoding="utf-8")
    seek = start(PYTHON, "seek.py", folder=folder)
    assert seek.wait(300) == 0, seek.output
    assert "50 balls were found" in seek.lines
    assert (folder / "sixteen.gif").read_bytes()[:6] == b"GIF89a"
