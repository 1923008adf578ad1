"""Physical effects of real plates and rigs that a twin without effects lacks, one per file.

`effect` defines the class, `library` lists all effects in the order of application, loads a user's
own and checks the requirements on every effect. By what they change:

- temperature over the plate: `thermal_lag`, `thermal_gradient`, `thermal_crown`, `draught_gradient`
- shape: `thickness_taper`, `thickness_crown`, `sensor_offset`
- stiffness and mass: `orthotropy`, `transverse_shear`, `modulus_gradient`, `density_gradient`, `local_damage`,
  `damage_size`, `annealing`, `amplitude_softening`
- loss: `loss_orthotropy`, `poisson_loss`, `damping_dispersion`, `viscoelastic_dispersion`, `fractional_viscosity`,
  `relaxation`
- patches: `bond_shear_lag`, `patch_debond`, `patch_loss`, `permittivity_drift`, `depolarization`
- normal motion at declared points and all over: `suspension`, `string_mass`, `point_mass`, `cable_stiffness`,
  `accelerometer_mass`, `air_loading`, `elastic_foundation`, `surface_damping`
- normal motion at places to be found: `mass_at_place`, `spring_at_place`, `dashpot_at_place`,
  `resonator_at_place`; two masses or two springs of that kind are candidates of `library`
- curves without a formula, for the description of what has no name: `free_curves`
- signals: `piezo_drift`, `piezo_loss`, `piezo_nonlinearity`, `insulation_leak`, `channel_skew`, `high_pass`,
  `low_pass`, `mounting_resonance`, `feedthrough`, `crosstalk`
"""
