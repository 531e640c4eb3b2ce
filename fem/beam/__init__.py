"""The field of finite apertures and of forces on strips in three dimensions, from charges, forces and guided modes.

charges (of the electrodes) - line_source, cut_source (modes sent by a line of charge or of force) - lateral (integral
over k_y) - own_aperture (a transducer's response to its own charges) - reception (of beams by other transducers) -
faces (reflecting ends) - surface_beam (where charges and forces become a beam) - rows, mutual_admittance, crossed_beam
(turned transducers).
"""
