"""A package that is missing is named with its cure."""

import importlib

import pytest

from netmq_example.extras import importing, without


def needed(module):
    try:
        importlib.import_module(module)
    except ImportError as error:
        raise without(error) from None


def test_a_package_that_is_there_and_broken_is_not_to_be_installed(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "brokenpackage.py").write_text("raise ImportError('another ABI: see its page')")
    with pytest.raises(ImportError, match=r"^another ABI: see its page$"):
        needed("brokenpackage")
    with pytest.raises(ImportError, match=r"pip install nosuchpackage$"):
        needed("nosuchpackage.part")
    with pytest.raises(SystemExit, match=r"^another ABI: see its page: this lesson needs it$"), importing("it"):
        needed("brokenpackage")
