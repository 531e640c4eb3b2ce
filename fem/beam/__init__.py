"""The field of finite apertures and of forces on strips in three dimensions, from charges, forces and guided modes.

electrode_charges - line_source, cut_source (modes sent by a line of charge or force) - emitters (sums of the waves of
all charges or forces) - lateral (integral over k_y) - own_aperture (a transducer's response to its own charges) -
reception (of beams by other transducers) - faces (reflecting ends) - surface_beam (where charges and forces become a
beam) - from_section (the beam of a solved section, forces beside transducers) - rows, mutual_admittance, crossed_beam
(turned transducers).
"""
