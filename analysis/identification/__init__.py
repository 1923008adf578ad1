"""Poles and residues of FRFs, tracked over temperature.

=========================  ==================================================================
``automatic``              identification of FRFs with common poles: search, model order, status
``settings``               limits of the search, band, residual terms, mains frequency
``finishing``              final model order by `order`, last fit on all lines, errors at the peaks, status
``peak_picking``           the paper's own recipe: local peaks, then wide-band refinement
``tracking``               modes of all sweeps, tracked over temperature
``tracks_without_twin``    tracks found in the sweeps themselves: poles of one sweep followed to the others
``expected_modes``         sweeps fitted with a twin's modes as priors, numbered as in the twin
``smooth_tracks``          smooth dependence of poles on temperature: prior of the joint fit
``joint_fit``              joint fit of poles and tracks of all sweeps, with standard deviations
``sweep_fits``             modes of every sweep from the joint fit, with their status
``hidden_modes``           modes that only all sweeps together show; tracks that they do not support
``modes``                  poles, residues and residual terms of one sweep; synthesis of its FRFs
``tracked_modes``          modes of all sweeps and their tracks
``stated_temperature``     modes at the temperature stated for a sweep, where the sine passed them at another
``leakage``                leakage of windowed segments, taken out of modes
``reading``                frequency and damping of a pole, hysteretic or viscous
``status``                 which poles are modes of the plate, and why the others are not
``pole_residue``           the model: columns, derivatives, synthesis
``residual_terms``         contribution of the modes outside the band
``measured``               measured FRFs of one condition, their variances or noise estimated from a residual
``lines``                  measured lines with their weights
``weighted_lines``         sums over weighted lines, for the inner products of pole columns
``averaging``              fewer lines for the search
``running_median``         a running median along frequency
``confirmation``           modes found again with other bands, lines or channels, or in neighbouring sweeps
``single_hits``            modes that rest on one hit of several
``damping_prior``          distribution of the modes' damping ratios, used as a prior
``parameters``             poles as parameters of a search, with bounds
``variable_projection``    residues eliminated: misfit, gradient and Hessian of the poles alone
``normal_equations``       the triangular factor of a weighted least-squares problem
``pole_search``            least squares over the poles
``vector_fitting``         start poles without an initial guess
``order``                  how many poles: backward elimination by BIC, its penalty for one pole; residual terms
``resolution``             pairs of poles that the frequency resolution cannot separate
``principal_frfs``         a few sums of many FRFs, on which the poles are searched
``missing``                poles found in the residual and added; one pole replaced by two close ones
``harmonics``              lines disturbed by mains harmonics or other tones
``synthetic``              synthetic FRFs with known poles for tests (R10)
=========================  ==================================================================
"""
