"""Declarations that people write: of experiments, their instruments, tests, plates and panels.

=======================  ===============================================================================
``experiment``           what a rig is to acquire, sweep by sweep; its instruments, each checked by the class that
                         its ``kind`` names
``hammer_experiment``    what hits are to be acquired
``instruments``          the instruments that a file declares
``simulation_section``   what the simulated rig is
``hidden_effects``       effects of the simulated rig, checked against the library
``plate``                a declared plate with FRFs or modes of other programs
``modal_test``           files of a modal test, and what their channels are
``panel``                a focusing panel
``run_settings``         options of a run, a table of a TOML file
=======================  ===============================================================================
"""
