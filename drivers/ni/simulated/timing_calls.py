"""Calls on a task's sample clock and start trigger."""

from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb

from drivers.ni.simulated.answering import Answering, answered


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
