"""Shared by the rules of chapter 5: its folder, and the machine that its descriptors were calculated for."""

from millprint.predict.catalogue import EVERY_MODEL, MODELS, otherwise, searched_again

YIELDS = f"{RESULTS}/yield"
# The machine of the cases of chapter 4, whose descriptors follow from the master curves. The mill gives the amplitude.
YIELD_CONTACT = CONTACTS[CONFIG.partition.contact]
YIELD_MACHINE = {
    "reference_speed": CONFIG.partition.reference_speed_rpm / 60,
    "density": YIELD_CONTACT.density_kg_m3,
    "diameter": CONFIG.partition.ball_diameter_mm * 1e-3,
}
