"""Simulated controllers: the drivers' counterparts, byte for byte, around one thermal model.

==================  ======================================================================
``thermal``         heat of air and plate, solved exactly
``regulated_oven``  sensor, regulator and ramp on a clock that is handed in
``controller``      what a controller is to the wire
``modbus_server``   the far end of Modbus RTU
``eurotherm``       Eurotherm 2400 and 3500
``f4t``             Watlow F4T
``votsch``          Vötsch and Weiss, ASCII-2
``espec``           Espec P-300
``memory``          a line inside the process, in virtual time
``modbus_map``      registers as declared
``declared_oven``   what a controller of a declared kind holds: set-point, rate and switch
``scpi``            words as declared
``served``          pseudo-terminal or TCP port
``disturbance``     a bad line
==================  ======================================================================
"""
