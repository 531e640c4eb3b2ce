"""The equations that a scene makes the run solve, as text, in the words and symbols of the model's sources."""

from studies.scene.blocks import Slider

__all__ = ["contact_equations", "field_equations"]


def field_equations(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the stator's equations for these fields of `fem`."""
    fields = ", ".join({"ux": "u_x", "uy": "u_y", "uz": "u_z"}.get(name, name) for name in names)
    if "phi" not in names:
        return ("div T = -rho omega^2 u,  T = c S", f"fields: {fields}")
    return (
        "div T = -rho omega^2 u,  div D = 0,  T = c S - e^T E,  D = e S + eps E,  E = -grad phi",
        f"fields: {fields}",
    )


def contact_equations(slider: Slider) -> tuple[str, ...]:
    """Return the equations of a slider's contact and motion, without the terms that are zero."""
    spring = (
        "Q = mu P sign(x) [1 - (1 - |x|/x_max)^1.5],  |x| <= x_max = mu E* z / (4 G*)"
        if slider.law == "elastic"
        else "Q(z, x) after Mindlin and Deresiewicz, with memory of the turning points"
    )
    damping = [
        text
        for key, text in (("contact", "chi P z'"), ("normal", "- R_n2 z_s'"))
        if getattr(slider.damping, key)
    ]
    normal = " ".join(["m z_s'' = P", *(f"+ {text}".replace("+ -", "-") for text in damping), "- preload"])
    tangential = (
        "m v_s' = Q"
        + (" - R_t v_s" if slider.damping.tangential else "")
        + (" - load" if slider.load else "")
    )
    return ("P = (4/3) E* sqrt(R) z^1.5", spring, f"{normal},  {tangential}")
