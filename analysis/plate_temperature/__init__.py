"""Whether the temperatures of a plate in an oven can be true: the rules, for a rig and for a recorded campaign.

A plate a few millimetres thick is one lump of heat that follows the air with a time constant tau of minutes:

    dp/dt = (air - p) / tau

so the air measured predicts the plate at all times: at rest both are equal, on a ramp the plate is rate * tau
behind.

=================  =====================================================================
``sensor_check``   one sensor over time: frozen, implausible, slowly wrong
``plate_sensors``  all sensors of a plate: which are left out, what the rest say
``resonances``     readings that the shift of all resonances contradicts, whatever the material
``label_check``    recorded sweeps whose temperature air or modulus contradict, in sentences
=================  =====================================================================
"""
