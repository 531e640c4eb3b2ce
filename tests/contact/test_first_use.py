"""Kernels that another process compiles while a run goes on."""

import subprocess
import sys

import pytest

from contact import compiled_aside
from contact.answers import first_use
from contact.events import event_driven
from contact.jit import compiled, kernels


@pytest.fixture
def started(monkeypatch):
    """Give the list of processes that are started, none of which runs."""
    processes = []

    class Process:
        def __init__(self, words, **options):
            self.words, self.options, self.ended = words, options, []
            processes.append(self)

        def kill(self):
            self.ended.append("kill")

        def wait(self):
            self.ended.append("wait")

    monkeypatch.setattr(subprocess, "Popen", Process)
    monkeypatch.setattr(first_use.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(compiled, "cache_folder", lambda: "kept")
    monkeypatch.setattr(kernels, "ready", lambda: False)
    return processes


def test_another_process_compiles_while_the_block_runs_and_ends_with_it(started):
    def run():
        with compiled_aside():
            assert [(each.words, each.ended) for each in started] == [
                ([sys.executable, "-m", "contact.answers.first_use"], [])
            ]
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run()
    assert started[0].ended == ["kill", "wait"]


@pytest.mark.parametrize("why", ["kernels are there", "one processor", "nothing is kept"])
def test_no_process_is_started_where_it_would_not_help(started, monkeypatch, why):
    if why == "kernels are there":
        monkeypatch.setattr(kernels, "ready", lambda: True)
    elif why == "one processor":
        monkeypatch.setattr(first_use.os, "cpu_count", lambda: 1)
    else:
        monkeypatch.setattr(compiled, "cache_folder", lambda: None)
    with compiled_aside():
        assert started == []


def test_the_other_process_calls_the_kernel_of_a_steady_state(monkeypatch):
    # the kernel's machine code belongs to the types of its arguments
    from contact import steady
    from tests.contact.motors import orbit, slider

    kernel, called = event_driven.travel, []

    def types(given):
        return tuple(types(each) for each in given) if isinstance(given, tuple) else (type(given), callable(given))

    def spy(*arguments):
        called.append(types(arguments))
        return kernel(*arguments)

    monkeypatch.setattr(event_driven, "travel", spy)
    steady(slider(), orbit(5e-9), tolerance=1e-3)
    known = {each[3:] for each in called}
    called.clear()
    first_use.main()
    assert {each[3:] for each in called} <= known
    assert called
