"""Filters in the forms in which other programs take them.

===================  ===============================================================
``shipment``         what of a run is exported: filters that follow the temperature
``c_code``           C99: a header and one file; bytes and multiplications on the target
``written_filters``  NPZ, CSV and WAV, ONNX (temperature in, taps out); one form chosen and written
===================  ===============================================================
"""
