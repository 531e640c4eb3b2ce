"""Questions about the field of the stator: free wave, admittance, response, dispersion and cell parameters."""
