"""Arrays in, values out: what a measurement means, with no hardware, no mesh and no screen.

=====================  ============================================================================
``experiment``         the plate, its patches, the electronics and the protocol, as declared
``declaration``        its parts: plate, patches, supports, materials, tolerances
``geometry``           curves and closed loops
``channel``            inputs and outputs, their names and units
``recordings``         recorded sweeps, FRFs made of them and their noise
``estimation``         H1, H2, Hv and hammer tests: signals of any test to FRFs
``labelled``           arrays with named axes, for xarray and pandas
``drawn_curves``       curves as they can be drawn: the phase of an FRF, lines with gaps
``material``           E(T), nu(T), eta(T) with their bands, through a table of values, and near one temperature
``estimates``          what a fit found, with standard deviations: a parameter, laws, a sheet's moduli and losses
                       by direction, what is declared
``updated``            result of model updating
``effect_card``        a physical effect without any physics: parameters, ranges, priors
``twin_model``         what a twin must offer to be fitted to data; one with some effects switched on for good
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
``thermometry``        a panel as its own thermometer: readings of stretches, and readings tracked over time
``arrays``             types of arrays
``checked_fields``     shape, finiteness, range and order of a value's fields
``scatter``            scatter of numbers that are known with different errors
``progress``           type of a progress callable
``forked``             independent work on all processors, by copies of the process
=====================  ============================================================================
"""

__version__ = "0.4.0"
