"""Looks that the widths of Principled Hair were not fitted to: inputs of the node."""

HELD_OUT = {
    "auburn": dict(Melanin=0.45, Melanin_Redness=0.8, Roughness=0.25, Radial_Roughness=0.35),
    "sand": dict(parametrization="COLOR", Color=(0.55, 0.4, 0.25), Roughness=0.4, Radial_Roughness=0.2, Coat=0.3),
    "umber": dict(Melanin=0.75, Melanin_Redness=0.6, Roughness=0.2, Radial_Roughness=0.6),
}
