"""Every C# class says in one line which value it cannot use (checks/RuleChecks.cs)."""

from kitlib.setup import dotnet
from tests.programs import ROOT


def test_csharp_classes_name_what_they_cannot_use(netmq, start):
    program = start("dotnet", dotnet.build(netmq, ROOT / "tests" / "lessons" / "checks"), "rules")
    assert program.wait() == 0, program.output
    assert [line for line in program.lines if not line.endswith(": refused")] == []
    assert len(program.lines) > 200
