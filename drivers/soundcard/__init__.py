"""A sound card as output and inputs: what everybody owns, with one clock for both.

==============  =================================================================
``card``        its channels and full scales as declared; a sweep through the package ``sounddevice``
``simulated``   a stand-in for that package around a plate
==============  =================================================================
"""
