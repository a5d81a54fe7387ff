"""Lesson 09, the learning curve: how long the pole stays up, generation by generation."""


def plot(means: list[float], goal: float, most: float, path: str) -> None:
    import matplotlib

    # The same picture from the same numbers: without a date, and with names that are not drawn by chance.
    matplotlib.use("svg")
    matplotlib.rcParams |= {"svg.hashsalt": "netmq-example", "svg.fonttype": "none"}
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(8.4, 3.6), layout="constrained")
    axes.plot(range(1, len(means) + 1), means, marker="o", color="#0550ae", label="mean of a generation")
    axes.axhline(goal, color="#8c959f", linestyle="--", label="good enough")
    # A little more than the most, or else its point is cut in half.
    axes.set(xlabel="generation", ylabel="steps until the pole falls", ylim=(0, 1.05 * most))
    axes.legend()
    figure.savefig(path, format="svg", metadata={"Date": None})
