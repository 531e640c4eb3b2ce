"""A signal ends the command soon, also while compiled code runs for minutes and Python calls no handler."""

import os
import signal
import subprocess
import sys

import pytest

# a minute and more in one call of a kernel that lets other threads run
STUCK = """
import sys
import studies.__main__ as command

def kernel(words):
    import numpy as np
    from contact.answers.rest_motion import rest, rest_problem
    from contact.stepping.time_stepping import steps
    from tests.contact.motors import orbit, slider

    problem = rest_problem(slider(), (orbit(5e-9),))
    state = rest(slider(), (orbit(5e-9),), problem, nodes=8, truncation=1e-6).state
    steps(problem, state, 10, 24)
    print("stuck", flush=True)
    steps(problem, state, 2_000_000_000, 24, stride=0)

command._dispatch = kernel
sys.exit(command.main())
"""


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="POSIX signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_compiled_loop(number):
    path = os.pathsep.join(each for each in sys.path if each)
    with subprocess.Popen(
        [sys.executable, "-c", STUCK], env=os.environ | {"PYTHONPATH": path}, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a shell's background job ignores it
    ) as process:  # fmt: skip
        try:
            assert process.stdout.readline() == "stuck\n"
            process.send_signal(number)
            _, err = process.communicate(timeout=300)  # no measure of time: the loop alone would take longer
        finally:
            process.kill()
    assert process.returncode == 128 + number
    assert "interrupted, nothing was written" in err
