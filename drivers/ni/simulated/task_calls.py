"""Calls on tasks: making, starting, stopping them and asking how they are."""

import time
from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np
from nidaqmx import SessionInitializationBehavior
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx.error_codes import DAQmxErrors

from drivers.ni.simulated.answering import Answering, answered
from drivers.ni.simulated.status import DaqmxStatusError
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
