"""An NI gRPC Device Server without National Instruments: the rig's cards around a computed plate.

The public ``nidaqmx`` package speaks to it as to the real server, unmodified, over a channel inside
this process or over a loopback port. Its time is virtual and moves only when somebody waits for
samples, so hours pass in seconds and no wait is ever too short.

==================  =================================================================
``surroundings``    what hangs on the cards: a plate, its temperature, the wires
``faults``          what is to go wrong, and when
``status``          the driver's refusals
``output_line``     the voltage on an output, at any time
``input_stage``     what an input module makes of a voltage
``task``            what a program has asked of a task
``chassis``         the modules in their slots, who has reserved them, what triggers what
``sample_clocks``   what paces a task, and how far off its crystal is
``acquisition``     samples of a running input task
``servicer``        the server: every call the rig's driver and a plain script make
``task_calls``      … its calls on tasks
``channel_calls``   … on channels and their settings
``stream_calls``    … that read and write samples
``waveform_calls``  … that move codes and waveforms
``timing_calls``    … on sample clocks and start triggers
``system_calls``    … that ask what there is
``event_calls``     … that wait for events
``refusals``        … and every other, refused by its name
``answering``       how each call is counted, locked, made to fail and answered
``in_process``      a gRPC channel without a network
``loopback``        the same server on a port of this computer, and no other
==================  =================================================================
"""
