"""Every C# class says in one line which value it cannot use (checks/RuleChecks.cs)."""


def test_csharp_classes_name_what_they_cannot_use(checks, start):
    program = start("dotnet", checks, "rules")
    assert program.wait() == 0, program.output
    assert [line for line in program.lines if not line.endswith(": refused")] == []
    assert len(program.lines) > 200
