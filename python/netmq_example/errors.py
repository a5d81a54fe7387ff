"""The errors of the other side or the network. A wrong argument stays a ValueError or a TypeError.

    Error
      Timeout         is a TimeoutError       nothing came in time; it may have been done
      Refused         code, text, id          the other side answered with an error
      MessageError    is a ValueError         bytes, or a Message, that break the standard on this side
      Closed                                  closed meanwhile, by this program
      Lost            is a ConnectionError    the other side was there and is gone
      ListenError     is an OSError           a server cannot have its port

All of them can be pickled. A program that ends by one prints its text, and its exit code is 1.
"""


class Error(Exception):
    """An error of the other side or the network; its text names cause and cure."""


# Its name in version 0.3, which ends with the next one.
GaveUp = Error


class Timeout(Error, TimeoutError):
    """Nothing came in time. The request may have been carried out or not."""


class Closed(Error):
    """This program closed or stopped it meanwhile."""


class Lost(Error, ConnectionError):
    """The other side was there and is gone."""


class ListenError(Error, OSError):
    """A server cannot listen where it should: most often another one has the port."""

    # An OSError's own text begins with its number.
    def __str__(self) -> str:
        return str(self.strerror)


class Coded(Error):
    """An error with a code for programs, a text for people, and the id of a message, 0 where it has none."""

    def __init__(self, code: str, text: str = "", id: int = 0) -> None:
        whole = f"{code}: {text}" if text else str(code)
        if not text:
            # Pickle and AsyncVectorEnv, which bring an error from another process, have one argument for it.
            code, _, text = whole.partition(": ")
            if text and " " in code:
                # It is a sentence, and has no code of its own.
                code, text = "error", whole
        super().__init__(whole)
        self.code, self.text, self.id = code, text, id


class Refused(Coded):
    """The other side answered with an error: its `code`, its `text`, and the `id` of the request."""


class MessageError(Coded, ValueError):
    """Bytes or a Message that break the standard: a `code`, a `text`, and the message's `id` where it has one."""


class Misfit(KeyError):
    """A request or a reply is not what was agreed: one line for both sides, and no traceback."""

    # A KeyError's own shows its argument between quotation marks.
    __str__ = Exception.__str__
