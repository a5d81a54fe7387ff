"""The words that an environment takes for its simulator, and those of gymize that it does not take any more."""

# gymize's words, each with what is written today.
GYMIZES = {
    "agent_names": "several agents are the keys of observation_spaces, and a single one is agent_name",
    "update_seconds": "leave it out",
    "reward_range": "leave it out",
}


def no_others(words: dict[str, object]) -> None:
    """An environment takes no words but its own."""
    known = "where its simulator is, say endpoint, launch, wait, timeout and socket"
    cures = dict.fromkeys(GYMIZES.get(word, known) for word in words)
    if cures:
        raise TypeError(f"an environment takes no {', '.join(words)}; {'; '.join(cures)}")
