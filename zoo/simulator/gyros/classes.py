"""Three classes of gyros by their accuracy."""

from __future__ import annotations

from dataclasses import replace

from zoo.simulator.gyros.gyro_class import GyroClass
from zoo.simulator.streams import Span

# Of the laboratory, the same for gyros of any class: a fixture's twist of 0.06 to 1″/K at 1 K/min, 1″/min being 0.0167 °/h.
TWIST = (0.001, 0.017)

MEDIUM = GyroClass(
    name="medium",
    layers=32,
    turns=48,
    pattern="quadrupolar",
    diameter_m=Span(0.07, 0.12, "m", source="with these turns, coils of 340 to 580 m"),
    layer_pitch_m=Span(0.20e-3, 0.24e-3, "m", source="fibre of 165 to 250 µm, nested"),
    turn_pitch_m=Span(0.22e-3, 0.28e-3, "m", source="fibre of 165 to 250 µm, side by side"),
    housing_j_per_k=Span(400.0, 900.0, "J/K"),
    spool_j_per_k=Span(60.0, 150.0, "J/K"),
    package_s=Span(600.0, 2400.0, "s"),
    winding_error_turns=Span(0.3, 1.5, "1"),
    trimmed=Span(0.0, 0.0, "1", log=False),
    lead_asymmetry_m=Span(0.0, 0.0, "m", log=False, source="leads cut to the same length; half a metre is worth as much as all of the winding"),
    index=Span(1.452, 1.452, "1", source="pure silica core at 1310 to 1550 nm is 1.444 to 1.447; a doped one 1.45"),
    thermo_optic_per_k=Span(9.4e-6, 9.4e-6, "1/K", source="dn/dT 8.6e-6, Rego 2023, Sensors 23:6023; n·α 0.8e-6"),
    glass_fraction=Span(0.22, 0.31, "1", source="125 µm in 250 µm packed in squares: 0.20, in hexagons 0.23; 80 µm in 135 µm: 0.31"),
    glue_conductivity=Span(0.17, 0.23, "W/m/K", source="acrylate and epoxy 0.17 to 0.3"),
    conductivity=Span(0.0, 0.0, "W/m/K", log=False, source="0: Hashin 1983, J. Appl. Mech. 50:481, from glass and glue"),
    heat_capacity=Span(1.6e6, 1.8e6, "J/m^3/K", source="silica 1.63e6, acrylate 1.5e6 to 2e6"),
    mount_s=Span(40.0, 160.0, "s"),
    contact=Span(100.0, 500.0, "W/m^2/K"),
    top_contact=Span(0.0, 0.0, "W/m^2/K", log=False),
    gap=Span(5.0, 30.0, "W/m^2/K", source="natural convection and radiation"),
    self_heating_k=Span(3.0, 12.0, "K", source="1 to 15 W"),
    power_at_spool=Span(0.0, 0.0, "1", log=False, source="electronics on the housing's floor"),
    sensor_s=Span(10.0, 120.0, "s"),
    sensor_offset_c=Span(-0.3, 0.3, "K", log=False, source="digital thermometers' data sheets: ±0.5 °C at most"),
    sensor_heating_k=Span(0.05, 0.3, "K"),
    cold_loss_db=Span(0.2, 1.5, "dB", source="microbending of coatings in the cold"),
    random_walk=Span(0.002, 0.01, "°/√h", source="0.0056 in Karagöz 2024, Photonics 11:1057"),
    flicker=Span(0.003, 0.02, "°/h"),
    rate_random_walk=Span(0.001, 0.01, "°/h/√h"),
    effects={
        "static_bias": (5e-4, 5e-3),
        "mohr": (0.02, 0.3),
        "rate_temperature_coupling": (1e-4, 3e-3),
        "sensor_lag": (5e-4, 5e-3),
        "hysteresis": (0.01, 0.1),  # half-width of the loop a fifth of that: 0.002 to 0.02 °/h
        "polarization": (0.002, 0.03),
        "warm_up": (0.02, 0.3),
        "aging": (0.005, 0.05),
        "bias_step": (0.005, 0.05),
        "magnetic": (2e-4, 5e-3),
        "supply_voltage": (0.02, 0.4),
        "scale_factor": (2.0, 50.0),
        "scale_factor_nonlinearity": (8e-11, 4e-10),
        "thermal_gradient": (0.008, 0.1),  # Mohr's plateau where the housing leads the coil by 2 to 3.3 K at 1 K/min
        "glass_transition": (0.02, 0.6),  # C_M once to three times itself
        "viscoelastic": (0.006, 0.1),  # 0.002 to 0.03 °/h after 60 K that relax by 0.3 K/min
        "moisture": (0.01, 0.1),
        "misalignment": (5e-6, 5e-5),  # 0.5 to 5 µrad/K of a horizontal Earth rate of 10 °/h
        "fixture_rotation": TWIST,
        "chamber_cycling": (0.001, 0.02),
        "dead_band": (0.01, 0.1),
    },
)
TACTICAL = replace(
    MEDIUM,
    name="tactical",
    layers=24,
    turns=32,
    diameter_m=Span(0.03, 0.06, "m", source="with these turns, coils of 70 to 150 m"),
    layer_pitch_m=Span(0.16e-3, 0.24e-3, "m", source="fibre of 165 to 250 µm, nested"),
    winding_error_turns=Span(0.5, 4.0, "1"),
    housing_j_per_k=Span(80.0, 250.0, "J/K"),
    spool_j_per_k=Span(10.0, 40.0, "J/K"),
    package_s=Span(180.0, 900.0, "s"),
    random_walk=Span(0.01, 0.05, "°/√h"),
    flicker=Span(0.05, 0.3, "°/h"),
    rate_random_walk=Span(0.01, 0.1, "°/h/√h"),
    effects={
        "static_bias": (0.01, 0.1),
        "mohr": (0.1, 2.0),
        "rate_temperature_coupling": (1e-3, 2e-2),
        "sensor_lag": (0.01, 0.1),
        "hysteresis": (0.25, 2.5),
        "polarization": (0.02, 0.5),
        "warm_up": (0.3, 3.0),
        "aging": (0.05, 0.5),
        "bias_step": (0.05, 0.5),
        "magnetic": (5e-3, 5e-2),
        "supply_voltage": (0.4, 8.0),
        "scale_factor": (20.0, 450.0),
        "scale_factor_nonlinearity": (4e-8, 3.5e-7),
        "thermal_gradient": (0.04, 0.8),
        "glass_transition": (0.1, 4.0),
        "viscoelastic": (0.06, 1.7),
        "moisture": (0.03, 0.3),
        "misalignment": (2e-5, 2e-4),
        "fixture_rotation": TWIST,
        "chamber_cycling": (0.01, 0.2),
        "dead_band": (0.01, 0.1),
    },
)
NAVIGATION = replace(
    MEDIUM,
    name="navigation",
    layers=64,
    turns=64,
    pattern="octupolar",
    diameter_m=Span(0.10, 0.15, "m", source="coils of 1 to 2 km"),
    layer_pitch_m=Span(0.13e-3, 0.17e-3, "m", source="fibre of 135 to 165 µm, nested"),
    turn_pitch_m=Span(0.14e-3, 0.18e-3, "m", source="fibre of 135 to 165 µm, side by side"),
    glass_fraction=Span(0.28, 0.33, "1", source="80 µm in 135 µm: 0.31"),
    winding_error_turns=Span(0.1, 0.5, "1"),
    trimmed=Span(0.7, 0.95, "1", log=False, source="Senol 2024, Sci. Rep., brings windings to ±0.05 °/h at any rate"),
    housing_j_per_k=Span(900.0, 2000.0, "J/K"),
    spool_j_per_k=Span(150.0, 400.0, "J/K"),
    package_s=Span(1200.0, 3600.0, "s"),
    random_walk=Span(2e-4, 1e-3, "°/√h"),
    flicker=Span(2e-4, 2e-3, "°/h"),
    rate_random_walk=Span(1e-4, 1e-3, "°/h/√h"),
    effects={name: (low / 10, high / 10) for name, (low, high) in MEDIUM.effects.items()} | {"fixture_rotation": TWIST},
)
