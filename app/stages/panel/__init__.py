"""What focus, compensate and other stages of a panel are asked, and what they read for it.

======================  ========================================================
``inputs``              panel, method and processor for `focus` and `compensate`
``laws``                material laws of a panel's plate, and their range
``measured_plate``      a panel that is the plate that was measured
``focus_request``       what is asked of `focus`, with laws and panel read
``compensate_request``  what is asked of `compensate`, with laws and panel read
======================  ========================================================
"""
