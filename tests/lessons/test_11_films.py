"""Lesson 11, films: render modes, views and the calls that a script of gymize makes, of each environment.

Known defects of gymize that are tests here: a video that could not be encoded was None, without a word; a folder
`tmp` beside the video was deleted; waiting for several views gave {}, or some of them.
"""

from __future__ import annotations

import errno
import importlib.util
import os
import sys
import threading
import warnings
from typing import Annotated

import pytest

from tests.programs import ROOT, steady_endpoint

gymnasium = pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
np = pytest.importorskip("numpy", reason="lesson 11 needs numpy: kit.py run 11 installs it")
pytest.importorskip("pettingzoo", reason="lesson 11 needs pettingzoo: kit.py run 10 installs it")

from netmq_example.envs import UnityAECEnv, UnityGymEnv, UnityParallelEnv, UnityVectorEnv, views  # noqa: E402
from netmq_example.scene import Agent, Obs, Scene, SceneSimulator  # noqa: E402
from tests.lessons.test_12_films import Game  # noqa: E402
from tests.lessons.test_12_video import shown  # noqa: E402

UNITY = "NetMQExample/Unity-v0"
SEEN = gymnasium.spaces.Dict(steps=gymnasium.spaces.Discrete(100))
DONE = gymnasium.spaces.Discrete(2)
ONE = {"observation_space": SEEN, "action_space": DONE}
MANY = {"observation_spaces": {"agent": SEEN}, "action_spaces": {"agent": DONE}}


# A game in the player


def place(picture):
    """Where the cube is: the middle of the columns in which something else than the first pixel's colour is."""
    return np.flatnonzero((picture != picture[0, 0]).any(axis=(0, 2))).mean()


@pytest.fixture
def words(netmq, console):
    """The words for tests/lessons/checks/Looker.cs and a recorder in the player."""
    kit = ROOT / "unity/Assets/NetMQExample"
    files = [kit / "09_environment/GymManager.cs", kit / "12_video/ViewRecorder.cs"]
    words = [sys.executable, ROOT / "kit.py", "play", ROOT / "tests/lessons/checks/Looker.cs", *files]
    return [*map(str, words), "--envName", "Look"]


def test_a_script_of_gymize_films_a_game_and_its_play_ends_with_it(words, start, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    endpoint, views = steady_endpoint(), steady_endpoint()
    words += ["--GymManager.endpoint", endpoint, "--ViewRecorder.endpoint", views]
    player = start(*words)
    where = {"env_name": "Look", "endpoint": endpoint, "view_endpoint": views, "wait": 300}
    with gymnasium.make(UNITY, render_mode="video", views=["", "front"], **where, **ONE) as env:
        env.reset()
        env.unwrapped.begin_render(-1, -1, False)
        for _ in range(6):
            env.step(1)
        env.unwrapped.end_render()
        env.step(1)
        films = env.unwrapped.render_all({"": "all.gif", "front": "front.gif"})
        assert env.render()[4:8] == b"ftyp"
    assert films == {"": str(tmp_path / "all.gif"), "front": str(tmp_path / "front.gif")}
    for path in films.values():
        pictures, times = shown(path)
        assert times == [20] * 7, "a tick is 0.02 s"
        assert pictures[0].shape == (240, 320, 3)
        places = [place(picture) for picture in pictures]
        assert sorted(set(places)) == places, "to the right with each step"
    assert len(list(tmp_path.iterdir())) == 2, "nothing else is left"
    assert player.wait() == 0
    assert "trouble" not in player.output


# A game in this process


class Counter(Agent):
    steps: Annotated[int, Obs()] = 0

    def on_reset(self):
        self.steps = 0

    def on_action(self, action):
        self.steps += action


@pytest.fixture
def counter():
    return Counter()


@pytest.fixture
def show(counter):
    """show(endpoint): two views of a scene, in which each pixel is ten times the steps."""
    games = []

    def draw(width, height):
        return np.full((height, width, 3), 10 * counter.steps, np.uint8)

    def show(endpoint):
        games.append(Game(endpoint, {"map": (32, 24), "front": (32, 24)}, draw))
        return games[-1]

    yield show
    for game in games:
        game.end()


@pytest.fixture
def make(counter, show, inside, make):
    socket = inside(SceneSimulator(Scene("Count", [counter], 0.1))).socket

    def made(kind=UnityGymEnv, shows=True, **words):
        endpoint = steady_endpoint()
        where = {"env_name": "Count", "socket": socket, "view_endpoint": endpoint}
        env = make(kind, **{**where, **(ONE if kind in (UnityGymEnv, UnityVectorEnv) else MANY), **words})
        if shows:
            show(endpoint)
        return env

    return made


def steps_of(pictures):
    return [int(picture[0, 0, 0]) // 10 for picture in pictures]


def test_a_picture_is_of_now_as_gymnasiums_wrappers_want_it(make):
    env = make(render_mode="rgb_array", views=["front", ""])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.wrappers.PassiveEnvChecker(gymnasium.wrappers.OrderEnforcing(env))
        env.reset()
        for step in range(3):
            assert env.render().shape == (24, 32, 3)
            assert steps_of([env.render()]) == [step]
            env.step(1)
    env.unwrapped.begin_render(16, 12)
    sizes = {view: seen.shape for view, seen in env.unwrapped.render_all().items()}
    assert sizes == {"front": (12, 16, 3), "": (12, 16, 3)}
    env.unwrapped.end_render()
    assert steps_of([env.render()]) == [3]


@pytest.mark.parametrize("kind", [UnityGymEnv, UnityVectorEnv, UnityParallelEnv])
def test_what_the_scene_draws_itself_is_its_picture_and_needs_no_view(kind, counter, make, monkeypatch):
    """Not even Pillow, nor the port for views: libraries always ask for rgb_array."""
    env = make(kind, shows=False, render_mode="rgb_array", view_endpoint="nonsense")
    monkeypatch.setitem(sys.modules, "netmq_example.video.films", None)
    counter.render = lambda: np.full((2, 4, 3), counter.steps, np.uint8)
    env.reset()
    env.step({UnityParallelEnv: {"agent": 1}, UnityVectorEnv: [1]}.get(kind, 1))
    seen = env.render()
    if kind is UnityVectorEnv:
        (seen,) = seen
    assert seen.tolist() == [[[1] * 3] * 4] * 2
    assert env.renderer is None
    env.close()
    env.draws = False
    with pytest.raises(ValueError, match=r"^this environment is closed"):
        env.render()


def test_each_agent_of_a_vector_has_its_picture_and_who_is_away_or_draws_none_a_black_one(checks, make):
    words = ["dotnet", checks, "observations", "world", *["agent"] * 4]
    ticks = gymnasium.spaces.Dict(ticks=gymnasium.spaces.Discrete(100))
    given = {"observation_space": ticks, "action_space": gymnasium.spaces.Text(9, min_length=0)}
    env = make(
        UnityVectorEnv, env_name="World", socket=None, launch=words, num_envs=4, render_mode="rgb_array", **given
    )
    env.reset()
    env.step(("", "", "leave", ""))
    assert [(*seen.shape, seen[0, 0, 0]) for seen in env.render()] == [(2, 4, 3, light) for light in (0, 11, 0, 13)]


def test_a_list_has_each_picture_of_an_episode_or_since_it_was_begun_once(make):
    env = make(render_mode="rgb_array_list", views=["", "front"])
    for _ in range(2):
        env.reset()
        env.step(1)
    env.step(1)
    assert steps_of(env.render()) == [0, 1, 2]
    assert env.render() == []
    env.begin_render()
    env.step(1)
    env.reset()
    env.end_render()
    env.step(1)
    assert {view: steps_of(seen) for view, seen in env.render_all().items()} == {"": [2, 3, 0], "front": [2, 3, 0]}
    env.begin_render()
    env.step(1)
    env.begin_render(16)
    env.step(1)
    assert steps_of(env.render()) == [2, 3], "begun twice: that before is gone"
    assert env.render_all()["front"][0].shape == (24, 16, 3)
    env.close()
    for call in (env.render, env.render_all, env.begin_render):
        with pytest.raises(ValueError, match=r"^this environment is closed"):
            call()
    env.end_render()


@pytest.mark.parametrize("kind", [UnityGymEnv, UnityVectorEnv, UnityAECEnv])
def test_a_video_stays_until_the_next_one_and_takes_the_place_of_another_whole(kind, make, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tmp").mkdir()
    (tmp_path / "map.gif").write_bytes(b"another")
    os.link(tmp_path / "map.gif", tmp_path / "other.gif")

    def rename(*paths):
        raise OSError(errno.EXDEV, os.strerror(errno.EXDEV))

    # A file that came from another disk would be written over it, bit by bit.
    monkeypatch.setattr(os, "rename", rename)
    env = make(kind, render_mode="video", views=["", "front"], render_fps=4)
    assert env.metadata["render_fps"] == 4
    env.reset()
    with pytest.raises(ValueError, match=r"^no picture of view '' is there: call begin_render before the steps"):
        env.render()
    env.begin_render()
    for _ in range(2):
        env.step({UnityParallelEnv: {"agent": 1}, UnityVectorEnv: [1]}.get(kind, 1))
    for _ in range(2):
        assert env.render_all({"": "map.gif", "front": "front.gif"})["front"] == str(tmp_path / "front.gif")
        for name in ("map.gif", "front.gif"):
            pictures, times = shown(name)
            assert (steps_of(pictures), times) == ([0, 1, 2], [250] * 3)
    assert (tmp_path / "other.gif").read_bytes() == b"another"
    for wrong, why in (
        ({"side": None}, r"^video_paths has the view 'side', but views is \['', 'front'\]"),
        ({"": "map.avi"}, r"^'map.avi' is no film: its name must end in .mp4"),
        ({"": 1}, "^video_paths takes a path that is not empty, not 1"),
    ):
        with pytest.raises(ValueError, match=why):
            env.render_all(wrong)
    with pytest.raises(FileNotFoundError):
        env.render_all({"": "nowhere/map.gif", "front": "front.gif"})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["front.gif", "map.gif", "other.gif", "tmp"]


def test_without_av_a_video_says_so_when_it_begins(make, monkeypatch):
    env = make(render_mode="video")
    env.reset()
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == "av" else find(name, *more))
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.warns(UserWarning, match="av is not here: render_all can write a .gif, and no MP4"):
        env.begin_render()
    with pytest.raises(OSError, match=r"pip install av; or let the film end in \.gif"):
        env.render()


def test_what_cannot_be_filmed_is_named(make):
    env = make(render_mode="rgb_array", views=["", "side"])
    env.reset()
    for call in (env.begin_render, env.render):
        with pytest.raises(ValueError, match=r"^there is no view 'side'; the game has: map, front"):
            call()
    env.renderer.views = ["front"]
    with pytest.raises(ValueError, match=r"^front is at most 32 x 24: set Width and Height of its ViewRecorder, or"):
        env.begin_render(33)
    for name in ("screen_width", "screen_height"):
        for wrong in (-2, 1.5, "", None):
            with pytest.raises(ValueError, match=f"^{name} takes pixels, or 0 or -1 for as many as the game allows"):
                env.begin_render(**{name: wrong})
    with pytest.warns(UserWarning, match="fullscreen changes nothing"):
        env.begin_render(0, -1, True)
    assert env.render().shape == (24, 32, 3)


@pytest.mark.parametrize("mode", ["video", "rgb_array"])
def test_a_scene_without_a_view_says_what_to_add_and_goes_on(mode, make, monkeypatch):
    monkeypatch.setattr(views, "WAIT_SECONDS", 0.1)
    env = make(render_mode=mode, shows=False)
    env.reset()
    for call in (env.begin_render, env.render) if mode == "rgb_array" else (env.begin_render,):
        with pytest.raises(TimeoutError, match=r"^no view came to tcp://127.*: let the scene draw itself"):
            call()
    assert env.step(1)[0]["steps"] == 1


def test_a_film_goes_on_when_its_game_is_gone_and_in_the_one_that_comes_then(make, show, caplog):
    env = make(render_mode="rgb_array_list", shows=False)
    endpoint = env.renderer.films.game.endpoint
    game = show(endpoint)
    env.reset()
    env.step(1)
    game.end()
    env.step(1)
    assert steps_of(env.render()) == [0, 1, 1]
    assert caplog.text.count("; the picture before is shown once more") == 1
    # A game that is launched anew has its views a little later than its simulator.
    threading.Timer(0.3, show, [endpoint]).start()
    env.reset()
    env.step(1)
    assert steps_of(env.render()) == [0, 1]


@pytest.mark.parametrize("kind", [UnityGymEnv, UnityVectorEnv, UnityParallelEnv])
def test_without_a_render_mode_nothing_is_filmed(kind, make):
    env = make(kind, shows=False, views=["", "front"])
    env.reset()
    for call in (env.begin_render, env.render_all, env.render):
        with pytest.warns(UserWarning, match='render gives no picture: make the environment with render_mode="rgb_'):
            assert not call()
    env.end_render()


def test_without_pillow_a_render_mode_says_so(make, monkeypatch):
    monkeypatch.setitem(sys.modules, "netmq_example.video.films", None)
    with pytest.raises(ModuleNotFoundError, match=r"^render_mode needs Pillow: pip install pillow"):
        make(render_mode="video")
