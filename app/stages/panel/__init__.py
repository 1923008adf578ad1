"""What focus, compensate and other stages of a panel are asked, and what they read for it.

======================  ========================================================
``inputs``              panel, method and processor for `focus` and `compensate`
``laws``                material laws of a panel's plate, and their range; a panel that is the plate that was
                        measured
``requests``            what is asked of `focus` and `compensate`, with laws and panel read
======================  ========================================================
"""
