"""Preparation of a campaign for a fit: each sweep as a few hundred independent numbers of checked variance.

=====================  ==================================================================================
``compression``        one sweep as spline coefficients, without loss
``noise``              stated noise compared with the scatter between neighbouring lines, without a model; check
                       that the twin's discretisation error is small enough
``groups``             sweeps at one nominal temperature, which share the laws there; how the laws run on from it
``sweeps``             the prepared campaign as one value, with weights along and across a direction; with wider
                       resonances
``preparation``        from FRFs to that value
=====================  ==================================================================================
"""
