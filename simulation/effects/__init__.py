"""What real plates and rigs do that a plain twin does not, one effect in a file.

`effect` says what an effect is, `library` holds all of them in the order in which they act, `user_folder` loads a
user's own and `verification` checks what every effect must do. By what they change:

- temperature over the plate: `thermal_lag`, `thermal_gradient`, `draught_gradient`
- shape: `thickness_taper`, `sensor_offset`
- stiffness and loss: `orthotropy`, `viscoelastic_dispersion`, `damping_dispersion`, `amplitude_softening`,
  `local_damage`, `bond_shear_lag`
- normal motion: `suspension`, `point_mass`, `air_loading`
- signals: `piezo_drift`, `channel_skew`, `high_pass`, `feedthrough`
"""
