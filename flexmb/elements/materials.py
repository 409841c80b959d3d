"""Materials of precision mechanisms, with typical values at room temperature and their sources.

Delivered material differs, most of all in strength and fatigue limit. If a design depends on these values, use the
certificate of the material. ``dataclasses.replace(materials.titanium_6al_4v, strength=900e6)`` is the same material
with another strength. Quantities without a source are left out. Damping is always left out: clamps and surroundings
dissipate more than metal.
"""

from ..lazy import only
from .section import Material

stainless_301 = Material(E=185e9, G=72.3e9, rho=7880.0, nu=0.28, alpha=16.6e-6, strength=965e6, fatigue=552e6)
"""Stainless spring steel strip AISI 301, 1.4310, cold rolled to full hard.

E: thyssenkrupp Materials, 1.4310 by EN 10151, rolled to a tensile strength near 1800 MPa, along the grain (179 GPa near
1300 MPa; 10 GPa more after heat treatment). Strength: least yield stress, ASTM A666 full hard; in compression along the
grain 793 MPa. Fatigue, expansion: Allegheny Ludlum type 301 full hard in ASM's MatWeb, details of the test not stated.
Density: Elgiloy. G = E/(2 (1 + nu)).
"""

stainless_17_7 = Material(E=204e9, G=79.7e9, rho=7800.0, nu=0.28, alpha=11e-6, strength=1030e6)
"""Stainless steel 17-7 PH, 1.4568, hardened to condition TH 1050.

AZoM, grade 17-7 (UNS S17700): nu is 0.27 to 0.30, strength the yield stress. G = E/(2 (1 + nu)).
"""

titanium_6al_4v = Material(E=114e9, G=44e9, rho=4430.0, nu=0.33, alpha=8.6e-6, strength=830e6, fatigue=510e6)
"""Titanium Ti-6Al-4V, grade 5, annealed bar.

Allvac in ASM's MatWeb: strength is the yield stress, fatigue the limit of smooth bars at 1e7 cycles. Expansion:
hardened bar on the same page, 20 to 100 °C.
"""

aluminium_7075 = Material(E=71.7e9, G=26.9e9, rho=2810.0, nu=0.33, alpha=23.6e-6, strength=503e6, fatigue=159e6)
"""Aluminium EN AW-7075, 3.4365, temper T6.

Aluminum Association's typical values (SubsTech, BTI Metals): strength is the yield stress, fatigue the limit of the
rotating beam of R. R. Moore at 5e8 cycles. G = E/(2 (1 + nu)) to the digits given.
"""

copper_beryllium = Material(E=128e9, G=50e9, rho=8250.0, nu=0.28, alpha=17e-6, strength=1000e6)
"""Copper beryllium C17200, CuBe2, temper TH04: rolled hard and age hardened.

Copper Development Association, C17200: moduli 18 500 and 7300 ksi. Strength: least yield stress, ASTM B196. Density and
expansion: ESA's list of preferred materials. nu = E/(2 G) - 1.
"""

invar_36 = Material(E=141e9, G=56e9, rho=8050.0, nu=0.259, alpha=1.3e-6, strength=230e6)
"""Invar 36, 1.3912, annealed.

CarTech, Invar 36: strength is the least yield stress; expansion from 20 to 93 °C. nu = E/(2 G) - 1.
"""

silicon_110 = Material(E=169e9, G=79.6e9, rho=2329.0, nu=0.064, alpha=2.6e-6)
"""Single-crystal silicon, for leaf springs along <110> in a wafer of orientation (100), modelled as isotropic.

Hopcroft, Nix and Kenny (2010), Journal of Microelectromechanical Systems 19, 229. Along <100> E is 130 GPa; across the
wafer nu is 0.36 and 0.28, and the shear in its plane has G = 50.9 GPa. Its strength depends on the surface and on the
size, from below 300 MPa to some GPa. No strength is stated here: use the strength of your process.
"""

fused_silica = Material(E=73e9, G=31.2e9, rho=2200.0, nu=0.17, alpha=0.5e-6, strength=50e6)
"""Fused silica. Brittle: strength is the tensile stress at which polished parts may break; drawn fibres bear far more.

MakeItFrom, fused quartz. G = E/(2 (1 + nu)).
"""


__all__, __dir__ = only(globals(), lambda value: isinstance(value, Material))
