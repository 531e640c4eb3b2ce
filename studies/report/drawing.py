"""A process that draws the pictures of a run: it loads the plotting library while the run is being computed.

Where this process has loaded the library already, it draws them itself.  The other imports from the same places and
never from the working directory (``python -P``).  It reads from stdin what to draw and where, and answers on stdout
with the exception that it met, or None.
"""

import os
import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

from studies.record import Record
from studies.refusal import RunError

PROGRAM = "import sys; sys.path[:] = {path!r}; from studies.report.drawing import serve; serve()"


class Drawing:
    """Context manager: starts the process; ``draw`` gives it the work; leaving ends it, drawn or not."""

    def __enter__(self):
        """Start the process, apart from the terminal's interrupt: whoever started it ends it."""
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
        """End the process."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()

    def draw(self, record: Record, folder: Path) -> None:
        """Draw the pictures that a record has, into a directory; raises what the drawing raised."""
        if self.process is None:
            from studies.record.run_pictures import draw_run

            return draw_run(record, folder)
        needed = pickle.dumps((replace(record, surface_motion=None), folder.resolve()))
        answer, _ = self.process.communicate(needed)
        if self.process.returncode:
            raise RunError(
                f"the pictures were not drawn: their process ended with code {self.process.returncode}"
            )
        failure = pickle.loads(answer)
        if failure is not None:
            raise failure


def serve() -> None:
    """Draw what stdin asks for; the work of the process."""
    import matplotlib.backends.backend_agg
    import matplotlib.figure  # noqa: F401

    from studies.record.run_pictures import draw_run

    request = sys.stdin.buffer.read()
    if not request:  # the run ended without pictures, and nobody reads an answer
        return
    failure = None
    try:
        draw_run(*pickle.loads(request))
    except Exception as error:
        failure = error
    sys.stdout.buffer.write(pickle.dumps(failure))
    sys.stdout.buffer.flush()
    os._exit(0)  # the run waits for the end, and to take the plotting library down takes 0.1 s
