"""Simulated controllers: the drivers' counterparts, byte for byte, around one thermal model.

==================  ======================================================================
``regulated_oven``  the oven itself: heat in it and in a plate, sensor, regulator and ramp
``controller``      what a controller is to the wire, and a wire inside the process; the far end of Modbus RTU
``eurotherm``       Eurotherm 2400 and 3500
``f4t``             Watlow F4T
``votsch``          Vötsch and Weiss, ASCII-2
``espec``           Espec P-300
``declared_oven``   controllers with the registers, or the words, that a file declares
==================  ======================================================================
"""
