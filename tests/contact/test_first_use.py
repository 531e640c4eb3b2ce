"""Kernels that another process compiles while a run goes on."""

import subprocess
import sys

import numpy as np
import pytest

from contact import compiled_aside
from contact.answers import first_use
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
                ([sys.executable, "-P", "-m", "contact.answers.first_use"], [])
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


@pytest.fixture
def called(monkeypatch):
    """Give the types of arguments that machine code belongs to, of each kernel that runs, by its name."""
    found, run = {}, compiled.Native.__call__

    def types(given):
        if isinstance(given, tuple):
            return tuple(types(each) for each in given)
        if isinstance(given, np.ndarray):
            return given.dtype.kind, given.ndim
        return given.word if isinstance(given, compiled.Kernel) else (given is None, isinstance(given, float))

    def spy(kernel, *arguments):
        found.setdefault(kernel.__name__, set()).add(types(arguments))
        return run(kernel, *arguments)

    monkeypatch.setattr(compiled.Native, "__call__", spy)
    return found


def test_the_other_process_calls_the_kernels_of_a_run(called, monkeypatch):
    # the kernels' machine code belongs to the types of their arguments
    from contact import mean_motion, steady
    from contact.averaged.steady_sweep import mean_forces
    from tests.contact.motors import orbit, slider

    steady(slider(), orbit(5e-9), tolerance=1e-3)
    mean_forces(slider(), orbit(5e-9), mean_motion(slider(), orbit(5e-9)))
    known = {name: set(each) for name, each in called.items()}
    called.clear()
    monkeypatch.setattr(compiled, "MEANWHILE", [])
    first_use.main()
    assert {"travel", "_solve_problems", "contact_cycles"} <= set(called)
    for name in called:
        assert called[name] <= known[name]


def test_a_process_that_waits_for_another_one_compiles_the_events_meanwhile(started, tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")
    done = []
    path = tmp_path / "kernel.lock"
    lock = path.open("w")
    fcntl.flock(lock, fcntl.LOCK_EX)

    def compile_now():
        done.append("events")
        fcntl.flock(lock, fcntl.LOCK_UN)

    monkeypatch.setattr(first_use, "compile_events", compile_now)
    with compiled_aside():
        with compiled.file_lock(path):
            assert done == ["events"]
        assert compiled.MEANWHILE == []
    lock.close()


def test_what_nobody_waited_for_is_forgotten_with_the_block(started):
    with compiled_aside():
        assert len(compiled.MEANWHILE) == 1
    assert compiled.MEANWHILE == []
