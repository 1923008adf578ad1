"""Calls that wait for something to happen to a task."""

import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb

from drivers.ni.simulated.answering import Answering, answered, refuse
from drivers.ni.simulated.status import DaqmxStatusError
from drivers.ni.simulated.task import Task, TaskState

_POLL = 0.005
"""Wall time between two looks at a task, s."""

_IDLE = 0.5
"""Wall time after which it is assumed that no other call will advance the clock, s."""


class EventCalls(Answering):
    """The part of the service that announces events to a client.

    A client that waits for an event reads nothing meanwhile, so no call advances the virtual clock: the
    event's own stream does, as soon as the client has read what the last event announced.
    """

    def RegisterEveryNSamplesEvent(self, request: Any, context: Any) -> Iterator[Any]:
        task = self._registered(request, context, "RegisterEveryNSamplesEvent")
        if task is None:
            return
        every = max(1, int(request.n_samples))
        reader = request.every_n_samples_event_type_raw or request.every_n_samples_event_type
        total = every
        while self._happens(task, context, partial(self._announce, task, total, every)):
            yield pb.RegisterEveryNSamplesEventResponse(
                every_n_samples_event_type_raw=reader, n_samples=every, status=0
            )
            total += every
            if task.timing is not None and task.timing.finite and total > task.timing.samples:
                return

    def RegisterDoneEvent(self, request: Any, context: Any) -> Iterator[Any]:
        task = self._registered(request, context, "RegisterDoneEvent")
        if task is None:
            return
        idle_since = [time.monotonic(), self.chassis.clock.now()]
        if self._happens(task, context, lambda: self._finish(task, idle_since)):
            yield pb.RegisterDoneEventResponse(status=task.broken.code if task.broken else 0)

    def _registered(self, request: Any, context: Any, call: str) -> Task | None:
        try:
            with self.lock:
                self.begin(call)
                task = self.task_of(request)
                task.watched = True
        except DaqmxStatusError as status:
            refuse(context, status)
            return None
        # The client starts its task only once the event is registered.
        context.send_initial_metadata(())
        return task

    def _happens(self, task: Task, context: Any, happened: Callable[[], bool]) -> bool:
        """Wait until something has happened; return False if no client waits for it any more."""
        while context.is_active():
            with self.lock:
                if not task.watched or task not in self.chassis.tasks.values():
                    return False
                if task.state is TaskState.STARTED and task.began is not None and happened():
                    return True
            time.sleep(_POLL)
        return False

    def _announce(self, task: Task, total: int, every: int) -> bool:
        """Whether so many samples are there, as `_reach` says; from now on a client is expected to read them."""
        reached = self._reach(task, total, every)
        if reached and task.is_input:
            task.announced = total
        return reached

    def _reach(self, task: Task, total: int, every: int) -> bool:
        """Whether so many samples are there; brings them about once those before them have been read."""
        if task.broken is not None:
            return False
        clock = self.chassis.clock
        caught_up = not task.is_input or task.position >= total - every
        if task.taken(clock.now()) < total and caught_up and task.began is not None:
            self.chassis.pass_time_to(task.began + total / task.clocked().pace)
        return task.broken is None and task.taken(clock.now()) >= total

    def _finish(self, task: Task, idle_since: list[float]) -> bool:
        """Whether a finite task is done or broken; ends it once no other call advances the clock."""
        clock = self.chassis.clock
        if task.broken is not None:
            return True
        if clock.now() != idle_since[1]:
            idle_since[:] = [time.monotonic(), clock.now()]
        elif time.monotonic() - idle_since[0] > _IDLE and task.ends() < float("inf"):
            self.chassis.pass_time_to(task.ends())
        return self.chassis.done(task)

    @answered
    def UnregisterEveryNSamplesEvent(self, request: Any) -> Any:
        self.task_of(request).watched = False
        return pb.UnregisterEveryNSamplesEventResponse()

    @answered
    def UnregisterDoneEvent(self, request: Any) -> Any:
        self.task_of(request).watched = False
        return pb.UnregisterDoneEventResponse()
