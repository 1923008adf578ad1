"""National Instruments cards.

========================  =============================================================
``modules``               sample rates, range and resolution of input, output and thermocouple modules
``cards``                 what a rig asks of its cards; which channels of a record clip; what a card can refuse and
                        what that calls for
``wiring``                which terminal is connected to what: inputs, with an output or without
``daqmx``                 the cards through NI-DAQmx; inputs that are read without end, for a trigger in software
``connection``            the way there: local driver, server, or simulated server; tasks set up as the wiring says
``simulated``             an NI gRPC Device Server around a computed plate
========================  =============================================================
"""
