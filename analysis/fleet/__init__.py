"""A fleet: many pieces of one kind of panel, their laws beside one another.

================  ======================================================================================
``scatter``       mean law, scatter between pieces and within each, pieces that do not belong to the others
================  ======================================================================================
"""
