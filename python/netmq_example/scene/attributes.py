"""The fields of an agent that are seen, and where they go. It needs only Python."""

from dataclasses import dataclass, replace

from netmq_example.locator import APPEND, Locator, LocatorError, ordinal, parse, quoted
from netmq_example.scene.agent import Agent, Obs


@dataclass(frozen=True)
class Seen:
    field: str
    locator: Locator

    def named(self) -> set[str]:
        return {name for one in self.locator.mappings if not one.everyone for name in one.agents}

    def text_for(self, name: str) -> str:
        """The places in the observation of this agent, which is not named there: so all of a kind have one form."""
        mappings = [one for one in self.locator.mappings if one.names(name)]
        places = [replace(one, everyone=False, agents=(), root=True) for one in mappings]
        return " & ".join(sorted(map(str, places), key=ordinal))


def declared(kind: type[Agent], name: str, marks: list[tuple[str, Obs]]) -> list[Seen]:
    """LocatorError names the field that is wrong."""
    scope = parse(f"{quoted(name)}@")
    found: list[Seen] = []
    for field, mark in marks:
        try:
            locator = parse(mark.locator, field, scope)
        except LocatorError as error:
            raise LocatorError(f'{kind.__name__}.{field}, locator "{mark.locator}": {error}') from None
        appends = any(mapping.destination[-1:] == (APPEND,) for mapping in locator.mappings)
        for other in found:
            if other.locator == locator and not appends:
                both = f"{kind.__name__}.{other.field} and {kind.__name__}.{field}"
                raise LocatorError(f"{both} go to one place: {locator.text}")
        found.append(Seen(field, locator))
    return found
