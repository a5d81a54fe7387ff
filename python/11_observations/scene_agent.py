"""Lesson 11, an agent of a scene: what it sees is said where it is declared. In C#: AgentState.cs, and of the
attributes.

    class Car(Agent):
        speed: Annotated[float, Obs(".speed")] = 0.0            seen under the key speed
        place: Annotated[Any, Obs()] = np.zeros(2)              without a locator the field's name is the key
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_type_hints

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "09_environment"))
from locator import parse
from mapping import APPEND, LocatorError, quoted
from simulation import draws


@dataclass(frozen=True)
class Obs:
    locator: str = ""


class Agent:
    """Your own derives from it, and has on_reset, on_action, on_tick and on_info as it needs them. Who has ended has no
    more ticks until the next reset."""

    def __init__(self, name: str = "agent") -> None:
        self.name, self.sources = name, declared(type(self), name)
        self.begin(draws(0), {})

    def begin(self, chance: Iterator[float], options: dict[str, Any]) -> None:
        self.chance, self.options = chance, options
        self.reward, self.terminated, self.truncated, self.infos = 0.0, False, False, list[Any]()

    def on_reset(self) -> None: ...
    def on_action(self, action: Any) -> None: ...
    def on_tick(self, dt: float) -> None: ...
    def on_info(self, info: Any) -> None: ...

    def observe(self) -> Iterator[tuple[str, Any]]:
        """Canonical locators, and the values that stand there now."""
        return ((text, getattr(self, field)) for text, field in self.sources)

    def take(self) -> dict[str, Any]:
        """What Python is told is told once, whatever numpy or Python made it of."""
        ends = {"terminated": bool(self.terminated), "truncated": bool(self.truncated)}
        said = {"reward": float(self.reward), **ends, "infos": self.infos}
        self.reward, self.infos = 0.0, []
        return said


def declared(kind: type, name: str) -> list[tuple[str, str]]:
    """Canonical locators, and the fields that go there; LocatorError names the field that is wrong."""
    scope, found = parse(f"{quoted(name)}@"), list[tuple[str, str]]()
    hints = get_type_hints(kind, include_extras=True)
    marks = [(field, mark) for field, hint in hints.items() for mark in getattr(hint, "__metadata__", ())]
    for field, mark in marks:
        if not isinstance(mark, Obs):
            continue
        try:
            locator = parse(mark.locator, field, scope)
        except LocatorError as error:
            raise LocatorError(f'{kind.__name__}.{field}, locator "{mark.locator}": {error}') from None
        appends = any(mapping.destination[-1:] == (APPEND,) for mapping in locator.mappings)
        if not appends and (other := next((other for text, other in found if text == locator.text), None)):
            both = " and ".join(f"{kind.__name__}.{each}" for each in (other, field))
            raise LocatorError(f"{both} go to one place: {locator.text}")
        found.append((locator.text, field))
    return found
