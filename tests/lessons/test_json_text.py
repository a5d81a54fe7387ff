"""How deep JSON from a peer nests is looked at before it is read."""

import json
import tracemalloc

from netmq_example.json_text import shallow


def test_a_long_text_takes_little_memory_to_be_looked_at():
    text = json.dumps(["a" * 4_000_000, "\n" * 1_000_000, *[[]] * 100])
    tracemalloc.start()
    try:
        began = tracemalloc.get_traced_memory()[0]
        assert shallow(text) is text
        assert tracemalloc.get_traced_memory()[1] - began < 32_000_000
    finally:
        tracemalloc.stop()
