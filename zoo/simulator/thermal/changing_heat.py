"""Heat in one gyro whose coefficients follow its temperatures: the balance itself, as a solver of stiff equations wants it.

For `zoo.simulator.thermal.coefficients`, which shows what constant ones cost.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.physics.conduction import Pack
from zoo.physics.lumps import Lumps
from zoo.physics.materials import metal_capacity
from zoo.simulator.gyros.device import Device
from zoo.simulator.thermal.coefficients import RADIATED, gap_film, housing_film, winding_capacity, winding_conductivity
from zoo.simulator.thermal.heat import HOUSING, SPOOL, WATCHED, Heat, body, watched
from zoo.units import SECONDS_PER_MINUTE


@dataclass(frozen=True, eq=False)
class Balance:
    """Housing, spool and, layer by layer with both faces, winding; conductances are at the mean temperature of their ends, flanges at the layer's.

    Attributes:
        device: with coefficients of 20 °C.
        pack: its winding, at 20 °C.
        lumps: housing and spool, at 20 °C.
        radiated: share of radiation in the film of the housing at 20 °C.
    """

    device: Device
    pack: Pack
    lumps: Lumps
    radiated: float = RADIATED

    def rates(self, temperature: Tensor, air: Tensor) -> Tensor:
        """Rate of every part.

        Args:
            temperature: (M, 2 + N) of housing, spool and the winding's nodes from the inside, at M moments [°C].
            air: () or (M,) [°C].

        Returns:
            (M, 2 + N) [K/s].
        """
        housing, spool, winding = temperature[..., HOUSING], temperature[..., SPOOL], temperature[..., 2:]
        film = self.lumps.ambient[..., HOUSING, 0] * housing_film((air + housing) / 2, self.radiated) * (air - housing)
        mount = self.lumps.link[..., HOUSING, SPOOL] * (housing - spool)
        inner, outer, ends = self._faces(housing, spool, winding)
        into_housing = film + self.lumps.power[..., HOUSING] - mount - outer
        into_spool = mount - inner - ends.sum(-1)
        into_winding = ends + self._within(winding)
        edges = torch.cat([inner.unsqueeze(-1), torch.zeros_like(winding[..., 1:-1]), outer.unsqueeze(-1)], -1)
        into = torch.cat([torch.stack([into_housing, into_spool], -1), into_winding + edges], -1)
        return into / self.capacity(temperature)

    def seen(self, temperature: Tensor, air: Tensor) -> Heat:
        """What `heat` gives, of the same gyro as a batch of one.

        Args:
            temperature: (T, 2 + N) as for `rates`.
            air: (T,) [°C].
        """
        asked = watched([self.device], air)
        rates = SECONDS_PER_MINUTE * self.rates(temperature, air)
        weights = torch.cat([asked.lumps[0], torch.nn.functional.pad(asked.turns[0].sum(-1), (1, 1))], -1)
        found = [(rates if is_rate else temperature) @ weight for weight, is_rate in zip(weights, asked.is_rate, strict=True)]
        return Heat(air, **{name: one.unsqueeze(0) for name, one in zip(WATCHED, found, strict=True)})

    def _height(self) -> Tensor:
        return self.pack.turn_pitch_m * self.pack.turns

    def capacity(self, temperature: Tensor) -> Tensor:
        """What every part stores: (M, 2 + N) [°C] -> (M, 2 + N) [J/K]."""
        cells = self.pack.heat_capacity * self.pack.across.volume * self._height()
        metal = self.lumps.capacity * metal_capacity(temperature[..., :2])
        return torch.cat([metal, cells * winding_capacity(self.device, temperature[..., 2:])], -1)

    def _within(self, winding: Tensor) -> Tensor:
        """(M, N) heat that reaches each node from its neighbours [W]."""
        middle = (winding[..., 1:] + winding[..., :-1]) / 2
        conductance = self.pack.conductivity * winding_conductivity(self.device, middle) * self.pack.across.link * self._height()
        inward = conductance * torch.diff(winding)
        nothing = torch.zeros_like(inward[..., :1])
        return torch.cat([inward, nothing], -1) - torch.cat([nothing, inward], -1)

    def _faces(self, housing: Tensor, spool: Tensor, winding: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """(M,), (M,), (M, N) heat that enters through the inner and the outer face, and each layer from the flanges [W]."""
        films, cells, height = self.pack.films, self.pack.across, self._height()
        inner = films[..., 0] * cells.area[..., 0] * height * (spool - winding[..., 0])
        gap = gap_film((housing + winding[..., -1]) / 2)
        outer = films[..., 1] * gap * cells.area[..., 1] * height * (housing - winding[..., -1])
        conductivity = self.pack.conductivity * winding_conductivity(self.device, winding)
        through = sum(films[..., face] / (1 + films[..., face] * height / (6 * conductivity)) for face in (2, 3))
        return inner, outer, through * cells.volume * (spool.unsqueeze(-1) - winding)


def balance(device: Device, radiated: float = RADIATED) -> Balance:
    """The balance of one gyro.

    Args:
        device: with coefficients of 20 °C.
        radiated: share of radiation in the film of the housing at 20 °C.
    """
    return Balance(device, *body([device], torch.zeros(1, dtype=torch.float64)), radiated)
