"""Thermometers on the plate that are no thermocouple of the cards.

========================  =======================================================
``thermometer``           what every thermometer can do and declares, and where its kinds are found
``declared_thermometer``  the kinds made of declared registers or queries
========================  =======================================================
"""
