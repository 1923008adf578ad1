"""Simulated controllers: the drivers' counterparts, byte for byte, around one thermal model.

==================  ======================================================================
``thermal``         heat of air and plate, solved exactly
``regulated_oven``  sensor, regulator and ramp on a clock that is handed in
``controller``      what a controller is to the wire, and a wire inside the process
``modbus_server``   the far end of Modbus RTU
``eurotherm``       Eurotherm 2400 and 3500
``f4t``             Watlow F4T
``votsch``          Vötsch and Weiss, ASCII-2
``espec``           Espec P-300
``declared_oven``   controllers with the registers, or the words, that a file declares
``served``          pseudo-terminal or TCP port
``disturbance``     a bad line
==================  ======================================================================
"""
