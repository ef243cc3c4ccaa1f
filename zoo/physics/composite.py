"""What a potted winding conducts, from its glass and its glue."""

from __future__ import annotations

from torch import Tensor

GLASS_W_PER_M_K = 1.38
"""Fused silica at room temperature (Incropera, table A.2)."""


def transverse_conductivity(glass: Tensor, matrix: Tensor, fraction: Tensor) -> Tensor:
    """k⊥ across parallel fibres, k_m·(k_f + k_m + φ(k_f − k_m))/(k_f + k_m − φ(k_f − k_m)) [W/m/K].

    Exact for thinly spread fibres and the lower one of the Hashin–Shtrikman bounds where glass conducts better (Hashin 1983, J. Appl. Mech. 50:481).

    Args:
        glass: (...) k_f [W/m/K].
        matrix: (...) k_m of coating and glue [W/m/K].
        fraction: (...) φ, share of the glass in the volume, 0 … 1.
    """
    more = fraction * (glass - matrix)
    return matrix * (glass + matrix + more) / (glass + matrix - more)


def longitudinal_conductivity(glass: Tensor, matrix: Tensor, fraction: Tensor) -> Tensor:
    """k∥ along the fibres, φ·k_f + (1 − φ)·k_m [W/m/K]; arguments as in `transverse_conductivity`."""
    return fraction * glass + (1 - fraction) * matrix
