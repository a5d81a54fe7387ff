"""How often something is tried, and how long each try waits."""


def tried(count: int) -> str:
    """How often, in words."""
    return "1 try" if count == 1 else f"{count} tries"


def longer(first: float, tries: int) -> float:
    """How long to wait after so many tries in vain: each time twice as long, up to 8 times the first.

    A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
    """
    return first * 2.0 ** min(tries, 3)
