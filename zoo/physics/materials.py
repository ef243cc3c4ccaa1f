"""How the matter of a gyro stores and passes heat between −60 and 80 °C, as multiples of what it does at 20 °C."""

from __future__ import annotations

from torch import Tensor

ZERO_C_IN_K = 273.15
REFERENCE_K = 293.15


def silica_capacity(celsius: Tensor) -> Tensor:
    """Specific heat of silica glass: the parabola through 543, 745 and 905 J/kg/K at 200, 300 and 400 K; 0.84 at −40 °C, 1.10 at 60 °C.

    543 of NBS Monograph 21 (Corruccini & Gniewek 1960), the others of Incropera, table A.2. Quartz, the crystal, has 742 and 889 at 298 and 400 K
    (Chase 1998, in NIST's WebBook).
    """
    return _parabola(celsius, 2.509e-3, -2.87e-6)


def polymer_capacity(celsius: Tensor) -> Tensor:
    """Specific heat of coating and glue below their glass transition, 0.3 %/K of that at 298 K (van Krevelen, Properties of Polymers, ch. 5).

    Polymethyl methacrylate has 0.4 %/K from 260 to 300 K (NIST's WebBook). Beyond its glass transition, as a rubber, a polymer has 0.12 %/K, after
    a rise by some fifth at once, which this leaves out.
    """
    return _parabola(celsius, 3.045e-3, 0.0)


def metal_capacity(celsius: Tensor) -> Tensor:
    """Specific heat of aluminium: the parabola through 798, 903 and 949 J/kg/K at 200, 300 and 400 K (Incropera, table A.1)."""
    return _parabola(celsius, 8.86e-4, -3.29e-6)


def silica_conductivity(celsius: Tensor) -> Tensor:
    """Conductivity of silica glass: 1.20, 1.30 and 1.40 W/m/K at −50, 0 and 50 °C (CRC Handbook of Chemistry and Physics, section 12)."""
    return _parabola(celsius, 1.493e-3, 0.0)


def polymer_conductivity(celsius: Tensor) -> Tensor:
    """Conductivity of an amorphous polymer below its glass transition, as T^0.22 (Bicerano, Prediction of Polymer Properties, ch. 14)."""
    return _kelvin(celsius) ** 0.22


def air_conductivity(celsius: Tensor) -> Tensor:
    """Conductivity of air, as T^0.9: 22.3, 26.3 and 30.0 mW/m/K at 250, 300 and 350 K (Incropera, table A.4)."""
    return _kelvin(celsius) ** 0.9


def radiation(celsius: Tensor) -> Tensor:
    """Film 4εσT³ of a surface among others of about its own temperature; 0.50 at −40 °C, 1.47 at 60 °C."""
    return _kelvin(celsius) ** 3


def _parabola(celsius: Tensor, slope: float, curvature: float) -> Tensor:
    above = celsius + ZERO_C_IN_K - REFERENCE_K
    return 1 + (slope + curvature * above) * above


def _kelvin(celsius: Tensor) -> Tensor:
    return (celsius + ZERO_C_IN_K) / REFERENCE_K
