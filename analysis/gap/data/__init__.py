"""Campaign prepared for a fit: each sweep as a few hundred independent numbers with checked noise.

=====================  ==================================================================================
``compression``        one sweep as spline coefficients, without loss
``noise``              stated noise compared with the scatter between neighbouring lines, without a model
``groups``             sweeps at one nominal temperature, which share the laws there
``numerical_floor``    discretisation error of the twin, and whether it is small enough
``sweeps``             all of these for one campaign, as one value
``preparation``        from FRFs to that value
=====================  ==================================================================================
"""
