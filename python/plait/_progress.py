"""Progress of long calls, and how Ctrl-C reaches them.

While the library runs, Python cannot interrupt it. But the library calls back many times, and there
Python runs the handler of the signal, which raises KeyboardInterrupt. The callback keeps the exception
and tells the library to stop; when the call has returned, the exception goes on its way.

Python runs a handler also before the first line of the callback, where nothing can catch what it
raises: ctypes prints it, and the library goes on. So the handler waits until the callback is inside
its `try`."""

import signal
import sys
import threading
import time
import warnings

import numpy as np

from ._structures import plait_progress, plait_warning

_REDRAW_SECONDS = 0.1


def _duration(seconds):
    seconds = int(seconds + 0.5)
    if seconds < 60:
        return f"{seconds} s"
    return f"{seconds // 60}:{seconds % 60:02d}"


class TerminalBar:
    """One line on a terminal."""

    def __init__(self, task, stream):
        self._task = task
        self._stream = stream
        self._width = 0

    def draw(self, text):
        self._stream.write("\r" + text.ljust(self._width))
        self._stream.flush()
        self._width = len(text)

    def end(self):
        self._stream.write("\r" + " " * self._width + "\r")
        self._stream.flush()


class NotebookBar:
    """One line under a cell of a notebook."""

    def __init__(self, task, display):
        self._handle = display({"text/plain": task}, raw=True, display_id=True)

    def draw(self, text):
        self._handle.update({"text/plain": text}, raw=True)

    def end(self):
        self._handle.update({"text/plain": ""}, raw=True)


def _bar(task):
    """A bar where people look at it, else None."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell is not None and hasattr(shell, "kernel"):
        from IPython.display import display
        return NotebookBar(task, display)
    stream = sys.stderr
    return TerminalBar(task, stream) if stream is not None and stream.isatty() else None


class Drawn:
    """Shows phase, part done and time left."""

    def __init__(self, task):
        self._task = task
        self._bar = _bar(task)
        self._phase = None
        self._start = self._next = 0.0

    def __call__(self, phase, done, total):
        if self._bar is None:
            return
        now = time.monotonic()
        if phase != self._phase:
            self._phase, self._start, self._next = phase, now, 0.0
        if now < self._next:
            return
        self._next = now + _REDRAW_SECONDS
        part = done / total if total else 0.0
        filled = int(24 * part)
        left = f", {_duration((now - self._start) * (1 - part) / part)} left" if part > 0.02 else ""
        self._bar.draw(f"{self._task}: {phase} [{'#' * filled}{'.' * (24 - filled)}] "
                       f"{100 * part:3.0f} %{left}")

    def end(self):
        if self._bar is not None:
            self._bar.end()


def truth(value):
    """True or False for a truth value of Python or numpy, else None."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, np.ndarray) and value.ndim == 0 and value.dtype == bool:
        return bool(value)
    return None


class Watch:
    """Watches one call of the library.

        with Watch("verify", progress) as watch:
            LIBRARY.plait_store_verify(..., watch.callback, ...)

    `progress` is None or False, True for a bar, or a function of (phase, done, total) whose False
    cancels the call."""

    def __init__(self, task, progress=None):
        self._told = Drawn(task) if progress is True else progress if callable(progress) else None
        self.raised = None
        self._cancelled = False
        self._handler = None  # of Ctrl-C, outside of this call
        self._waiting = None  # the arguments with which it will be called
        self._inside = False
        # Ctrl-C comes to the main thread. Elsewhere nobody needs the callback unless there is progress, and
        # a daemon thread that is in one when the interpreter exits is ended in the middle of the library.
        needed = self._told is not None or threading.current_thread() is threading.main_thread()
        self.callback = plait_progress(self.guard(self._tell)) if needed else plait_progress()

    def _tell(self, phase, done, total, _):
        return None if self._told is None else self._told(phase.decode(), done, total)

    def guard(self, function):
        """A function for the library: 0, after which the library should stop, for False and for an
        exception, which is kept."""

        def call(*arguments):
            try:
                self._inside = True
                if self.raised is not None:
                    return 0
                self._handle()
                if truth(function(*arguments)) is False:
                    self._cancelled = True
                    return 0
                return 1
            except BaseException as error:  # KeyboardInterrupt too: it must not pass through C
                self.raised = error
                return 0
            finally:
                self._inside = False

        return call

    def _interrupted(self, *arguments):
        self._waiting = arguments
        if self._inside:
            self._handle()

    def _handle(self):
        if self._waiting is not None:
            arguments, self._waiting = self._waiting, None
            self._handler(*arguments)

    def warning(self, warn):
        """A callback of the library for what it changes in a mesh: `warn` is a function of a text.
        None: Python warns, at the line that called the package."""

        def told(words, _):
            words = words.decode(errors="replace")
            if warn is None:
                warnings.warn(words, stacklevel=4)
            else:
                warn(words)

        return plait_warning(self.guard(told))

    def __enter__(self):
        handler = signal.getsignal(signal.SIGINT)
        if callable(handler) and threading.current_thread() is threading.main_thread():
            self._handler = handler
            signal.signal(signal.SIGINT, self._interrupted)
        return self

    def __exit__(self, kind, error, trace):
        from .errors import Cancelled
        if self._handler is not None:
            signal.signal(signal.SIGINT, self._handler)
        if isinstance(self._told, Drawn):
            self._told.end()
        if self.raised is not None:
            raise self.raised from None
        self._handle()
        # Python printed and dropped an exception that came at the edge of the callback.
        if kind is Cancelled and not self._cancelled:
            raise KeyboardInterrupt from None
