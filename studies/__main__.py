"""The command ``sawmotor``, also ``python -m studies``.

The answer is written to stdout; progress, warnings and refusals are written to stderr.  Exit codes:

- 0: an answer within its tolerance,
- 1: an answer that misses its tolerance, or is refused for its model error,
- 2: bad input,
- 3: no answer,
- 70: a defect of sawmotor; the message names the file with the traceback,
- 130: interrupted (SIGINT, as from Ctrl-C),
- 143: ended by SIGTERM.

Packages that are slow to import are imported only by the commands that need them.
"""

import gc
import os
import signal
import sys
import threading

# Seconds that a process may take to end by itself after a signal; with workers it waits for their current points.
PATIENCE, PATIENCE_WITH_WORKERS = 1.2, 30.0
# New objects before a search for cyclic garbage, of which a run makes little. At Python's default of 700 the searches
# take 55 ms of a run of twente, at 50 000 13 ms.
GARBAGE_THRESHOLD = 200_000


def main(words: list[str] | None = None) -> int:
    """Run the command in ``sys.argv``, or of these words, and return its exit code."""
    returned, terminated = threading.Event(), threading.Event()

    def end(*_):
        terminated.set()
        raise KeyboardInterrupt

    try:  # before any slow import, so that an interrupt during the imports also ends with a message
        if words is None:
            gc.set_threshold(GARBAGE_THRESHOLD)
            signal.signal(signal.SIGTERM, end)  # handled as SIGINT, so that work files and locks are removed
            _watch_signals(returned)
        status = _guarded(sys.argv[1:] if words is None else words)
    except KeyboardInterrupt:
        # CPython marks an interrupt that passed through exec() of a string, as in a dataclass, as unhandled, and
        # "python -m" then ends by SIGINT (-2) whatever main returns; the next exec() clears the mark.
        exec("")
        status = _said("interrupted, nothing was written", 128 + signal.SIGINT)
    finally:
        returned.set()
        if words is None:
            gc.freeze()  # the interpreter's last search for cyclic garbage would take 50 ms
    interrupted = status == 128 + signal.SIGINT
    return 128 + signal.SIGTERM if interrupted and terminated.is_set() else status


def _watch_signals(returned: threading.Event) -> None:
    """End the process soon after SIGINT or SIGTERM, even while compiled code runs and delays Python's signal handlers.

    The interpreter writes every signal to a pipe at once. A thread reads the pipe; it can run because compiled loops
    release the GIL. If the process has not ended by itself after PATIENCE, the thread ends it. No file is left half
    written, because files are replaced as a whole. If the command has ``returned`` in time, the process is left alone:
    it may belong to another program, such as a notebook.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        return
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)

    def watch():
        number = 0
        while number not in (signal.SIGINT, signal.SIGTERM):
            number = os.read(reading, 1)[0]
        if returned.wait(PATIENCE):
            return
        processes = sys.modules.get("multiprocessing")
        # workers finish their point first
        if processes is not None and processes.active_children() and returned.wait(PATIENCE_WITH_WORKERS):
            return
        os.write(2, b"sawmotor: interrupted, nothing was written\n")
        os._exit(128 + number)

    threading.Thread(target=watch, daemon=True, name="signals").start()


def _guarded(words: list[str]) -> int:
    # The dense problems are small: two BLAS threads that wait for each other take ten times as long as one.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a letter that the terminal's encoding lacks
    from studies.refusal import EXIT_NO_ANSWER, RunError, SceneError

    try:
        try:
            status = _dispatch(words)
        finally:
            sys.stdout.flush()
        return status
    except SceneError as error:
        return max(_said(problem, problem.exit_code) for problem in error.problems)
    except RunError as error:
        return _said(error, error.exit_code)
    except BrokenPipeError:
        # the reader of stdout has ended; keep the interpreter from flushing into the closed pipe at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_NO_ANSWER
    except MemoryError:
        text = "the run needs more memory than this machine gives it; a looser --tolerance needs less"
        return _said(text, EXIT_NO_ANSWER)
    except Exception as error:
        return _defect(error)


def _defect(error: Exception) -> int:
    """Report a defect of the program, with the traceback in a file to attach to a bug report."""
    import tempfile
    import traceback

    from studies.refusal import EXIT_DEFECT

    if os.environ.get("SAWMOTOR_TRACEBACK"):
        raise error
    name, text = type(error).__name__, " ".join(str(error).split())
    with tempfile.NamedTemporaryFile("w", prefix="sawmotor-defect-", suffix=".txt", delete=False) as file:
        file.write(f"sawmotor {' '.join(sys.argv[1:])}\n\n{''.join(traceback.format_exception(error))}")
    notes = "".join(f"; {note}" for note in getattr(error, "__notes__", ()))
    message = f"a defect of sawmotor, not of your scene: {name}: {text}{notes}; its traceback is in {file.name}"
    return _said(message, EXIT_DEFECT)


def _dispatch(words: list[str]) -> int:
    from studies.command.parser import parser, refused
    from studies.refusal import SceneError, refuse_if

    top = parser(words[0] if words else None)
    try:
        arguments = top.parse_args(words)
    except SystemExit as leaving:  # argparse, after printing --help
        return int(leaving.code or 0)
    if arguments.call is None:
        top.print_help()
        return 0
    try:
        refuse_if(getattr(arguments, "out", None) == "", "--out", "must be the name of a directory or file, got ''")
        return arguments.function(arguments)
    except SceneError as error:
        raise refused(error, arguments) from None


def _said(message, status: int) -> int:
    print(f"sawmotor: {message}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
