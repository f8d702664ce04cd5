"""The impact of an elastic sphere with partial slip in its contact: a reference line, not our contact law.

Where friction and elastic displacement act together, the rim of a contact slides while its middle sticks. Our law has
one spring for the whole contact, which either sticks or slides. The difference shows what the law leaves out.
"""

import math

import numpy as np

from millprint.config.contact_set import ContactConfig
from millprint.dem.law import damping_ratio
from millprint.validation.rebound import Rebound, impact_duration, largest_overlap

STEPS, SPRINGS = 2000, 300


def partial_slip(
    contact: ContactConfig, radius: float, normal: float, tangential: float, steps: int = STEPS, springs: int = SPRINGS
) -> Rebound:
    """Rebound of a sphere, without spin at first, from a plate of its own material (Maw, Barber and Fawcett 1976).

    By the method of dimensionality reduction (Lyashenko and Popov, Sci. Rep. 5, 8479, 2015): independent springs at x
    over the contact's diameter, pressed by d - x^2 / R; the stiffness of each is E* dx along the normal, G* dx across,
    with G* = 4 G / (2 (2 - nu)), and each slides separately at mu times its normal force. For Mindlin's contact the
    result is exact. The normal force is damped as in our law, the tangential force is not.

    radius [m]; normal, tangential: speeds before the impact [m/s].
    """
    modulus, poisson = contact.young_modulus_gpa * 1e9, contact.poisson_ratio
    stiffness = modulus / (2 * (1 - poisson**2))
    shear = modulus / ((2 - poisson) * (1 + poisson))
    mass = contact.density_kg_m3 * 4 / 3 * math.pi * radius**3
    damping = -2 * math.sqrt(5 / 6) * damping_ratio(contact.restitution)
    # A little wider than the largest contact.
    half = 1.02 * math.sqrt(radius * largest_overlap(contact, radius, normal))
    place = (np.arange(springs) + 0.5) * half / springs
    gap, width = place**2 / radius, 2 * half / springs
    step = impact_duration(contact, radius, normal) / steps
    drawn = np.zeros(springs)
    approach, along, spin = normal, tangential, 0.0
    overlap = 0.5 * step * approach
    while overlap > 0:
        pressed = np.maximum(overlap - gap, 0.0)
        # A spring that has left the plate loses its displacement.
        drawn = np.where(pressed > 0, drawn + (along - radius * spin) * step, 0.0)
        limit = contact.static_friction * stiffness / shear * pressed
        drawn = np.clip(drawn, -limit, limit)
        drag = shear * width * drawn.sum()
        root = math.sqrt(radius * overlap)
        push = 4 / 3 * stiffness * root * overlap + damping * math.sqrt(2 * stiffness * root * mass) * approach
        approach -= push / mass * step
        along -= drag / mass * step
        spin += 2.5 * drag / (mass * radius) * step
        overlap += approach * step
    return Rebound(normal, tangential, -approach, along, spin, radius)
