"""What the rules of chapter 5 share: where its files lie, and the machine behind its descriptors."""

from millprint.predict.catalogue import EVERY_MODEL, MODELS, otherwise, searched_again

YIELDS = f"{RESULTS}/yield"
# The machine of the chapter 4 cases, whose descriptors follow from their master curves; its amplitude is the mill's.
YIELD_CONTACT = CONTACTS[CONFIG.partition.contact]
YIELD_MACHINE = {
    "reference_speed": CONFIG.partition.reference_speed_rpm / 60,
    "density": YIELD_CONTACT.density_kg_m3,
    "diameter": CONFIG.partition.ball_diameter_mm * 1e-3,
}
