"""Thermometers on the plate that are no thermocouple of the cards.

===============  =======================================================
``thermometer``  what every thermometer can do
``settings``     the declared thermometer, and where its kinds are found
``points``       a thermometer of which only its values are known
``modbus_map``   the kind made of declared registers
``scpi``         the kind made of declared queries
===============  =======================================================
"""
