"""Parts of an experiment as they are declared; `analysis.experiment` holds them.

==================  ================================================================================
``plate``           the plate, and a mesh of it made elsewhere
``outline``         closed outlines of plates, holes and zones, and whether they fit together; what holds a plate
``plate_material``  material of a plate, isotropic or orthotropic, and ranges of common ones by name
``transducers``     drives and sensors: patches, and those that are none
``tolerances``      how exactly what is declared is known: lengths, patches, wiring, the thermometer
``strict``          what every declared value has in common
==================  ================================================================================
"""
