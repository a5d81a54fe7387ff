"""Options and infos as bytes: what cannot be sent is refused by its name. It needs gymnasium and numpy.

data = write_dict({"level": 3}, "option")           MessageError: option 'level' cannot be sent: …
"""

from typing import Any

from netmq_example.messages import MessageError
from netmq_example.wire import trees


def write_dict(values: dict[str, Any], word: str) -> bytes:
    try:
        return trees.write(values)
    except MessageError:
        for name, value in values.items():
            try:
                trees.write({name: value})
            except MessageError as error:
                raise MessageError(error.code, f"{word} {name!a:.40} cannot be sent: {error.text}") from None
        raise
