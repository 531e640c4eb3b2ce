"""The field of finite apertures and of forces on strips in three dimensions, from charges, forces and guided modes.

lateral (integral over k_y) - line_source, cut_source (modes sent by a line of charge or force) - beam_of_charges
(charges and forces become a beam) - electrode_charges (of a solved section) - faces (reflecting ends) -
point_potential, own_aperture (a transducer's response to waves and its own charges) - reception (of beams by other
transducers) - surface_beam (motion and its error) - beam_of_section (the beam of a solved section, forces beside
transducers) - parallel_groups, crossed_beam (rotated transducers).
"""
