"""The command ``sawmotor``, also ``python -m studies``.

stdout carries the answer, stderr progress, warnings and refusals.  Exit codes: 0 an answer within its tolerance; 1 one
that misses it, or is refused for its model error; 2 bad input; 3 no answer; 70 a defect of sawmotor, its traceback in
the file that is named; 130 interrupted.  Nothing heavy is imported before a command asks for it.
"""

import os
import signal
import sys
import threading

# s that a process may take to end by itself after a signal, and more where it has workers
PATIENCE, PATIENCE_WITH_WORKERS = 1.2, 30.0


def main(words: list[str] | None = None) -> int:
    """Run the command in ``sys.argv``, or of these words, and return its exit code."""
    returned = threading.Event()
    try:  # nothing is imported before: an interrupt meanwhile is a sentence too
        if words is None:
            signal.signal(signal.SIGTERM, _ended)  # as an interrupt: work files and locks are cleared away
            _watch_signals(returned)
        return _guarded(sys.argv[1:] if words is None else words)
    except KeyboardInterrupt:
        return _said("interrupted, nothing was written", 130)
    finally:
        returned.set()


def _ended(*_):
    raise KeyboardInterrupt


def _watch_signals(returned: threading.Event) -> None:
    """End the process soon after SIGINT or SIGTERM, also where Python waits for compiled code and runs no handler.

    A command that has ``returned`` in time ends nothing: the process may be another's, such as a notebook's.

    The interpreter writes every signal to a pipe at once; a thread reads it, as compiled loops let other threads run,
    and ends the process where it has not ended by itself. Files are replaced as a whole, so none is left half written.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        return
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)

    def watch():
        while os.read(reading, 1)[0] not in (signal.SIGINT, signal.SIGTERM):
            pass
        if returned.wait(PATIENCE):
            return
        processes = sys.modules.get("multiprocessing")
        # workers finish their point first
        if processes is not None and processes.active_children() and returned.wait(PATIENCE_WITH_WORKERS):
            return
        os.write(2, b"sawmotor: interrupted, nothing was written\n")
        os._exit(130)

    threading.Thread(target=watch, daemon=True, name="signals").start()


def _guarded(words: list[str]) -> int:
    # many small dense problems: two threads of BLAS that wait for each other take ten times as long as one
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
        # whoever read stdout has left; keep the interpreter from flushing into the closed pipe at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_NO_ANSWER
    except MemoryError:
        text = "the run needs more memory than this machine gives it; a looser --tolerance needs less"
        return _said(text, EXIT_NO_ANSWER)
    except Exception as error:
        return _defect(error)


def _defect(error: Exception) -> int:
    """Say that the program has a defect, with the traceback in a file that a report of it can hold."""
    import tempfile
    import traceback

    from studies.refusal import EXIT_DEFECT

    if os.environ.get("SAWMOTOR_TRACEBACK"):
        raise error
    name, text = type(error).__name__, " ".join(str(error).split())
    with tempfile.NamedTemporaryFile("w", prefix="sawmotor-defect-", suffix=".txt", delete=False) as file:
        file.write(f"sawmotor {' '.join(sys.argv[1:])}\n\n{''.join(traceback.format_exception(error))}")
    return _said(
        f"a defect of sawmotor, not of your scene: {name}: {text}; its traceback is in {file.name}", EXIT_DEFECT
    )


def _dispatch(words: list[str]) -> int:
    from studies.command.parser import parser, refused
    from studies.refusal import SceneError

    top = parser(words[0] if words else None)
    try:
        arguments = top.parse_args(words)
    except SystemExit as leaving:  # argparse, after printing --help
        return int(leaving.code or 0)
    if arguments.call is None:
        top.print_help()
        return 0
    try:
        if getattr(arguments, "out", None) == "":
            raise SceneError("--out", "must be the name of a directory or file, got ''")
        return arguments.function(arguments)
    except SceneError as error:
        raise refused(error, arguments) from None


def _said(message, status: int) -> int:
    print(f"sawmotor: {message}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
