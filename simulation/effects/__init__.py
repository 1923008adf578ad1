"""Physical effects of real plates and rigs that a twin without effects lacks, one per file.

`effect` defines the class, `library` lists all effects in the order of application, `user_folder` loads a user's
own and `verification` checks the requirements on every effect. By what they change:

- temperature over the plate: `thermal_lag`, `thermal_gradient`, `draught_gradient`
- shape: `thickness_taper`, `sensor_offset`
- stiffness and loss: `orthotropy`, `viscoelastic_dispersion`, `damping_dispersion`, `amplitude_softening`,
  `local_damage`, `bond_shear_lag`
- normal motion: `suspension`, `point_mass`, `air_loading`
- signals: `piezo_drift`, `channel_skew`, `high_pass`, `feedthrough`
"""
