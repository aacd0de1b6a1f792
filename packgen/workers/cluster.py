"""Processes that share the work of a bed, by Dask: those of this machine, or of a cluster that is running.

A call is handed to Dask once all that it stands on is in files; it returns a few numbers. So nothing is lost
with a process: Dask makes its calls again in another one, and they find their files.
"""

from __future__ import annotations

import logging
import os
import queue
import signal
import tempfile
import uuid
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache, partial
from multiprocessing import resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from packgen.arrange.crew import Done
from packgen.cores import free_cores
from packgen.errors import PackgenError
from packgen.leftovers import SCRATCH, owner
from packgen.version import __version__
from packgen.workers.parts import Parts

if TYPE_CHECKING:
    from distributed import Client

INSTALL = "pip install 'packgen[distributed]'"
PATIENCE = 30.0
"""Seconds that a scheduler has to answer at first."""

ENDED_MAX = 10
"""How often a call is made again whose process has ended: a cluster may take its machines back."""

LOOK = 0.2
"""Seconds between two looks at whether the scheduler is still there."""


class WorkerError(PackgenError):
    """Processes that cannot go on; what is done is kept."""

    exit_code = 1


class _Place(NamedTuple):
    """What a process tells of itself: its version of packgen, whether it sees the folder, its cores."""

    version: str
    sees_folder: bool
    cores: int


class Cluster:
    """A crew of processes that Dask manages; see ``packgen.arrange.crew.Crew``.

    Args:
        connect: Returns Dask's client, and starts the processes where they are not there; called where the
            first call is handed out.
        folder: Folder that all processes see.
        threads: Threads of a call.

    Attributes:
        folder: That folder.
        threads: Those threads.
    """

    def __init__(self, connect: Callable[[], Client], folder: Path, threads: int) -> None:
        self.folder, self.threads = folder, threads
        self._connect = cache(connect)
        # The same call of another run is another one.
        self._run = uuid.uuid4().hex
        self._futures: dict[Any, Any] = {}
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()

    @property
    def client(self) -> Client:
        """Dask's client."""
        return self._connect()

    def hand_out(self, key: Any, call: Callable[..., Any], *arguments: Any) -> None:
        """Have a call made in some process."""
        name = f"{call.__name__}-{self._run}-{'-'.join(map(str, key))}"
        future: Any = self.client.submit(call, *arguments, key=name, pure=False)
        self._futures[key] = future
        future.add_done_callback(partial(self._note, key))

    def _note(self, key: Any, _future: Any) -> None:
        self._ended.put(key)

    def next_done(self) -> Done:
        """Wait for a call.

        Raises:
            WorkerError: The scheduler is gone, or the call ended every process that made it.
            Exception: What the call itself raised.
        """
        while True:
            try:
                key = self._ended.get(timeout=LOOK)
                break
            except queue.Empty:
                if self.client.status != "running":
                    raise WorkerError(self._lost()) from None
        future = self._futures.pop(key)
        try:
            return Done(key, future.result())
        except Exception as error:
            if future.status != "error":  # the call itself has raised nothing
                raise WorkerError(self._lost()) from error
            if type(error).__name__ != "KilledWorker":
                raise
            raise WorkerError(
                f"{key}: every process that worked on it has ended, by lack of memory maybe; {self._kept}"
            ) from error
        finally:
            future.release()

    def _lost(self) -> str:
        return f"the scheduler does not answer any more; {self._kept}"

    @property
    def _kept(self) -> str:
        if not Parts(self.folder).begun:
            return "nothing is done yet"
        return f"what is done is in {self.folder}, --resume goes on with it"


@contextmanager
def local_cluster(workers: int, folder: Path, threads: int | None) -> Iterator[Cluster]:
    """Start processes on this machine, and end them afterwards.

    Args:
        workers: How many.
        folder: Where they keep what they make.
        threads: Threads of each; None: an equal share of the free cores.

    Yields:
        The crew.

    Raises:
        PackgenError: Dask is not installed.
    """
    distributed = _distributed("--workers")
    with ExitStack() as stack:

        def connect() -> Client:
            scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix=f"{SCRATCH}{owner()}-"))
            with _left_to_this_process():
                cluster = distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    dashboard_address=None,
                    worker_dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                    memory_limit=0,
                    local_directory=scratch,
                )
                stack.enter_context(cluster)
                client: Client = stack.enter_context(distributed.Client(cluster))
            return client

        yield Cluster(connect, folder, threads or max(1, free_cores() // workers))


@contextmanager
def _left_to_this_process() -> Iterator[None]:
    """Have the processes and threads that start in here leave Ctrl-C to this process, and end in silence.

    A terminal sends it to all of them. This process's other threads still hear it.
    """
    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = "ignore:resource_tracker"
    masked = {signal.SIGINT} if hasattr(signal, "pthread_sigmask") else set()
    if masked:
        # It unblocks the signal again where it starts.
        resource_tracker.ensure_running()
        former = signal.pthread_sigmask(signal.SIG_BLOCK, masked)
    try:
        yield
    finally:
        if masked:
            signal.pthread_sigmask(signal.SIG_SETMASK, former)
        if before is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = before


@contextmanager
def remote_cluster(address: str, folder: Path, threads: int | None) -> Iterator[Cluster]:
    """Use the processes of a cluster that is running.

    Args:
        address: Where its scheduler is: ``tcp://host:8786``.
        folder: Where they keep what they make; they must see it under the same name.
        threads: Threads of each; None: as many as the least of them has cores for a call.

    Yields:
        The crew.

    Raises:
        PackgenError: Dask is not installed, the scheduler does not answer, or its workers will not do.
    """
    distributed = _distributed("--scheduler")
    try:
        client = distributed.Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        raise PackgenError(
            f"--scheduler {address}: no scheduler answers there: {error}; start one by dask scheduler"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise PackgenError(
                f"--scheduler {address}: found no workers, expected some; start dask worker {address}"
            ) from None
        try:
            places = client.run(_place, str(folder))
        except ImportError as error:
            raise PackgenError(
                f"--scheduler {address}: its workers lack a library: {error}; install packgen "
                f"{__version__} there"
            ) from error
        _check(address, folder, places)
        yield Cluster(lambda: client, folder, threads or min(each.cores for each in places.values()))


def _place(folder: str, dask_worker: Any) -> _Place:
    """Return what the process tells of itself in which this runs; Dask fills in its worker."""
    return _Place(__version__, Path(folder).is_dir(), max(1, free_cores() // dask_worker.state.nthreads))


def _check(address: str, folder: Path, places: dict[str, _Place]) -> None:
    """Refuse a cluster with workers that have another packgen or see no such folder."""
    for name, place in places.items():
        if place.version != __version__:
            raise PackgenError(
                f"--scheduler {address}: worker {name} has packgen {place.version}, expected {__version__}; "
                "install the same version"
            )
        if not place.sees_folder:
            raise PackgenError(
                f"--scheduler {address}: worker {name} does not see {folder}; choose with -o a folder on a "
                "file system that all machines share"
            )


def _distributed(option: str) -> Any:
    """Return Dask's package, with quiet logs and patience with processes that end.

    Raises:
        PackgenError: It is not installed.
    """
    try:
        import dask
        import distributed
    except ImportError as error:
        raise PackgenError(f"{option}: needs Dask, which is not installed; {INSTALL}") from error
    for name in list(logging.root.manager.loggerDict):
        # Tasks that a stop cuts off are told of by asyncio.
        if name.partition(".")[0] in {"distributed", "asyncio"}:
            logging.getLogger(name).setLevel(logging.CRITICAL)
    dask.config.set({"distributed.scheduler.allowed-failures": ENDED_MAX})
    return distributed
