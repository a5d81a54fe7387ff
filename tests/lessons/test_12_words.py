"""Lessons 09 to 12: what a class or a function cannot use it names in one line. By the types that it says it takes."""

import gc
import time
import types
import typing
import warnings
from collections.abc import Callable
from typing import Any, get_type_hints

import pytest

np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
pytest.importorskip("PIL", reason="lesson 12 needs Pillow: kit.py run 12 installs it")

from netmq_example.envs import UnityAECEnv, UnityGymEnv, UnityParallelEnv, UnityVectorEnv  # noqa: E402
from netmq_example.envs.connection import Connection  # noqa: E402
from netmq_example.envs.simulators import Simulators  # noqa: E402
from netmq_example.locator import parse  # noqa: E402
from netmq_example.messages import Message  # noqa: E402
from netmq_example.scene import Agent, EnvironmentClient, Obs, Scene, SceneSimulator  # noqa: E402
from netmq_example.video import film_writer  # noqa: E402
from netmq_example.video.films import Films  # noqa: E402
from netmq_example.video.view_film import ViewFilm  # noqa: E402
from netmq_example.video.view_sender import FilmView, ViewSender  # noqa: E402
from netmq_example.wire.split_mix import draws  # noqa: E402
from netmq_example.worlds.cross_entropy import play, train  # noqa: E402
from netmq_example.worlds.pursuit import Pursuit  # noqa: E402
from tests.lessons.test_10_scene_rules import OldArray  # noqa: E402

NAN, NOWHERE, PIXELS = float("nan"), "tcp://127.0.0.1:9", np.zeros((2, 2, 3), np.uint8)


ARRAY = np.array([2.0]).view(OldArray)
WRONG: dict[Any, list[Any]] = {
    str: [0, b"x"],
    int: ["3", 0.5, NAN, -2, ARRAY],
    float: ["1", NAN, -1, ARRAY],
    bool: [0, "yes"],
    Callable: [0, ""],
}


def wrong_for(hint):
    if hint in (Any, object):
        return []
    is_union = isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union
    kinds = typing.get_args(hint) if is_union else [hint]
    found = [object(), *([] if type(None) in kinds else [None])]
    return found + [value for kind in kinds for value in WRONG.get(typing.get_origin(kind) or kind, [])]


def writing(do):
    """With a film that has one picture."""
    film = film_writer.open_film(f"{time.monotonic_ns()}.gif")
    film.add(PIXELS, 0.0)
    try:
        do(film)
    finally:
        film.close(1.0)


def taking(pixels):
    """For a view that is being filmed."""
    view = FilmView("one", 2, 2)
    view.begin(Message("begin", 1, {"view": "one", "width": 2, "height": 2, "fps": 25.0}))
    view.take(view.due(), pixels)


def with_films(do):
    with Films("tcp://127.0.0.1:*") as films:
        do(films)


def of_class(kind):
    return get_type_hints(kind.__init__)


NO_SPACES: dict[str, list[Any]] = {f"{name}_spaces": [{}, {"a": 5}, {5: None}] for name in ("observation", "action")}
SOON = {"endpoint": "tcp://127.0.0.1:*", "wait": 0.1, "env_name": "A", "render_mode": "video"}
VIEWS: dict[str, list[Any]] = {
    "env_name": [""],
    "file_name": [""],
    "render_mode": ["human"],
    "views": [[], "front", [None]],
    "render_fps": [0],
    "view_endpoint": ["nonsense"],
    "fleet": [0, NOWHERE],
}
VECTOR = {**VIEWS, "num_envs": [0], "max_episode_steps": [0], "autoreset_mode": ["same"]}
PICTURES = [None, NAN, "", PIXELS[0, 0], PIXELS[:0], PIXELS / 1, PIXELS[:1]]
VIEW: dict[str, list[Any]] = {"name": ["bad/name", ""], "width": [0, 2**23]}
# What is called, its other words, and more that it cannot use; of what only those are for, there are no hints.
CALLS: list[tuple[Any, dict[str, Any], dict[str, list[Any]], dict[str, Any]]] = [
    (UnityGymEnv, SOON, VIEWS, of_class(UnityGymEnv)),
    (UnityVectorEnv, {**SOON, "num_envs": 2}, VECTOR, of_class(UnityVectorEnv)),
    (UnityParallelEnv, SOON, VIEWS | NO_SPACES, of_class(UnityParallelEnv)),
    (UnityAECEnv, {}, {"env_name": [""]}, {}),
    (Simulators, {}, {"launch": [["game", None], [""], []], "endpoint": ["here"]}, of_class(Simulators)),
    (Connection, {"socket": None, "timeout": 1}, {}, of_class(Connection)),
    (SceneSimulator, {"scene": Pursuit()}, {}, of_class(SceneSimulator)),
    (EnvironmentClient, {"endpoint": NOWHERE}, {"endpoint": ["tcp://a:0"]}, of_class(EnvironmentClient)),
    (
        EnvironmentClient(NOWHERE).run,
        {"simulator": SceneSimulator(Pursuit())},
        {},
        get_type_hints(EnvironmentClient.run),
    ),
    (Scene, {"name": "A", "agents": [Agent("a")]}, {"agents": [[5], [Agent], ""]}, of_class(Scene)),
    (Agent, {}, {"name": ["", 0]}, {}),
    (Obs, {}, {}, of_class(Obs)),
    (parse, {"text": "a@"}, {}, get_type_hints(parse)),
    (draws, {"seed": 0}, {"seed": [2**64]}, {}),
    (train, {"play_all": len, "seed": 1, "generations": 1}, {}, get_type_hints(train)),
    (play, {"env": None, "seed": 1}, {"policy": [None, "", [1, 2]]}, {}),
    (Films, {"endpoint": "tcp://127.0.0.1:*"}, {"endpoint": ["nonsense"], "timeout": [0]}, of_class(Films)),
    (
        lambda **words: with_films(lambda films: films.begin_render(**words)),
        {},
        {"view": [b"a"], "path": [0], "width": [2**70], "fps": [0, ""]},
        get_type_hints(Films.begin_render),
    ),
    (lambda seconds: with_films(lambda films: films.wait(seconds)), {}, {}, {"seconds": float}),
    (ViewFilm, {"path": None, "fps": 25}, {"view": [0, None, b"x"]}, {}),
    (FilmView, {"name": "one", "width": 8, "height": 8}, VIEW, of_class(FilmView)),
    (ViewSender, {"endpoint": NOWHERE}, {"endpoint": ["tcp://127.0.0.1:0"]}, of_class(ViewSender)),
    (
        film_writer.open_film,
        {"path": "film.gif"},
        {"path": ["", "film", "film.apng"], "fps": [0, 1001]},
        {"path": str, "fps": float},
    ),
    (lambda picture: writing(lambda film: film.add(picture, 0.1)), {}, {"picture": PICTURES}, {}),
    (lambda time: writing(lambda film: film.add(PIXELS, time)), {}, {"time": [None, NAN, ""]}, {}),
    (lambda time: writing(lambda film: film.close(time)), {}, {"time": [None, NAN, ""]}, {}),
    (taking, {}, {"pixels": PICTURES[:3] + PICTURES[-2:]}, {}),
]
# None and 0 are as good as no endpoint for views.
NOT_LOOKED_AT = ("return", "where", "unknown", "env", "view_endpoint")
# What is said in place of a name.
SAYS = {
    "view_endpoint": "bad endpoint",
    "observation_spaces": "observation_space|the name of an agent",
    "action_spaces": "action_space|the name of an agent",
    "name": "name|a view",
    "width": "width|a view",
    "height": "height|a view",
    "path": "path|no film",
    "agents": "agents|iterable",
}


@pytest.fixture(scope="module")
def tidy():
    """Garbage of tests before these is no mistake of these classes, and is not looked through again for each call."""
    with warnings.catch_warnings(action="ignore"):
        gc.collect()
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.mark.usefixtures("tidy")
@pytest.mark.parametrize(("call", "words", "more", "hints"), CALLS)
@pytest.mark.filterwarnings("error")
def test_what_cannot_be_used_is_named_in_one_line(call, words, more, hints, tmp_path, monkeypatch):
    """And what could not be made is forgotten in silence."""
    monkeypatch.chdir(tmp_path)
    hints = {name: hint for name, hint in hints.items() if name not in NOT_LOOKED_AT}
    odd = []
    for name in dict.fromkeys([*more, *hints]):
        for value in [*more.get(name, []), *wrong_for(hints.get(name, Any))]:
            try:
                call(**{**words, name: value})
                odd.append(f"{name}={value!r:.40} is accepted")
            except Exception as error:
                said = str(error)
                named = any(one in said for one in SAYS.get(name, name).split("|"))
                if not isinstance(error, (ValueError, TypeError)) or not named or "\n" in said:
                    odd.append(f"{name}={value!r:.40}: {said}")
    assert not odd, "\n".join(odd)
    gc.collect()
