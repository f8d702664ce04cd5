"""The methods paragraph of a card, ready for a paper; every number is from the card."""

from millprint.card.card_model import Balls, ContactSet, MillingCard, Programme
from millprint.card.outcome_model import Temperature, WearLoss
from millprint.config.contact_laws import CONTACT_LAWS
from millprint.config.over_speed import NOMINAL_SPEED_M_S
from millprint.estimate.estimates import Estimate, Interval
from millprint.run.numbers import plain, prefix_of, three


def in_words(quantity: Estimate, ends: Interval | None = None) -> str:
    """A quantity with its unit and an interval: "221 µJ (203 to 240)"."""
    factor, unit = prefix_of(quantity.value, quantity.unit)
    text = three(factor * quantity.value) + ("" if unit == "-" else f" {unit}")
    return text if ends is None else f"{text} ({between(ends, factor)})"


def between(ends: Interval | Temperature | WearLoss, factor: float = 1.0) -> str:
    """The ends of an interval: "203 to 240"."""
    return f"{three(factor * ends.lower)} to {three(factor * ends.upper)}"


COOLING = {"still_air": "air at rest", "moving_air": "moving air", "water": "water"}


def charge_in_words(balls: Balls) -> str:
    """The balls: "24 balls of 10 mm"."""
    parts = [f"{group.number} of {group.diameter_mm:g} mm" for group in balls.sizes]
    if len(parts) == 1:
        return parts[0].replace(" of ", " balls of ", 1)
    return f"{balls.number} balls ({', '.join(parts)})"


def programme_in_words(programme: Programme) -> str:
    """Milling and pauses: "12.5 h in cycles of 30 min with a pause of 10 min each (8.33 h of milling)"."""
    text = f"{programme.duration_h:g} h"
    if not programme.cycle_min:
        return f"{text} without pauses"
    turned = ", the direction reversed after each" if programme.reversal else ""
    return (
        f"{text} in cycles of {programme.cycle_min:g} min, each with a pause of {programme.pause_min:g} min{turned} "
        f"({plain(programme.milling_h)} h of milling)"
    )


def experiment_sentences(card: MillingCard) -> list[str]:
    """What was milled, in which mill, and how."""
    machine, jar, balls = card.machine, card.jar, card.balls
    of = f" of {jar.material}" if jar.material else ""
    ball_material = f" of {balls.material.replace('_', ' ')}" if balls.material else ""
    charge = f"{charge_in_words(balls)}{ball_material} ({plain(balls.mass_g)} g, {balls.density_kg_m3:g} kg/m3)"
    filled = f"a fill ratio of {plain(balls.fill_ratio)}"
    where = f"in the mill '{machine.title}' (jar{of} of {jar.volume_ml:g} mL) at {machine.speed_rpm:g} rpm"
    if card.powder is None:
        first = f"The condition is that of {charge}, {filled}, {where}."
    else:
        ratio = plain(card.powder.ball_to_powder_ratio)
        milled = f"{plain(card.powder.mass_g)} g of {card.powder.name}"
        first = f"{milled} was milled {where}, with {charge}: {filled} and a ball-to-powder mass ratio of {ratio}."
    sentences = [first[0].upper() + first[1:]]
    if card.atmosphere:
        sentences.append(f"The jar was filled under {card.atmosphere}.")
    if card.programme:
        sentences.append(f"The programme lasted {programme_in_words(card.programme)}.")
    return sentences


def coefficient_in_words(contact: ContactSet, key: str) -> str:
    """A coefficient of ball on ball, at the nominal speed and at the ends of its table if it depends on the speed."""
    for table in contact.over_speed:
        if table.coefficient == key:
            ends = (f"{table.values[end]:.3g} at {table.speeds_m_s[end]:.3g} m/s" for end in (0, -1))
            return f"{getattr(contact, key):.3g} at hits of {NOMINAL_SPEED_M_S:g} m/s ({' and '.join(ends)})"
    return f"{getattr(contact, key):g}"


def cohesion_in_words(contact: ContactSet) -> str:
    """How bodies stick, as the end of a list; empty if they do not."""
    parts = [
        f"{key.split('_')[0]} on {key.split('_')[1]} {value:g} {'N' if key.endswith('N') else 'J/m2'}"
        for key, value in contact.cohesion.items()
    ]
    return f", cohesion by Derjaguin, Muller and Toporov: {', '.join(parts)}" if parts else ""


def simulation_sentences(card: MillingCard) -> list[str]:
    """How the numbers were computed, and the descriptors."""
    contact, found, software = card.contact_set, card.fingerprint, card.software
    runs = len(found.seeds)
    simulated = f"{runs} simulation{'s' if runs > 1 else ''} of {plain(found.revolutions)} turns in all" if runs else ""
    own = found.descriptors
    words = {name: in_words(quantity, quantity.scatter) for name, quantity in own.known.items()}
    # A lowered modulus is a matter of the time step; a reader who knows the material must see that it was meant.
    lowered = ", lowered for longer time steps" if "lowered" in contact.source else ""
    law = CONTACT_LAWS[contact.kind]
    *own_words, stiffness = [
        f"{name} {coefficient_in_words(contact, key)} {unit}".strip() for key, (name, unit) in law.told.items()
    ]
    interval = f"in brackets, the band in which a new simulation falls with {100 * found.probability:g} %"
    sentences = [
        f"The motion of the balls was computed by the discrete element method with a {law.title} "
        f"({''.join(f'{each}, ' for each in own_words)}static friction "
        f"{coefficient_in_words(contact, 'static_friction')}, rolling friction "
        f"{contact.rolling_friction:g}, {stiffness}{lowered}{cohesion_in_words(contact)}; contact set "
        f"'{contact.name}') in {software.name} {software.version}{f', {simulated}' if simulated else ''}.",
        f"The energy-weighted mean energy of a collision (sum of squares over sum) was "
        f"{words['weighted_normal_energy_J']} along the line of centres and "
        f"{words['weighted_tangential_energy_J']} along the surface; the power of a ball over it is "
        f"{words['weighted_normal_frequency_hz']} and {words['weighted_tangential_frequency_hz']}.",
        f"Where contacts of a pair (two balls, or a ball and a {found.collisions_by} of the wall) that followed each "
        f"other within {found.collision_gap_turns:g} turns count as one collision, a collision dissipated on average "
        f"{words['normal_energy_J']} along the line of centres and {words['tangential_energy_J']} along the surface, "
        f"and all collisions over the balls were {words['specific_frequency_hz']}. The walls supplied a power of "
        f"{words['wall_power_W']}, which all balls dissipated: {words['normal_power_W']} by compression, "
        f"{words['tangential_power_W']} by shear and {words['rolling_power_W']} by rolling ({interval}).",
    ]  # fmt: skip
    power = own.wall_power_W
    if power.contact:
        low, high = (end / power.value - 1 for end in (power.contact.lower, power.contact.upper))
        sentences.append(
            f"Contact parameters that were not measured leave the power uncertain from {100 * low:+.0f} to "
            f"{100 * high:+.0f} %."
        )
    return sentences


def consequence_sentences(card: MillingCard) -> list[str]:
    """Dose, temperatures and wear."""
    sentences = []
    if card.dose:
        dose = card.dose
        sentences.append(
            f"If every collision caught powder, a gram of powder received {in_words(dose.total_kJ_g)} "
            f"({in_words(dose.normal_kJ_g)} by compression, {in_words(dose.tangential_kJ_g)} by shear, "
            f"{in_words(dose.rolling_kJ_g)} by rolling)."
        )
    if card.heat:
        heat = card.heat
        body = heat.powder.peak_degC or heat.powder.steady_degC
        when = "reached" if heat.powder.peak_degC else "would reach, after long milling,"
        sentences.append(
            f"By a heat balance, cooled by {COOLING.get(card.jar.cooling, card.jar.cooling)}, the powder {when} "
            f"{three(body.median)} degC ({between(body)}; band of {100 * heat.probability:g} %)."
        )
    if card.wear:
        level = card.wear.probability
        interval = f"{100 * level:g} %" if level else "the range between single weighings, not an interval"
        sentences.append(
            f"Archard's law gives a wear of the balls of {three(card.wear.wear_g.value)} g "
            f"({between(card.wear.wear_g)}) and {three(card.wear.iron_percent.value)} % of iron in the powder "
            f"({between(card.wear.iron_percent)}; {interval})."
        )
    return sentences


def methods_paragraph(card: MillingCard) -> str:
    """The paragraph."""
    return " ".join([*experiment_sentences(card), *simulation_sentences(card), *consequence_sentences(card)])
