"""Draw the pictures of a run in a second process.

The second process loads the plotting library while the run is being computed, which saves time. If the first process
has already loaded the library, it draws the pictures itself. The second process uses the import path of the first one
and never imports from the working directory (``python -P``). It reads the pickled request (record, directory) from
stdin and writes the pickled exception, or None, to stdout.
"""

import os
import pickle
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

from studies.record import Record
from studies.record.plots import leave_out_property_tables
from studies.record.run_pictures import draw_run, pictures
from studies.refusal import RunError

# without searches for cyclic garbage, which take a twentieth of the time and of which this short process has no need
PROGRAM = "import gc, sys; gc.disable(); sys.path[:] = {path!r}; from studies.report.drawing import serve; serve()"


class Drawing:
    """Context manager of the drawing process: entering starts it, `draw` uses it, and leaving ends it."""

    def __enter__(self):
        """Start the process in its own session, so that an interrupt from the terminal does not reach it."""
        self.process = None
        if "matplotlib.figure" in sys.modules:
            return self
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", PROGRAM.format(path=sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        return self

    def __exit__(self, *raised):
        """End the process, and the copy of itself that draws beside it."""
        if self.process is not None:
            if self.process.poll() is None and hasattr(os, "killpg"):
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.kill()
            self.process.communicate()

    def draw(self, record: Record, folder: Path) -> None:
        """Draw the pictures of a record into a directory; raise an exception of the drawing process here."""
        if self.process is None:
            return draw_run(record, folder)
        request = pickle.dumps((replace(record, surface_motion=None, further_motions=()), folder.resolve()))
        answer, _ = self.process.communicate(request)
        if self.process.returncode:
            raise RunError(f"the pictures were not drawn: their process ended with code {self.process.returncode}")
        failure = pickle.loads(answer)
        if failure is not None:
            raise failure


def serve() -> None:
    """Read a request from stdin and draw it; this is the main function of the drawing process."""
    leave_out_property_tables()

    request = sys.stdin.buffer.read()
    if not request:  # the run ended without pictures, so that no answer is expected
        return
    failure = None
    try:
        _draw(*pickle.loads(request))
    except Exception as error:
        failure = error
    sys.stdout.buffer.write(pickle.dumps(failure))
    sys.stdout.buffer.flush()
    os._exit(0)  # skip the clean-up of the plotting library, for which the run would wait 0.1 s


def _draw(record: Record, folder: Path) -> None:
    """Draw every second picture in a copy of this process, on another core; what the copy cannot draw is drawn here."""
    names = list(pictures(record))
    halves = names[::2], names[1::2]
    copy = os.fork() if sys.platform == "linux" and halves[1] else None  # other systems' libraries forbid it
    if copy == 0:
        try:
            draw_run(record, folder, halves[1])
        except BaseException:
            os._exit(1)
        os._exit(0)
    draw_run(record, folder, halves[0])
    if copy is None or os.waitpid(copy, 0)[1] != 0:
        draw_run(record, folder, halves[1])
