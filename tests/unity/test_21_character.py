"""Application 21 in the player: a game asks what it likes, and to walk away is a distance."""

import re

from tests.lessons.test_21_talking_character import KEY, PROMPT, small_talk


def test_a_game_asks_what_it_likes_and_to_walk_away_is_a_distance(serve, play):
    """Its next question ends the one before. tests/unity/play/Visitor.cs asks."""
    server, endpoint = serve(KEY, "--delay", "0.2")
    player = play("play", "Visitor", endpoint, "1")
    player.wait_for("^ended ")
    questions = ["What is your name?", "Who are you?", PROMPT]
    assert player.lines[:2] == ["playing", "comes near"]
    said = [line for line in player.lines if line.startswith("asking")]
    assert said == [f"asking {endpoint}: {it}" for it in questions]
    heard = [line.removeprefix("heard ") for line in player.lines if line.startswith("heard ")]
    for question, text in zip(questions, heard, strict=False):
        assert small_talk.reply(question, 0).startswith(text)
    assert "she: Mind the third plank!" in player.lines
    # Those that another question has broken off have no end of their own.
    done, ended = [line for line in player.lines if re.match("done|ended", line)]
    assert re.match(r"done: (\d+) words, and you walked away$", done)
    assert small_talk.reply(PROMPT, 0).startswith(ended.removeprefix("ended "))
    jobs = [begun[1] for line in server.lines if (begun := re.match(r"(job \w+): talk from 0", line))]
    assert len(jobs) == 3
    for job in jobs:
        server.wait_for(f"{job}: canceled at")
