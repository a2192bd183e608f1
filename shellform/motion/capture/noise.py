# SPDX-License-Identifier: LGPL-3.0-or-later
"""Noise of markers: how much there is, and what of it a low pass leaves.

Noise that differs from frame to frame shows in the distance of every place from the cubic through
two neighbours on either side (`gaps_and_spikes.off_neighbours`): five frames of independent noise
with a deviation s along each axis put 1.394 s into each component (the square root of
1 + 2 (4/6)^2 + 2 (1/6)^2), and the median length of such a vector is 1.538 times that. Motion adds
little to it as long as frames come much faster than it changes.

The low pass with the gain 1 / (1 + (f/f0)^4) passes the part of white noise that the integral of
its square tells: of places 2 f0/r I0 of the variance with I0 = 3 pi / (8 sqrt 2), of accelerations
(2 pi f0)^4 2 f0/r I4 with I4 = pi sqrt 2 / 16, at r frames a second.
"""

from collections.abc import Mapping

import numpy as np

from .gaps_and_spikes import off_neighbours

NOTED = 3e-3  # rms from which on noise gets a note [m]
FAST = 8.0  # frames a second over the cutoff, from which on noise can be told from motion


def noise_of(track: np.ndarray) -> float:
    """Noise of a track (n, 3) [m], rms of its length over the three axes."""
    off = off_neighbours(track)[2:-2]
    return float(np.sqrt(3.0) * np.median(off) / (1.394 * 1.538)) if len(off) else 0.0


def residual_noise(noise: float, rate: float, cutoff: float) -> tuple[float, float]:
    """What `gaps_and_spikes.low_pass` leaves of white noise.

    Parameters
    ----------
    noise : float, rms [m]
    rate, cutoff : float [Hz], rate several times the cutoff

    Returns
    -------
    rms of the places [m] and of the accelerations [m/s^2]
    """
    corner = cutoff / 0.802
    place = np.sqrt(2 * corner / rate * 3 * np.pi / (8 * np.sqrt(2)))
    acceleration = np.sqrt(2 * corner / rate * np.pi * np.sqrt(2) / 16) * (2 * np.pi * corner) ** 2
    return noise * place, noise * acceleration


def noise_note(
    tracks: Mapping[str, np.ndarray], labels: Mapping[str, str], rate: float, cutoff: float | None
) -> list[str]:
    """Note (list of str) on the noise of tracks, name -> (n, 3) [m]; empty where it is small.

    Parameters
    ----------
    labels : dict, name -> label; rate : float [Hz]; cutoff : float [Hz] or None
    """
    if rate < FAST * (cutoff or 6.0):
        return []
    noise = {name: noise_of(track) for name, track in tracks.items()}
    usual, worst = float(np.median(list(noise.values()))), max(noise, key=lambda name: noise[name])
    if noise[worst] < NOTED:
        return []
    note = (
        f"markers shake by {1e3 * usual:.1f} mm rms, '{labels[worst]}' by {1e3 * noise[worst]:.1f}"
    )
    if cutoff is None:
        return [f"{note}, and nothing is filtered"]
    place, acceleration = residual_noise(noise[worst], rate, cutoff)
    return [
        f"{note}: the low pass leaves {1e3 * place:.1f} mm and {acceleration:.1f} m/s^2 of the "
        "latter"
    ]
