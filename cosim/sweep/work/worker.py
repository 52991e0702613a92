"""A worker of a local pool: ``python -m cosim.sweep.work.worker SOCKET FILE``.

The socket leads to its pool; what its runs are doing is in the file.
It is sent the job, says when it is ready, and from then on gets tasks and answers results.
"""

from __future__ import annotations

import os
import pickle
import signal
import socket
import sys
from collections.abc import Iterator
from typing import NoReturn

from cosim.base.system.garbage import collect_seldom
from cosim.sweep.work.message_socket import MessageSocket
from cosim.sweep.work.messages import READY, ResultWriter, task_of
from cosim.sweep.work.runner import PointRunner
from cosim.sweep.work.traces import Traces


def main(number: int, file: int) -> None:
    """Work until nobody is there any more."""
    settle()
    pipe = MessageSocket(socket.socket(fileno=number))
    writer, told = ResultWriter(), _told(pipe)
    with PointRunner(pickle.loads(next(told)), Traces(file)) as runner:
        _say(pipe, READY)
        for task in told:
            # Each at once: what kills this process costs the run that it is at, and no other.
            _say(pipe, writer.write(runner.run(task_of(task))))


def settle() -> None:
    """Leave out, in a process that only repeats runs, what a run does for people before it."""
    collect_seldom()
    # No run has to turn Ctrl-C into a wish and back: the pool's process hears it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _told(pipe: MessageSocket) -> Iterator[bytes]:
    """What comes from the pool, one after another."""
    while True:
        try:
            yield from pipe.receive()
        except (EOFError, OSError):
            _leave()


def _say(pipe: MessageSocket, what: bytes) -> None:
    try:
        pipe.send(what)
    except OSError:
        _leave()


def _leave() -> NoReturn:
    """End without what FMUs may have left for the end of the process: nobody waits for it."""
    os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
