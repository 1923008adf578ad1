"""A panel small enough to be reduced in seconds, and the target and filters of such panels."""

TARGET_AND_FILTERS = """\
[target]
center = [0.3, 0.55]
size = [0.25, 0.3]

[filters]
taps = 64
sample_rate = 4000.0
band = [100.0, 300.0]
edges = [60.0, 360.0]
transform_length = 512
delay = 32
"""
PANEL = f"""\
format = "panel/1"
title = "two patches"
grid = [20, 16]

[plate]
length_x = 0.24
length_y = 0.19
thickness = 0.003
mass = 0.12996
boundary = "clamped"

[[patch]]
id = "A1"
role = "actuator"
center = [0.07, 0.1]
size = [0.02, 0.02]
thickness = 0.0005

[[patch]]
id = "A2"
role = "actuator"
center = [0.15, 0.1]
size = [0.02, 0.02]
thickness = 0.0005

{TARGET_AND_FILTERS}
[twin]
youngs_modulus = [0.9e9, 3.4e9]
poisson_ratio = [0.33, 0.46]
loss_factor = [0.05, 0.09]
function_tolerance = 1e-6
basis_tolerance = 1e-2
"""
