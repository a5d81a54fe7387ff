"""Three machines, which are network namespaces here."""

import contextlib
import subprocess
import uuid

# The hub's address for the simulators.
HUB = "10.217.1.1"


def run(*words):
    return subprocess.run(words, capture_output=True, text=True, timeout=20)


class Machines:
    """The hub's has a cable to that of the simulators and one to the trainer's; no other network is touched."""

    def __init__(self):
        mark = uuid.uuid4().hex[:8]
        self.names = {role: f"kit-{mark}-{role}" for role in ("hub", "simulators", "trainer")}

    def make(self):
        """Why it cannot be, if so."""
        for name in self.names.values():
            if (made := run("ip", "netns", "add", name)).returncode:
                return made.stderr
        for number, role in enumerate(("simulators", "trainer"), start=1):
            hub, name, net = self.names["hub"], self.names[role], f"10.217.{number}"
            cable = ["link", "add", f"to{number}", "type", "veth", "peer", "name", "eth0", "netns", name]
            if (made := run("ip", "-n", hub, *cable)).returncode:
                return made.stderr
            for where, address, device in ((hub, f"{net}.1/24", f"to{number}"), (name, f"{net}.2/24", "eth0")):
                run("ip", "-n", where, "addr", "add", address, "brd", f"{net}.255", "dev", device)
                run("ip", "-n", where, "link", "set", device, "up")
                run("ip", "-n", where, "link", "set", "lo", "up")
        return ""

    @contextlib.contextmanager
    def second_cable(self, simulators, trainer):
        """From the simulators', whose way out is the first, to the trainer's, with addresses such as 10.1.2.3/24."""
        here, there = self.names["simulators"], self.names["trainer"]
        made = [run("ip", "-n", here, "route", "add", "default", "via", HUB)]
        made.append(
            run("ip", "-n", here, "link", "add", "second", "type", "veth", "peer", "name", "second", "netns", there)
        )
        for where, address in ((here, simulators), (there, trainer)):
            made.append(run("ip", "-n", where, "addr", "add", address, "brd", "+", "dev", "second"))
            made.append(run("ip", "-n", where, "link", "set", "second", "up"))
        try:
            assert not any(each.returncode for each in made), made
            yield
        finally:
            run("ip", "-n", here, "link", "del", "second")
            run("ip", "-n", here, "route", "del", "default")

    def remove(self):
        # Its cables go with it.
        for name in self.names.values():
            run("ip", "netns", "del", name)

    def inside(self, role):
        return ["ip", "netns", "exec", self.names[role]]

    def cable(self, role, state):
        assert run("ip", "-n", self.names[role], "link", "set", "eth0", state).returncode == 0
