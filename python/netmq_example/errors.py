"""What is raised when something will not be done, though nobody waited too long for it: that is a TimeoutError."""


class GaveUp(Exception):
    """It was refused or aborted, and the text says by whom and why. A program prints it and ends with code 1."""


def tried(count: int) -> str:
    """How often, in words."""
    return "1 try" if count == 1 else f"{count} tries"
