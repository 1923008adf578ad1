"""Calls on tasks: making, starting and stopping them, their sample clock and start trigger, waiting for events."""

import time
from collections.abc import Callable, Iterator
from functools import partial, wraps
from typing import Any

import numpy as np
from nidaqmx import SessionInitializationBehavior
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx.error_codes import DAQmxErrors

from drivers.ni.simulated.answering import Answering, answered, refuse
from drivers.ni.simulated.faults import DaqmxStatusError
from drivers.ni.simulated.task import Task, TaskState

_PATIENCE = 2.0
"""Wall time that a running callback has to read the samples announced to it, s; long, for busy computers."""


def _after_callbacks(answer: Callable[..., Any]) -> Callable[..., Any]:
    """Let an ending call wait for the callback that reads.

    At a card's pace hardly any is under way when a program stops its task; at virtual speed one always is, and
    would find the task gone.
    """

    @wraps(answer)
    def patient(self: Answering, request: Any, context: Any) -> Any:
        until = time.monotonic() + _PATIENCE
        while True:
            with self.lock:
                task = self.chassis.tasks.get(request.task.name)
                reading = task is not None and task.broken is None and task.position < task.announced
                if not reading or time.monotonic() >= until:
                    return answer(self, request, context)
            time.sleep(0.005)

    return patient


class TaskCalls(Answering):
    """The part of the service that has to do with whole tasks."""

    _made = 0

    @answered
    def CreateTask(self, request: Any) -> Any:
        name = request.session_name
        if name and name in self.chassis.tasks:
            if request.initialization_behavior == SessionInitializationBehavior.INITIALIZE_SERVER_SESSION:
                raise DaqmxStatusError(
                    DAQmxErrors.DUPLICATE_TASK, f"Task name conflicts with an existing task. Task Name: {name}"
                )
            response = pb.CreateTaskResponse(new_session_initialized=False)  # attached, as NI's server does
            response.task.name = name
            return response
        self._made += 1
        name = name or f"_unnamedTask<{self._made}>"
        self.chassis.tasks[name] = Task(name)
        response = pb.CreateTaskResponse(new_session_initialized=True)
        response.task.name = name
        return response

    @_after_callbacks
    @answered
    def ClearTask(self, request: Any) -> Any:
        task = self.task_of(request)
        if task.state is not TaskState.CONFIGURED:
            self.chassis.stop(task)
        del self.chassis.tasks[task.name]
        return pb.ClearTaskResponse()

    @answered
    def StartTask(self, request: Any) -> Any:
        self.chassis.start(self.task_of(request))
        return pb.StartTaskResponse()

    @_after_callbacks
    @answered
    def StopTask(self, request: Any) -> Any:
        task = self.task_of(request)
        if task.broken is not None:
            raise task.broken
        self.chassis.stop(task)
        return pb.StopTaskResponse()

    @answered
    def TaskControl(self, request: Any) -> Any:
        task = self.task_of(request)
        action = request.action_raw or request.action
        if action == pb.TASK_CONTROL_ACTION_TASK_START:
            self.chassis.start(task)
        elif action == pb.TASK_CONTROL_ACTION_TASK_VERIFY:
            self.chassis.verify(task)
        elif action in (pb.TASK_CONTROL_ACTION_TASK_RESERVE, pb.TASK_CONTROL_ACTION_TASK_COMMIT):
            self.chassis.reserve(task)
            task.reserved_on_purpose = True
        else:  # stop, abort, unreserve
            self.chassis.stop(task)
            if action != pb.TASK_CONTROL_ACTION_TASK_STOP:
                self.chassis.release(task)
        return pb.TaskControlResponse()

    @answered
    def WaitUntilTaskDone(self, request: Any) -> Any:
        task = self.task_of(request)
        chassis, now = self.chassis, self.chassis.clock.now()
        if not chassis.done(task):
            patience = request.time_to_wait
            if patience >= 0.0 or not np.isfinite(task.ends()):
                chassis.pass_time_to(min(task.ends(), now + max(patience, 0.0)))
            else:
                chassis.pass_time_to(task.ends())
        if task.broken is not None:
            raise task.broken
        if not chassis.done(task):
            raise DaqmxStatusError(
                DAQmxErrors.WAIT_UNTIL_DONE_DOES_NOT_INDICATE_DONE,
                "Wait Until Done did not indicate that the task was done within the specified timeout. "
                f"Task Name: {task.name}",
            )
        return pb.WaitUntilTaskDoneResponse()

    @answered
    def IsTaskDone(self, request: Any) -> Any:
        task = self.task_of(request)
        if task.broken is not None:
            raise task.broken
        return pb.IsTaskDoneResponse(is_task_done=self.chassis.done(task))

    @answered
    def GetTaskAttributeString(self, request: Any) -> Any:
        task = self.task_of(request)
        values = {
            pb.TASK_ATTRIBUTE_NAME: task.name,
            pb.TASK_ATTRIBUTE_CHANNELS: ", ".join(channel.name for channel in task.channels),
            pb.TASK_ATTRIBUTE_DEVICES: ", ".join(self._devices(task)),
        }
        return pb.GetTaskAttributeStringResponse(value=self.one_of(values, pb.TaskStringAttribute, request))

    @answered
    def GetTaskAttributeUInt32(self, request: Any) -> Any:
        task = self.task_of(request)
        values = {
            pb.TASK_ATTRIBUTE_NUM_CHANS: len(task.channels),
            pb.TASK_ATTRIBUTE_NUM_DEVICES: len(self._devices(task)),
        }
        return pb.GetTaskAttributeUInt32Response(value=self.one_of(values, pb.TaskUInt32Attribute, request))

    def _devices(self, task: Task) -> list[str]:
        """Names of a task's modules and of their chassis, where programs look for its trigger terminals."""
        modules = task.devices()
        return [*modules, self.chassis.surroundings.chassis] if modules else []


class TimingCalls(Answering):
    """The part of the service that says when samples are taken."""

    @answered
    def CfgSampClkTiming(self, request: Any) -> Any:
        task = self.task_of(request)
        self.chassis.verify(task)
        if request.source and not request.source.lower().endswith("onboardclock"):
            # What is to clock it from outside is taken to have the rate that the program states.
            self.chassis.known_terminal(request.source)
        finite = (request.sample_mode_raw or request.sample_mode) == pb.ACQUISITION_TYPE_FINITE_SAMPS
        samples = max(2, int(request.samps_per_chan))
        self.chassis.clocks.configure(task, request.rate, samples, finite=finite)
        return pb.CfgSampClkTimingResponse()

    @answered
    def GetTimingAttributeDouble(self, request: Any) -> Any:
        task = self.task_of(request)
        values = {
            pb.TIMING_ATTRIBUTE_SAMP_CLK_RATE: task.clocked().rate,
            pb.TIMING_ATTRIBUTE_SAMP_CLK_TIMEBASE_RATE: self.chassis.clocks.timebase_rate(task),
        }
        return pb.GetTimingAttributeDoubleResponse(value=self.one_of(values, pb.TimingDoubleAttribute, request))

    @answered
    def SetTimingAttributeDouble(self, request: Any) -> Any:
        task = self.task_of(request)
        # The frequency of a timebase within the chassis is known to the driver: nothing to store.
        self.one_of({pb.TIMING_ATTRIBUTE_SAMP_CLK_TIMEBASE_RATE: task}, pb.TimingDoubleAttribute, request)
        return pb.SetTimingAttributeDoubleResponse()

    @answered
    def GetTimingAttributeString(self, request: Any) -> Any:
        source = self.chassis.clocks.timebase(self.task_of(request))
        values = {pb.TIMING_ATTRIBUTE_SAMP_CLK_TIMEBASE_SRC: source}
        return pb.GetTimingAttributeStringResponse(value=self.one_of(values, pb.TimingStringAttribute, request))

    @answered
    def SetTimingAttributeString(self, request: Any) -> Any:
        task = self.task_of(request)
        self.one_of({pb.TIMING_ATTRIBUTE_SAMP_CLK_TIMEBASE_SRC: task}, pb.TimingStringAttribute, request)
        self.chassis.clocks.take_timebase(task, request.value)
        return pb.SetTimingAttributeStringResponse()

    @answered
    def GetTimingAttributeInt32(self, request: Any) -> Any:
        finite = self.task_of(request).clocked().finite
        modes = (
            pb.TIMING_INT32_ACQUISITION_TYPE_FINITE_SAMPS
            if finite
            else pb.TIMING_INT32_ACQUISITION_TYPE_CONT_SAMPS
        )
        values = {pb.TIMING_ATTRIBUTE_SAMP_QUANT_SAMP_MODE: modes}
        return pb.GetTimingAttributeInt32Response(value_raw=self.one_of(values, pb.TimingInt32Attribute, request))

    @answered
    def GetTimingAttributeUInt64(self, request: Any) -> Any:
        values = {pb.TIMING_ATTRIBUTE_SAMP_QUANT_SAMP_PER_CHAN: self.task_of(request).clocked().samples}
        return pb.GetTimingAttributeUInt64Response(value=self.one_of(values, pb.TimingUInt64Attribute, request))

    @answered
    def CfgDigEdgeStartTrig(self, request: Any) -> Any:
        task = self.task_of(request)
        task.trigger = self.chassis.known_terminal(request.trigger_source)
        return pb.CfgDigEdgeStartTrigResponse()

    @answered
    def CfgDigEdgeRefTrig(self, request: Any) -> Any:
        task = self.task_of(request)
        if not self.chassis.clocks.is_pfi(self.chassis.known_terminal(request.trigger_source)):
            self.lacks("CfgDigEdgeRefTrig on another task's trigger")
        task.pretrigger = int(request.pretrigger_samples)
        return pb.CfgDigEdgeRefTrigResponse()

    @answered
    def GetTrigAttributeString(self, request: Any) -> Any:
        task = self.task_of(request)
        values = {
            pb.TRIGGER_ATTRIBUTE_START_TRIG_TERM: self.chassis.clocks.terminal(task, "StartTrigger"),
            pb.TRIGGER_ATTRIBUTE_DIG_EDGE_START_TRIG_SRC: task.trigger,
        }
        return pb.GetTrigAttributeStringResponse(value=self.one_of(values, pb.TriggerStringAttribute, request))


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
