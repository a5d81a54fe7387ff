"""Application 21, the client in Python: it prints the same lines as the one in C#.

    python python/21_talking_character/client.py                            a line for each sentence, which grows
    python python/21_talking_character/client.py --prompt "Who are you?"
    python python/21_talking_character/client.py --leave-after 5            walks away when 5 words were said

The bytes are in server.py.
"""

import logging
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from speech import Speech, a_prompt, ask

from netmq_example.asking import at_least_one, client_options
from netmq_example.jobs.client import JobClient
from netmq_example.program import option, printable, run, whole


def main() -> None:
    parser = client_options("Talks to a character, and may walk away.", "tcp://127.0.0.1:5571", timeout=1, beacon=True)
    prompt = "Who built this bridge?"
    parser.add_argument("--prompt", type=lambda text: option(a_prompt, text, str), default=prompt, help="what you say")
    parser.add_argument("--count", type=at_least_one, default=200, help="how many words to listen to at most")
    parser.add_argument("--leave-after", type=whole, default=0, metavar="N", help="walk away when N words were said")
    parser.add_argument("--tries", type=at_least_one, default=5, help="how often to connect anew before giving up")
    options = parser.parse_args()
    limits = {"timeout": options.timeout, "tries": options.tries}
    with Speech() as speech, JobClient(options.endpoint, **limits) as client:
        logging.getLogger("netmq_example.client").addFilter(speech.make_way)
        print(f"asking {options.endpoint}: {printable(options.prompt)}", flush=True)
        # Each news has all that was said so far, so that one that is lost loses no word.
        for news in client.watch(ask(client, options.prompt, options.count)):
            speech.hear(news)
            if news.kind == "feedback" and 0 < options.leave_after <= speech.words:
                client.cancel()
        speech.say(speech.outcome(news))


if __name__ == "__main__":
    run(main, stopped="stopped")
