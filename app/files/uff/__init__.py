"""Universal files, as modal software exchanges them.

============  =====================================================================================================
``opening``   one opened, its numbers written as pyuff reads them; its units
``geometry``  header, units, nodes and lines between them, which stand first in a universal file; mode shapes after
              them
``frfs``      FRFs in universal files, read and written
============  =====================================================================================================
"""
