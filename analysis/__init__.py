"""Arrays in, values out: what a measurement means, with no hardware, no mesh and no screen.

=====================  ============================================================================
``experiment``         the plate, its patches, the electronics and the protocol, as declared
``declared``           what every declared value has in common
``tolerances``         how exactly what is declared is known: lengths, patches, wiring, the thermometer
``declared_quantity``  what a fit found about it, and the budget of a standard deviation
``plate``, ``patch``   each of these by itself: ``outline``, ``support``
``plate_parts``        whether parts of a plate fit together
``plate_material``     material of a plate, isotropic or orthotropic, and ranges of common ones by name
``sheet_orthotropy``   orthotropic sheets, as declared
``sheet_material``     their moduli and losses by direction, as estimated
``foreign_mesh``       a mesh made elsewhere
``geometry``           curves and closed loops
``transducers``        drives and sensors that are no patches
``channel``            inputs and outputs, their names and units
``campaign``           recorded sweeps of one experiment over temperature, their volts in units of the plate
``frf_campaign``       FRFs of other programs in place of recorded sweeps
``measured_modes``     natural frequencies and damping over temperature
``h1``                 H1 of synchronous repeats, its noise, and how far resonances move over the repeats
``noise_power``        power of the noise of an FRF at each line, with repeats or without
``estimation``         H1, H2, Hv and hammer tests: signals of any test to FRFs
``frf``                FRFs of a campaign, coherence and variance per line
``labelled``           arrays with named axes, for xarray and pandas
``drawn_curves``       curves as they can be drawn: the phase of an FRF, lines with gaps
``chosen_actuator``    sweeps of one of several actuators
``mains``              lines that mains hum takes
``grid_frequency``     what is accepted as its frequency
``material``           E(T), nu(T), eta(T) with their bands; laws through a table of values
``estimates``          a parameter or laws with standard deviations
``updated``            result of model updating
``local_laws``         the same near one temperature
``sweep_point``        temperature, its rate and the drive's level of one sweep
``effect_card``        a physical effect without any physics: parameters, ranges, priors
``twin_model``         what a twin must offer to be fitted to data
``held_effects``       a twin with some effects switched on for good
``plate_temperature``  whether the temperatures of a plate in an oven can be true
``protocol``           what is to be measured, and what a good measurement is
``identification``     poles and residues of FRFs, tracked over temperature
``shapes``             mode shapes at many places, and how they are judged
``pairing``            measured modes beside those of a twin, and whether it is a fit
``updating``           material parameters of a twin fitted to measured FRFs
``gap``                which effect the twin lacks
``fleet``              many pieces of one kind: scatter, outliers, prediction
``focusing``           STIF filters, contrast and spot error
``compensation``       filters at any temperature: Bayesian-regularised networks and their rivals
``radiation``          sound of a vibrating plate: pressure, power, directivity
``rendering``          sound through filters that follow the temperature
``weather``            a panel whose temperature is a field that moves
``health``             what has changed on a panel since its baseline
``thermometry``        a panel as its own thermometer
``arrays``             types of arrays
``checked_fields``     shape, finiteness, range and order of a value's fields
``scatter``            scatter of numbers that are known with different errors
``progress``           type of a progress callable
=====================  ============================================================================
"""

__version__ = "0.3.0"
