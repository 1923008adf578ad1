"""Arrays in, values out: what a measurement means, with no hardware, no mesh and no screen.

=====================  =====================================================================
``experiment``         the plate, its patches, the electronics and the protocol, as declared
``plate``, ``patch``   each of these by itself: ``outline``, ``support``, ``curvature``, ``layout``
``foreign_mesh``       a mesh made elsewhere
``geometry``           curves and closed loops
``transducers``        drives and sensors that are no patches
``channel``            inputs and outputs, their names and units
``campaign``           recorded sweeps of one experiment over temperature
``h1``                 H1 of synchronous repeats
``frf``                FRFs of a campaign, coherence and variance per line
``mains``              lines that mains hum takes
``material``           E(T), nu(T), eta(T) with their bands
``local_laws``         the same near one temperature
``sweep_point``        temperature, its rate and the drive's level of one sweep
``effect_card``        a physical effect without any physics: parameters, ranges, priors
``twin_model``         what a twin must offer to be fitted to data
``identification``     poles and residues of FRFs, tracked over temperature
``updating``           material parameters of a twin fitted to measured FRFs
``focusing``           STIF filters, contrast and spot error
``compensation``       filters at any temperature: Bayesian-regularised networks and their rivals
=====================  =====================================================================
"""

__version__ = "0.1.0"
