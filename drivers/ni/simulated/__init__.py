"""An NI gRPC Device Server without National Instruments: the rig's cards around a computed plate.

The public ``nidaqmx`` package speaks to it as to the real server, unmodified, over a channel inside
this process or over a loopback port. Its time is virtual and moves only when somebody waits for
samples, so hours pass in seconds and no wait is ever too short.

==================  =================================================================
``surroundings``    what hangs on the cards: a plate, its temperature, the wires
``faults``          what is to go wrong, and when; the driver's refusals
``task``            what a program has asked of a task
``chassis``         the modules in their slots, who has reserved them, what paces and triggers what
``acquisition``     samples of a running input task
``servicer``        the server: every call the rig's driver and a plain script make, and every other refused; on a
                    port of this computer, and no other; a gRPC channel without a network
``task_calls``      … its calls on tasks, their clocks, start triggers and events
``channel_calls``   … on channels and their settings, and that ask what there is
``stream_calls``    … that read and write samples, codes and waveforms
``answering``       how each call is counted, locked, made to fail and answered
==================  =================================================================
"""
